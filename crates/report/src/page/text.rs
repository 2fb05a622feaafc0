//! A page as text, for the terminal.

use std::fmt::Write;

use crate::page::plot::Plot;
use crate::page::{Cell, Item, Page, Table, number};

/// The page as text.
pub fn render(page: &Page) -> String {
    let mut out = String::new();
    underlined(&mut out, &page.title, '=');
    page.summary.iter().for_each(|words| line(&mut out, "", words));
    for section in &page.sections {
        out.push('\n');
        underlined(&mut out, &section.title, '-');
        section.words.iter().for_each(|words| line(&mut out, "", words));
        section.warnings.iter().for_each(|warning| line(&mut out, "! ", &warning.words));
        for item in &section.items {
            match item {
                Item::Heading(words) | Item::Words(words) => line(&mut out, "\n", words),
                Item::Table(table) => self::table(&mut out, table),
                Item::Plot(plot) => self::plot(&mut out, plot),
                Item::Field(_) | Item::Signature => {}
            }
        }
    }
    out
}

/// Without the control characters by which a document could move a terminal's cursor.
fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

fn line(out: &mut String, lead: &str, words: &str) {
    let _ = writeln!(out, "{lead}{}", plain(words));
}

fn underlined(out: &mut String, title: &str, line: char) {
    let title = plain(title);
    let _ = writeln!(out, "{title}\n{}", line.to_string().repeat(title.chars().count()));
}

fn table(out: &mut String, table: &Table) {
    let header = |header: &crate::page::Header| {
        let unit = if header.unit.is_empty() { String::new() } else { format!(", {}", header.unit) };
        plain(&format!("{}{unit}", header.name))
    };
    let heads = table.headers.iter().map(header).collect::<Vec<_>>();
    let cells = |row: &Vec<Cell>| row.iter().map(|cell| plain(&cell.to_string())).collect();
    let rows: Vec<Vec<String>> = table.rows.iter().map(cells).collect();
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column)).chain(heads.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let words = |column: usize| {
        table.rows.iter().any(|row| matches!(row.get(column), Some(Cell::Text(_) | Cell::Placed(..))))
    };
    let columns: Vec<(usize, bool)> = (0..heads.len()).map(|column| (width(column), words(column))).collect();
    let line = |cells: &[String]| {
        let pad = |(cell, (width, words)): (&String, &(usize, bool))| {
            let gap = " ".repeat(width - cell.chars().count());
            if *words { format!("{cell}{gap}") } else { format!("{gap}{cell}") }
        };
        let cells: Vec<String> = cells.iter().zip(&columns).map(pad).collect();
        format!("  {}", cells.join("  ")).trim_end().to_string()
    };
    let _ = writeln!(out, "\n{}\n{}", plain(&table.caption), line(&heads));
    for row in &rows {
        let _ = writeln!(out, "{}", line(row));
    }
}

/// A plot cannot be shown here: how many points each series has, and from where to where they go.
fn plot(out: &mut String, plot: &Plot) {
    let _ = writeln!(out, "\n{} (a plot on the page)", plain(&plot.title));
    for series in &plot.series {
        let span = |values: &mut dyn Iterator<Item = f64>| {
            number::ends(values).map_or("nothing".to_string(), |[low, high]| {
                format!("{} to {}", number::significant(low, 4), number::significant(high, 4))
            })
        };
        let x = span(&mut series.points.iter().map(|point| point.x));
        let y = span(&mut series.points.iter().map(|point| point.y));
        let [name, x_text, y_text] = [&series.name, &plot.x.text(), &plot.y.text()].map(|text| plain(text));
        let points = number::counted(series.values().count(), "point");
        let _ = writeln!(out, "  {name}: {points}, {x_text} {x}, {y_text} {y}");
    }
}
