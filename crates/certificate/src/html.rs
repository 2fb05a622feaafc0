//! A certificate as HTML: one file without script and network, for the screen and for paper.

use page::words::escape;
use page::{Cell, Header, Table};
use std::fmt::Write;

use crate::sheet::{BLANK, Field, Item, Part, Sheet};

const STYLE: &str = include_str!("style.css");
/// A table with fewer rows stays on one page.
const SHORT: usize = 10;
/// Words in a cell that are longer may be broken.
const WHOLE: usize = 28;
/// No longer than a day, which is not broken on paper either.
const DAY: usize = 10;
/// A table with more columns is shown as a list on a phone.
const WIDE: usize = 4;
/// A field with more lines may be broken between pages.
const LINES: usize = 8;

/// The certificate as HTML that is well-formed XML as well, for a size of paper by its name in CSS; without
/// one the printer's counts.
pub fn render(sheet: &Sheet, paper: Option<&str>) -> String {
    let number = sheet.number.as_deref();
    let name = number
        .map_or("Calibration certificate".to_string(), |number| format!("Calibration certificate {number}"));
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{}</title>\n<style>\n{STYLE}{}</style>\n</head>\n<body>\n<header>\n",
        escape(&name),
        page_rule(number, paper)
    );
    let number = number.map_or_else(
        || blank("7.8.2.1 d"),
        |number| format!("<b>{}</b> {}", escape(number), clause("7.8.2.1 d")),
    );
    let _ = writeln!(out, "<h1>Calibration certificate {}</h1>", clause("7.8.2.1 a"));
    let _ = writeln!(out, "<p class=\"number\">No. {number}</p>\n<dl>");
    sheet.laboratory.iter().for_each(|one| field(&mut out, one));
    out.push_str("</dl>\n</header>\n");
    notes(&mut out, sheet);
    sheet.parts.iter().for_each(|one| part(&mut out, one));
    let of = sheet.number.as_deref().map_or_else(|| blank("7.8.2.1 d"), escape);
    let _ =
        writeln!(out, "<p class=\"end\">End of the calibration certificate No. {of}</p>\n</body>\n</html>");
    out
}

/// Margins of each page with the identification and the page's number (CSS Paged Media, margin boxes).
fn page_rule(number: Option<&str>, paper: Option<&str>) -> String {
    let size = paper.map_or(String::new(), |paper| format!(" size: {paper};"));
    let number = number.map_or_else(|| format!("No. {BLANK} (7.8.2.1 d)"), |number| format!("No. {number}"));
    let font = "font: 8pt \"Liberation Sans\", Arial, \"DejaVu Sans\", sans-serif; color: #59626b;";
    format!(
        "@page {{{size} margin: 18mm 16mm 20mm 18mm;\n  @top-left {{ content: \"Calibration certificate \" {0}; {font} }}\n  \
         @bottom-right {{ content: \"Page \" counter(page) \" of \" counter(pages); {font} }}\n}}\n",
        css_string(&number)
    )
}

/// A text as a string of CSS: whatever is not a letter or a digit is escaped, so that none of it ends the
/// string or the style.
fn css_string(text: &str) -> String {
    let one =
        |c: char| if c.is_ascii_alphanumeric() { c.to_string() } else { format!("\\{:x} ", u32::from(c)) };
    format!("\"{}\"", text.chars().filter(|c| !c.is_control()).map(one).collect::<String>())
}

fn clause(clause: &str) -> String {
    format!("<span class=\"clause\">({clause})</span>")
}

fn blank(of: &str) -> String {
    format!("<span class=\"blank\">{BLANK}</span> {}", clause(of))
}

/// What is to be settled before it is issued.
fn notes(out: &mut String, sheet: &Sheet) {
    let blank = sheet.blank();
    if blank.is_empty() && sheet.notes.is_empty() {
        return;
    }
    out.push_str("<aside class=\"notes\">\n<p><b>Draft: to be settled before issue</b></p>\n<ul>\n");
    if !blank.is_empty() {
        let _ = writeln!(out, "<li>Blank: {}.</li>", escape(&blank.join("; ")));
    }
    for note in &sheet.notes {
        let _ = writeln!(out, "<li>{}</li>", escape(note));
    }
    out.push_str("</ul>\n</aside>\n");
}

