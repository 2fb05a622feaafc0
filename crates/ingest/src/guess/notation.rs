//! How a text file writes its table: separator, decimal mark, comments, the lines above the rows.

use tables::{COLUMN_LIMIT, Place};

use crate::Error;
use crate::clock;
use crate::delimited::{fields, too_many};
use crate::mapping::Mapping;
use crate::text::{Source, decoded, lines};
use crate::units;

/// What may stand between thousands. A blank is not told from a separator.
const THOUSANDS: [char; 4] = [',', '.', '\'', '_'];
const HEAD: usize = 1000;

/// A notation; by default that of formats that have but one.
#[derive(Default)]
pub struct Notation {
    /// As a mapping states it, still without columns.
    pub mapping: Mapping,
    /// Whether a comma before three digits might as well be the decimal mark.
    pub thousands_are_doubtful: bool,
    pub width: usize,
    pub names: Option<Vec<String>>,
    pub units: Option<Vec<Option<String>>>,
    pub rows: Vec<Vec<String>>,
}

impl Notation {
    pub fn number(&self, cell: &str) -> Option<f64> {
        let Mapping { decimal, thousands, .. } = self.mapping;
        number(cell, decimal).or_else(|| grouped(cell, decimal, thousands?))
    }

    pub fn of(source: &Source, rows: usize) -> Result<Self, Error> {
        let all = lines(&source.bytes).filter(|(_, line)| !line.trim_ascii().is_empty());
        let all: Vec<(u32, &[u8])> = all.take(HEAD + rows).collect();
        let begins = |line: &[u8], mark: &str| line.trim_ascii_start().starts_with(mark.as_bytes());
        let mut marks = ["#", "%", "//", "!"].into_iter();
        let comment = marks.find(|mark| all.first().is_some_and(|(_, line)| begins(line, mark)));
        let is_comment = |line: &[u8]| comment.is_some_and(|mark| begins(line, mark));
        let table: Vec<(u32, &[u8])> = all.iter().copied().filter(|(_, line)| !is_comment(line)).collect();
        let none = |found: &str| {
            let expected = "rows of readings; was it copied in full, and is it a file of readings?";
            Err(source.fault(Place::Whole, found, expected))
        };
        let Some(separator) = separator(&table) else {
            return none(if table.len() == 1 { "one line of words and no row" } else { "no row of numbers" });
        };
        let mut widths = table.iter().map(|(number, line)| (*number, fields(line, separator).len()));
        if let Some((line, width)) = widths.find(|(_, width)| *width > COLUMN_LIMIT) {
            return Err(too_many(source, line, width));
        }
        let of_line = |line: &[u8]| -> Vec<String> {
            fields(line, separator).into_iter().map(|field| decoded(field).trim().to_string()).collect()
        };
        let Some(first) = table.iter().position(|(_, line)| is_row(&of_line(line))) else {
            return none("a header and no row");
        };
        let cells: Vec<Vec<String>> =
            table[first..].iter().take(rows).map(|(_, line)| of_line(line)).collect();
        let width = cells[0].len();
        let decimal = decimal(&cells, separator);
        let (thousands, thousands_are_doubtful) = thousands(&cells, decimal);
        let comment_mark = comment.map(str::to_string);
        let mapping = Mapping { separator, decimal, thousands, comment: comment_mark, ..Mapping::default() };
        let mut notation =
            Notation { mapping, thousands_are_doubtful, width, rows: cells, ..Notation::default() };
        // Lines of words above the first row with as many fields; the topmost has the names. A comment may be
        // it.
        let above = table[..first].iter().rev().take_while(|(_, line)| {
            let cells = of_line(line);
            cells.len() == width && cells.iter().all(|cell| number(cell, '.').is_none())
        });
        let above: Vec<(u32, Vec<String>)> = above.map(|(number, line)| (*number, of_line(line))).collect();
        let first_line = table[first].0;
        if let Some((number, names)) = above.last() {
            notation.mapping.header_line = Some(*number);
            notation.names = Some(names.clone());
            notation.mapping.first_row_line =
                (first_line > number + 1 && above.len() > 1).then_some(first_line);
            notation.units =
                above.iter().rev().nth(1).filter(|(_, cells)| are_units(cells)).map(|(_, cells)| {
                    cells.iter().map(|cell| units::is_known(cell).then(|| cell.clone())).collect()
                });
        } else if let Some(mark) = comment {
            let last = all.iter().take_while(|(number, _)| *number < first_line).last();
            let names = last.map(|(number, line)| {
                (*number, of_line(line.trim_ascii_start().strip_prefix(mark.as_bytes()).unwrap_or(line)))
            });
            if let Some((number, names)) = names.filter(|(_, names)| names.len() == width && !is_row(names)) {
                notation.mapping.header_line = Some(number);
                notation.names = Some(names);
            }
        }
        Ok(notation)
    }
}

