//! A certificate as HTML: one file without script and network, for the screen and for paper.

use crate::certificate::sheet::{BLANK, Sheet};
use crate::page::html;
use crate::page::template;
use common::Error;
use minijinja::context;

/// The certificate as HTML that is well-formed XML as well, for a size of paper by its name in CSS; without
/// one the printer's counts.
///
/// # Errors
///
/// Where its template is wrong.
pub fn render(sheet: &Sheet, paper: Option<&str>) -> Result<String, Error> {
    let context = context! {
        number => sheet.number,
        style => include_str!("style.css"),
        page_rule => page_rule(sheet.number.as_deref(), paper),
        blank => BLANK,
        laboratory => sheet.laboratory,
        blanks => sheet.blank().join("; "),
        notes => sheet.notes,
        parts => sheet.parts.iter().map(|part| html::section(part, 1)).collect::<Vec<_>>(),
    };
    template::rendered(&template::html(), include_str!("certificate.html.jinja"), context)
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

#[cfg(test)]
mod tests {
    #[test]
    fn no_number_ends_the_style() {
        assert_eq!(super::css_string("A-1"), "\"A\\2d 1\"");
        let hostile = super::css_string("\"; } </style><script>\\\u{1}");
        assert!(!hostile.contains('<') && hostile.matches('"').count() == 2, "{hostile}");
    }
}
