//! A page as HTML: one file, no network. Without its script it shows the same.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use minijinja::{Value, context};

use crate::page::plot::{self, Plot};
use crate::page::words::escape;
use crate::page::{Cell, Finding, Item, Page, Section, Table, number, template};

/// A table with more rows is folded.
const FOLDED: usize = 12;
/// Words in a cell that are longer may be broken.
const SHORT: usize = 28;
/// A plot with more rows has them in its data alone.
const IN_TABLE: usize = 200;

/// The page as HTML that is well-formed XML as well.
///
/// # Errors
///
/// Where its template is wrong.
pub fn render(page: &Page) -> Result<String, common::Error> {
    let plots = page.sections.iter().flat_map(|section| &section.items).filter_map(|item| match item {
        Item::Plot(plot) => Some(plot.as_ref()),
        _ => None,
    });
    let rows = plot::rows_per_entry(plots);
    let mut environment = template::html();
    environment.add_filter("prose", |words: String| Value::from_safe_string(prose(&words)));
    let context = context! {
        title => page.title,
        style => include_str!("style.css"),
        script => concat!(include_str!("drawing.js"), include_str!("script.js")),
        summary => page.summary,
        sections => page.sections.iter().map(|part| section(part, rows)).collect::<Vec<_>>(),
    };
    template::rendered(&environment, include_str!("page.html.jinja"), context)
}

/// Escaped words, with what stands between backticks as code.
fn prose(words: &str) -> String {
    let escaped = escape(words);
    let parts: Vec<&str> = escaped.split('`').collect();
    if parts.len().is_multiple_of(2) {
        return escaped;
    }
    let part = |(number, part): (usize, &&str)| {
        if number % 2 == 1 { format!("<code>{part}</code>") } else { part.to_string() }
    };
    parts.iter().enumerate().map(part).collect()
}

/// A section for a template, with so many rows of a plot in an entry of its data: neighbouring plots together,
/// neighbouring fields together, and every other item by itself.
pub fn section(section: &Section, rows: usize) -> Value {
    let together = |item: &Item| match item {
        Item::Plot(plot) => Some(plot.stacked),
        Item::Field(_) => Some(false),
        _ => None,
    };
    let groups = section.items.chunk_by(|a, b| together(a).is_some() && together(a) == together(b));
    context! {
        id => section.id,
        title => section.title,
        words => section.words,
        warnings => section.warnings.iter().map(warning).collect::<Vec<_>>(),
        items => groups.map(|group| items(group, rows)).collect::<Vec<_>>(),
    }
}

fn items(group: &[Item], rows: usize) -> Value {
    let (mut plots, mut fields, mut stacked) = (Vec::new(), Vec::new(), false);
    for item in group {
        match item {
            Item::Heading(heading) => return context! { heading },
            Item::Words(words) => return context! { words },
            Item::Signature => return context! { signature => true },
            Item::Table(one) => {
                let rows = (one.rows.len() > FOLDED).then(|| number::counted(one.rows.len(), "row"));
                return context! { table => table(one), rows };
            }
            Item::Field(field) => fields.push(field),
            Item::Plot(plot) => {
                stacked = plot.stacked;
                plots.push(figure(plot, rows));
            }
        }
    }
    context! { stacked, plots, fields }
}

fn warning(finding: &Finding) -> Value {
    let text = Value::from_safe_string(prose(&finding.words));
    context! { text, link => finding.place.as_ref().and_then(|place| place.link.as_ref()) }
}

fn table(table: &Table) -> Value {
    let cell = |cell: &Cell| {
        let text = cell.to_string();
        let is_short = || escape(&text).chars().count() <= SHORT;
        let (whole, link) = match cell {
            Cell::Placed(_, place) => (is_short(), place.link.as_ref()),
            Cell::Text(_) => (is_short(), None),
            _ => (true, None),
        };
        context! { text, whole, link }
    };
    let row = |row: &Vec<Cell>| row.iter().map(cell).collect::<Vec<_>>();
    context! {
        caption => table.caption,
        headers => table.headers,
        rows => table.rows.iter().map(row).collect::<Vec<_>>(),
    }
}

fn figure(plot: &Plot, rows: usize) -> Value {
    let undrawn = plot.undrawn();
    let data = plot::data(plot, rows);
    let (plot, thinned) = plot::thinned(plot.clone());
    let legend = plot.series.iter().filter(|_| plot.series.len() > 1 || plot.map);
    let legend = legend.map(|series| context! { swatch => plot::swatch(series), name => series.name });
    let notes: Vec<String> = [Some(plot.note.clone()), undrawn, thinned].into_iter().flatten().collect();
    let count: usize = plot.series.iter().map(|series| series.values().count()).sum();
    context! {
        id => plot.id,
        title => plot.title,
        map => plot.map,
        svg => plot::svg(&plot),
        legend => legend.collect::<Vec<_>>(),
        note => notes.join(" ").trim(),
        rows => number::counted(count, "row"),
        table => (count <= IN_TABLE).then(|| table(&plot.table())),
        csv => STANDARD.encode(plot.csv()),
        data,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_in_words() {
        assert_eq!(prose("a `b<` c"), "a <code>b&lt;</code> c");
        assert_eq!(prose("it`s"), "it`s");
    }
}