fn part(out: &mut String, part: &Part) {
    let _ = writeln!(out, "<section>\n<h2>{} {}</h2>", escape(&part.title), clause(&part.clauses));
    let is_field = |item: &Item| matches!(item, Item::Field(_));
    for group in part.items.chunk_by(|a, b| is_field(a) && is_field(b)) {
        if is_field(&group[0]) {
            out.push_str("<dl>\n");
        }
        for item in group {
            match item {
                Item::Field(one) => field(out, one),
                Item::Signature => out.push_str("<p class=\"sign\">Signature and date</p>\n"),
                Item::Page(page::Item::Heading(heading)) => {
                    let _ = writeln!(out, "<h3>{}</h3>", escape(heading));
                }
                Item::Page(page::Item::Words(words)) => {
                    let _ = writeln!(out, "<p>{}</p>", escape(&words.replace('`', "")));
                }
                Item::Page(page::Item::Table(one)) => table(out, one),
                Item::Page(page::Item::Plot(_)) => {}
            }
        }
        if is_field(&group[0]) {
            out.push_str("</dl>\n");
        }
    }
    out.push_str("</section>\n");
}

fn field(out: &mut String, field: &Field) {
    let long = if field.lines.len() > LINES { " long" } else { "" };
    let code = if field.label == "SHA-256" { " code" } else { "" };
    let label = escape(&field.label);
    let _ = write!(out, "<div class=\"field{long}{code}\"><dt>{label}");
    if !field.lines.is_empty() {
        let _ = write!(out, " {}", clause(&field.clause));
    }
    out.push_str("</dt><dd>");
    if field.lines.is_empty() {
        out.push_str(&blank(&field.clause));
    }
    for line in &field.lines {
        let _ = write!(out, "<p>{}</p>", escape(line));
    }
    out.push_str("</dd></div>\n");
}

fn table(out: &mut String, table: &Table) {
    let filled = |column: usize| table.rows.iter().any(|row| !matches!(row[column], Cell::Empty));
    let kept: Vec<usize> = (0..table.headers.len()).filter(|column| filled(*column)).collect();
    let short = if table.rows.len() < SHORT { "short" } else { "" };
    let wide = if kept.len() > WIDE { " wide" } else { "" };
    let _ = writeln!(
        out,
        "<div class=\"scroll\"><table class=\"{short}{wide}\">\n<thead><tr><th class=\"caption\" colspan=\"{}\">{}</th></tr>",
        kept.len(),
        escape(&table.caption)
    );
    out.push_str("<tr>");
    for Header { name, unit } in kept.iter().map(|column| &table.headers[*column]) {
        let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
        let _ = write!(out, "<th scope=\"col\">{}</th>", escape(&format!("{name}{unit}")));
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    for row in &table.rows {
        out.push_str("<tr>");
        for (place, column) in kept.iter().enumerate() {
            let text = row[*column].to_string();
            let class = match text.chars().count() {
                _ if text.contains(BLANK) => "",
                letters if letters <= DAY => " class=\"day\"",
                letters if letters <= WHOLE => " class=\"whole\"",
                _ => "",
            };
            let text = escape(&text);
            let label = escape(&table.headers[*column].name);
            let _ = match place {
                0 => write!(out, "<th scope=\"row\">{text}</th>"),
                _ => write!(out, "<td{class} data-label=\"{label}\">{text}</td>"),
            };
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody>\n</table></div>\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_ends_the_style() {
        assert_eq!(css_string("A-1"), "\"A\\2d 1\"");
        let hostile = css_string("\"; } </style><script>\\\u{1}");
        assert!(!hostile.contains('<') && hostile.matches('"').count() == 2, "{hostile}");
    }
}
