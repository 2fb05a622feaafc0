//! The header of a sheet, of either age, and the unit of its circles.

use common::number::significant;
use serde_json::Value;
use tables::Place;

use super::Sheet;
use crate::Error;
use crate::clock;
use crate::text::{Source, decoded, lines, quoted};

/// Azimuths of the marks that old sheets name, degrees: the observatory on the Cobenzl, Vienna, as MagPy has them.
const MARKS: [(&str, f64); 4] =
    [("UA", 290.0), ("MireTower", 41.80333), ("MireChurch", 51.1831), ("MireCobenzl", 353.698)];
const OLD: [&str; 7] =
    ["Observer", "Theodolite", "AzimuthMark", "Pillar", "Scalar", "InputDate", "Temperature"];
const CONDITIONS: [(&str, &str); 4] = [
    ("Observer", "observer"),
    ("Theodolite", super::super::THEODOLITE),
    ("FGSensor", "magnetometer"),
    ("Pillar", "pillar"),
];

/// What of it is needed to read the rest.
pub struct Header {
    pub azimuth_deg: f64,
    pub turn: f64,
    unit: &'static str,
    /// What to do where they are in another one.
    pub remedy: &'static str,
}

pub fn is_meant(bytes: &[u8]) -> bool {
    let head = decoded(&bytes[..bytes.len().min(2000)]).to_lowercase();
    let mut lines = head.lines().map(str::trim).filter(|line| !line.is_empty());
    let (first, second) = (lines.next().unwrap_or_default(), lines.next().unwrap_or_default());
    first.starts_with("# magpy absolutes") || second == "miren:" && first.split_whitespace().count() > 3
}

/// A number, with a point or a comma.
pub fn number(text: &str) -> Option<f64> {
    clock::float(text.as_bytes(), b',').filter(|value| value.is_finite())
}

impl Header {
    /// Reads it; what it says goes to the sheet. Errors: an azimuth of the mark that is none, or that of a
    /// mark by an unknown name; a number that is none.
    pub fn read(source: &Source, sheet: &mut Sheet) -> Result<Self, Error> {
        let entries = entries(source);
        let of = |name: &str| entries.iter().find(|(_, key, _)| key == name);
        let fault = |line: u32, text: &str, expected: &str| {
            Err(source.in_line(line, quoted(text.as_bytes()), expected))
        };
        let (turn, unit, remedy) = match of("TheoUnit") {
            Some((_, _, text)) if text == "gon" => {
                (400.0, "gon", r##"if the circle reads degrees, write "# Abs-TheoUnit: deg""##)
            }
            Some((line, _, text)) if text != "deg" => {
                return fault(*line, text, "the unit of the circles, deg or gon");
            }
            _ => {
                let remedy = r##"if the circle reads gon, say so in the header: "# Abs-TheoUnit: gon" (in an old sheet multiply by 0.9)"##;
                (360.0, "degrees", remedy)
            }
        };
        let mut header = Header { azimuth_deg: 0.0, turn, unit, remedy };
        let asked = "azimuth of the mark as a number, from geographic north towards east and in the unit of the circles, such as 180.1372";
        let Some((line, _, mark)) = of("AzimuthMark") else {
            return Err(source.fault(
                Place::Whole,
                "no Abs-AzimuthMark in the header",
                format!("the {asked}"),
            ));
        };
        let by_name = MARKS.iter().find(|(name, _)| name == mark);
        header.azimuth_deg = match (number(mark), by_name) {
            (Some(azimuth), _) => header.degrees(source, *line, azimuth.abs())?.copysign(azimuth),
            (None, Some((name, azimuth))) => {
                sheet.notes.push(format!("the azimuth of {name} is {azimuth}°, as MagPy has it"));
                *azimuth
            }
            (None, None) => {
                return fault(*line, mark, &format!("the {asked}; write it in place of the name"));
            }
        };
        sheet.conditions.insert("mark_azimuth_deg".into(), header.azimuth_deg.rem_euclid(360.0).into());
        if let Some((line, _, text)) = of("DeltaF") {
            let Some(difference) = number(text) else {
                return fault(*line, text, "Abs-DeltaF in nT, which is added to F");
            };
            sheet.conditions.insert("pillar_difference_nt".into(), difference.into());
        }
        for (name, condition) in CONDITIONS {
            let text = of(name).map(|(_, _, text)| Value::from(text.as_str()));
            sheet.conditions.extend(text.map(|text| (condition.to_string(), text)));
        }
        let kept = entries.into_iter().map(|(_, name, text)| (name, Value::from(text)));
        sheet.kept.insert("header".into(), kept.collect());
        Ok(header)
    }

    /// A circle in degrees. Errors: one beyond a full turn, with what to do.
    pub fn degrees(&self, source: &Source, line: u32, value: f64) -> Result<f64, Error> {
        if (0.0..=self.turn).contains(&value) {
            return Ok(value * (360.0 / self.turn));
        }
        let found = format!("{} for a circle in {}", significant(value, 8), self.unit);
        Err(source.in_line(line, found, format!("0 to {}; {}", self.turn, self.remedy)))
    }
}

/// Line, name and text of each entry that says anything.
fn entries(source: &Source) -> Vec<(u32, String, String)> {
    let mut entries = Vec::new();
    let head = lines(&source.bytes).map(|(number, line)| (number, decoded(line)));
    for (number, line) in head.take_while(|(_, line)| !line.trim().eq_ignore_ascii_case("miren:")) {
        match line.trim().strip_prefix('#').map(|entry| entry.split_once(':')) {
            Some(None) => {}
            Some(Some((name, text))) => {
                let text = text.trim().trim_end_matches('|').trim().to_string();
                entries.push((number, name.trim().trim_start_matches("Abs-").to_string(), text));
            }
            None => entries.extend(
                OLD.iter()
                    .zip(line.split_whitespace())
                    .map(|(name, word)| (number, name.to_string(), word.to_string())),
            ),
        }
    }
    entries.retain(|(_, _, text)| !text.is_empty() && text != "None");
    entries
}
