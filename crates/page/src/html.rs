//! A page as HTML: one file, no network, no script.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;

use crate::plot::{self, Plot};
use crate::words::escape;
use crate::{Cell, Header, Item, Page, Section, Table, number};

const STYLE: &str = include_str!("style.css");
/// A table with more rows is folded.
const FOLDED: usize = 12;
/// Words in a cell that are longer may be broken.
const SHORT: usize = 28;
/// A plot with more rows has them in its data alone.
const IN_TABLE: usize = 200;

/// The page as HTML that is well-formed XML as well.
pub fn render(page: &Page) -> String {
    let title = escape(&page.title);
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n"
    );
    paragraphs(&mut out, &page.summary);
    out.push_str("</header>\n");
    if page.sections.len() > 1 {
        contents(&mut out, page);
    }
    out.push_str("<main>\n");
    for part in &page.sections {
        section(&mut out, part);
    }
    out.push_str("</main>\n</body>\n</html>\n");
    out
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

fn contents(out: &mut String, page: &Page) {
    out.push_str("<nav aria-label=\"Contents\">\n<ol>\n");
    for part in &page.sections {
        let mark = if part.warnings.is_empty() { "" } else { " <span class=\"mark\">△</span>" };
        let _ = writeln!(out, "<li><a href=\"#{}\">{}</a>{mark}</li>", part.id, escape(&part.title));
    }
    out.push_str("</ol>\n</nav>\n");
}

fn section(out: &mut String, part: &Section) {
    let _ = writeln!(out, "<section id=\"{}\">\n<h2>{}</h2>", part.id, escape(&part.title));
    paragraphs(out, &part.words);
    if !part.warnings.is_empty() {
        out.push_str("<ul class=\"warnings\">\n");
        for warning in &part.warnings {
            let _ = writeln!(out, "<li>{}</li>", prose(&warning.words));
        }
        out.push_str("</ul>\n");
    }
    let is_plot = |item: &Item| matches!(item, Item::Plot(_));
    for group in part.items.chunk_by(|a, b| is_plot(a) && is_plot(b)) {
        if is_plot(&group[0]) {
            out.push_str("<div class=\"plots\">\n");
        }
        for item in group {
            match item {
                Item::Heading(heading) => {
                    let _ = writeln!(out, "<h3>{}</h3>", escape(heading));
                }
                Item::Words(words) => paragraphs(out, std::slice::from_ref(words)),
                Item::Table(table) => self::table(out, table),
                Item::Plot(plot) => figure(out, plot),
            }
        }
        if is_plot(&group[0]) {
            out.push_str("</div>\n");
        }
    }
    out.push_str("</section>\n");
}

fn paragraphs(out: &mut String, all: &[String]) {
    for words in all {
        let _ = writeln!(out, "<p>{}</p>", prose(words));
    }
}

fn table(out: &mut String, table: &Table) {
    let caption = escape(&table.caption);
    if table.rows.len() > FOLDED {
        folded(out, &format!("{caption} ({})", number::counted(table.rows.len(), "row")), table);
    } else {
        let _ = writeln!(out, "<p class=\"caption\">{caption}</p>");
        grid(out, table);
    }
}

fn folded(out: &mut String, summary: &str, table: &Table) {
    let _ = writeln!(out, "<details>\n<summary>{summary}</summary>");
    grid(out, table);
    out.push_str("</details>\n");
}

fn grid(out: &mut String, table: &Table) {
    let _ = writeln!(out, "<div class=\"scroll\"><table aria-label=\"{}\">", escape(&table.caption));
    out.push_str("<thead><tr>");
    for Header { name, unit } in &table.headers {
        let _ = write!(out, "<th scope=\"col\">{}", escape(name));
        if !unit.is_empty() {
            let _ = write!(out, " <span class=\"unit\">{}</span>", escape(unit));
        }
        out.push_str("</th>");
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    for row in &table.rows {
        out.push_str("<tr>");
        for (column, cell) in row.iter().enumerate() {
            let text = escape(&cell.to_string());
            let broken = matches!(cell, Cell::Text(_)) && text.chars().count() > SHORT;
            let class = if broken { "" } else { " class=\"whole\"" };
            let _ = match column {
                0 => write!(out, "<th scope=\"row\"{class}>{text}</th>"),
                _ => write!(out, "<td{class}>{text}</td>"),
            };
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody>\n</table></div>\n");
}

fn figure(out: &mut String, plot: &Plot) {
    let undrawn = plot.undrawn();
    let (plot, thinned) = plot::thinned(plot.clone());
    let class = if plot.map { " class=\"map\"" } else { "" };
    let _ =
        writeln!(out, "<figure{class} id=\"{}\">\n<figcaption>{}</figcaption>", plot.id, escape(&plot.title));
    let _ = writeln!(out, "{}", plot::svg(&plot));
    if plot.series.len() > 1 || plot.map {
        out.push_str("<ul class=\"legend\">\n");
        for series in &plot.series {
            let _ = writeln!(out, "<li>{}{}</li>", plot::swatch(series), escape(&series.name));
        }
        out.push_str("</ul>\n");
    }
    let notes: Vec<String> = [Some(plot.note.clone()), undrawn, thinned].into_iter().flatten().collect();
    let notes = notes.join(" ");
    if !notes.trim().is_empty() {
        let _ = writeln!(out, "<p class=\"note\">{}</p>", prose(notes.trim()));
    }
    let count: usize = plot.series.iter().map(|series| series.values().count()).sum();
    let rows = number::counted(count, "row");
    if count <= IN_TABLE {
        folded(out, &format!("Numbers ({rows})"), &plot.table());
    }
    let _ = writeln!(
        out,
        "<p class=\"data\"><a download=\"{0}.csv\" href=\"data:text/csv;charset=utf-8;base64,{1}\">Data of this plot (CSV, {rows})</a></p>\n</figure>",
        plot.id,
        STANDARD.encode(plot.csv())
    );
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