/// Whether cells are those of a row: half of them numbers or times, and one at least.
fn is_row(cells: &[String]) -> bool {
    let count = cells.iter().filter(|cell| is_value(cell)).count();
    let there = cells.iter().filter(|cell| !is_missing(cell)).count();
    count > 0 && 2 * count >= there
}

/// Whether a cell holds nothing, as it stands or in one of the words for that.
pub fn is_missing(cell: &str) -> bool {
    let text = cell.trim();
    let words = ["nan", "null", "na", "-"];
    text.is_empty() || words.iter().any(|word| text.eq_ignore_ascii_case(word))
}

fn is_value(cell: &str) -> bool {
    let text = cell.trim();
    number(text, '.').is_some()
        || number(text, ',').is_some()
        || ['.', ',']
            .into_iter()
            .any(|decimal| THOUSANDS.into_iter().any(|mark| grouped(text, decimal, mark).is_some()))
        || clock::iso(text.as_bytes()).is_some()
        || clock::time_of_day(text.as_bytes()).is_some_and(|(_, end)| end == text.len())
        || is_date(text)
}

/// Digits between dots, slashes or colons, a time after it: 01.09.2011 12:00.
fn is_date(text: &str) -> bool {
    let marks = text.chars().filter(|letter| matches!(letter, '.' | '/' | '-' | ':')).count();
    marks >= 2
        && text.starts_with(|letter: char| letter.is_ascii_digit())
        && text.chars().all(|letter| letter.is_ascii_alphanumeric() || " .:/-+".contains(letter))
}

fn are_units(cells: &[String]) -> bool {
    cells.iter().any(|cell| units::is_known(cell))
}

/// The separator by which most cells of the last lines are values; of equals, the one with most cells.
fn separator(table: &[(u32, &[u8])]) -> Option<char> {
    const LAST: usize = 40;
    let lines = &table[table.len().saturating_sub(LAST)..];
    let share = |separator: char| {
        let (mut values, mut all) = (0, 0);
        for (_, line) in lines {
            let cells: Vec<&[u8]> = fields(line, separator).into_iter().take(COLUMN_LIMIT).collect();
            all += cells.iter().filter(|cell| !cell.trim_ascii().is_empty()).count();
            values += cells.iter().filter(|cell| is_value(&decoded(cell))).count();
        }
        (values, all)
    };
    let scored = [';', '\t', ',', '|', ' '].map(|separator| (separator, share(separator)));
    let best = scored.into_iter().filter(|(_, (values, _))| *values > 0).max_by(|(_, a), (_, b)| {
        let of = |(values, all): (usize, usize)| values as f64 / all.max(1) as f64;
        of(*a).total_cmp(&of(*b)).then(a.0.cmp(&b.0))
    });
    best.map(|(separator, _)| separator)
}

/// What stands between thousands, and whether that is doubtful: of "48,520" alone one cannot tell; of
/// "48,520.31" and "1,048,520" one can.
fn thousands(rows: &[Vec<String>], decimal: char) -> (Option<char>, bool) {
    let cells =
        || rows.iter().flatten().map(|cell| cell.trim()).filter(|cell| number(cell, decimal).is_none());
    let mark = THOUSANDS.into_iter().find(|mark| cells().any(|cell| grouped(cell, decimal, *mark).is_some()));
    let Some(mark) = mark else { return (None, false) };
    let mut found = cells().filter(|cell| grouped(cell, decimal, mark).is_some());
    let certain = !matches!(mark, ',' | '.')
        || found.any(|cell| cell.contains(decimal) || cell.matches(mark).count() > 1);
    (Some(mark), !certain)
}

/// A comma where more numbers have one than have a point.
fn decimal(rows: &[Vec<String>], separator: char) -> char {
    let with = |mark: char| {
        let cells = rows.iter().flatten().map(|cell| cell.trim());
        let marked = cells.filter(|cell| {
            cell.contains(mark)
                && (number(cell, mark).is_some()
                    || THOUSANDS.into_iter().any(|thousands| grouped(cell, mark, thousands).is_some()))
        });
        marked.count()
    };
    if separator != ',' && with(',') > with('.') { ',' } else { '.' }
}

/// A number with that decimal mark.
fn number(cell: &str, decimal: char) -> Option<f64> {
    let cell = cell.trim();
    if decimal == ',' && cell.contains('.') {
        return None;
    }
    cell.replace(decimal, ".").parse().ok().filter(|value: &f64| value.is_finite())
}

/// A number whose thousands are apart: with that decimal mark and that between thousands.
fn grouped(cell: &str, decimal: char, thousands: char) -> Option<f64> {
    let cell = cell.trim();
    let is_grouped = cell.contains(thousands) && thousands != decimal;
    crate::number::grouped(cell.as_bytes(), decimal as u8, thousands as u8)
        .filter(|value| is_grouped && value.is_finite())
}
