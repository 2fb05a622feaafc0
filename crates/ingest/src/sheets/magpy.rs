//! MagPy's text sheets: a header, readings of the mark (`Miren:`), positions, readings of F (`PPM:`).
//!
//! `2018-08-29_07:16:00  250.19194  90  0.6`: time in UTC, horizontal and vertical circle, residual in nT. The null
//! method has each line twice; it is one reading.

mod header;

use common::number::counted;
use tables::Place;

use super::Sheet;
use super::faces::{self, Line};
use super::row::{Row, complete, moment, turn};
use crate::Error;
use crate::text::{Source, decoded, lines, quoted};
use header::{Header, number as value};

pub use header::is_meant;

/// Pairs of readings of the mark; the telescope was turned over between one and the next.
const PAIRS: [&str; 4] =
    ["first pair, before", "second pair, before", "third pair, after", "fourth pair, after"];

#[derive(Default)]
struct Body {
    marks: Vec<f64>,
    marks_line: u32,
    positions: Vec<Line>,
    scalars: Vec<Row>,
    /// Lines that say what the one before them said.
    repeated: usize,
}

/// Reads a sheet. Errors: lines that are none, circles in another unit than the header's, positions and
/// readings of the mark that are missing.
pub fn read(source: &Source) -> Result<Sheet, Error> {
    let mut sheet = Sheet::of(source, "MagPy's sheet of absolute measurements");
    let header = Header::read(source, &mut sheet)?;
    let Body { mut marks, marks_line, positions, scalars, repeated } =
        body(source, &header, &mut sheet.notes)?;
    check_marks(source, marks_line, &marks)?;
    let up = positions.first().is_some_and(|east| faces::first_is_up(marks[0], header.azimuth_deg, east));
    let rows = faces::rows(&positions).map_err(|(line, near)| {
        let found = format!("{:.4}° for the vertical circle", line.vertical);
        let expected = format!(
            "90 or 270 for the declination, or near one of {near} for the inclination; was it misread?"
        );
        source.in_line(line.number, found, expected)
    })?;
    let is_double = repeated >= rows.len() && marks.chunks(2).all(|pair| pair[0] == pair[1]);
    if is_double {
        marks = marks.into_iter().step_by(2).collect();
    }
    if repeated > 0 {
        let (lines, more) =
            (counted(repeated, "line"), if is_double { ", those of the mark as well" } else { "" });
        sheet
            .notes
            .push(format!("{lines} that repeat the one before (the null method) are one reading{more}"));
    }
    let face = |index: usize| up == (index * PAIRS.len() / marks.len()).is_multiple_of(2);
    sheet.rows =
        marks.iter().enumerate().map(|(index, mark)| Row::at("Mark", face(index), *mark, 0.0)).collect();
    sheet.rows.extend(rows);
    sheet.rows.extend(scalars);
    let place = positions.first().map_or(Place::Whole, |first| Place::Line(first.number.into()));
    complete(source, place, "positions", &sheet.rows)?;
    Ok(sheet)
}

fn body(source: &Source, header: &Header, notes: &mut Vec<String>) -> Result<Body, Error> {
    let mut body = Body::default();
    let mut section = String::new();
    for (number, line) in lines(&source.bytes) {
        let text = decoded(line);
        let cells: Vec<&str> = text.split_whitespace().collect();
        let fault = |expected: &str| Err(source.in_line(number, quoted(line), expected));
        match (section.as_str(), cells.as_slice()) {
            (_, []) => {}
            (_, [title]) if title.ends_with(':') && !title.starts_with('#') => {
                section = title.trim_end_matches(':').to_lowercase();
                if !["miren", "positions", "ppm", "result"].contains(&section.as_str()) {
                    notes.push(format!("the section {title} is not read"));
                }
            }
            ("miren", cells) => {
                body.marks_line = number;
                for cell in cells {
                    let Some(value) = value(cell) else {
                        return fault("readings of the mark, numbers alone");
                    };
                    body.marks.push(header.degrees(source, number, value)?);
                }
            }
            ("positions", cells) => {
                let read = match cells {
                    [time, circles @ .., residual] if circles.len() == 2 => {
                        (moment(time), value(circles[0]), value(circles[1]), value(residual))
                    }
                    _ => (None, None, None, None),
                };
                let (Some(time_ns), Some(horizontal), Some(vertical), Some(residual_nt)) = read else {
                    return fault(
                        "time, horizontal and vertical circle, and residual in nT, as in 2018-08-29_07:16:00  250.19  90  0.6",
                    );
                };
                let degrees = |value| header.degrees(source, number, value);
                let (horizontal, vertical) = (degrees(horizontal)?, degrees(vertical)?);
                let line = Line { number, time_ns, horizontal, vertical, residual_nt };
                if body.positions.is_empty() && !line.is_level() {
                    let (quarter, remedy) = (header.turn / 4.0, header.remedy);
                    return fault(&format!(
                        "{quarter} or {} for the vertical circle, as a sheet begins with the declination; {remedy}",
                        3.0 * quarter
                    ));
                }
                if body.positions.last().is_some_and(|last| Line { number, ..*last } == line) {
                    body.repeated += 1;
                } else {
                    body.positions.push(line);
                }
            }
            ("ppm", cells) => {
                let read = if let [time, f] = cells { moment(time).zip(value(f)) } else { None };
                let Some((time_ns, f_nt)) = read else {
                    return fault("time and F in nT, as in 2018-08-29_07:16:00  48500.8");
                };
                body.scalars.push(Row::scalar(time_ns, f_nt));
            }
            _ => {}
        }
    }
    Ok(body)
}

/// Whether the mark was read twice in each pair, and the pairs are half a circle apart by turns.
fn check_marks(source: &Source, line: u32, marks: &[f64]) -> Result<(), Error> {
    let face = |pair: usize| (marks.first().unwrap_or(&f64::NAN) + 180.0 * (pair % 2) as f64) % 360.0;
    let is_whole = |pair: usize| {
        let both = marks.get(2 * pair..2 * pair + 2);
        both.is_some_and(|both| both.iter().all(|mark| turn(*mark, face(pair)).abs() < 90.0))
    };
    let expected = match (0..4).find(|pair| !is_whole(*pair)) {
        None if marks.len() == 8 => return Ok(()),
        None => "8, in four pairs; take out what is too many".to_string(),
        Some(pair) => format!(
            "8, in four pairs with the telescope turned over by turns; one near {:.4}° is missing in the {} the positions: write it in",
            face(pair),
            PAIRS[pair]
        ),
    };
    let place = if line == 0 { Place::Whole } else { Place::Line(line.into()) };
    Err(source.fault(place, format!("{} of the mark", counted(marks.len(), "reading")), expected))
}
