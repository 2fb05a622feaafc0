//! What one file says, before files are joined.

use common::number::{bare, counted, quoted};
use common::{Extra, range};
use indexmap::IndexMap;

use crate::Error;
use crate::clock::Clock;
use crate::fill::{self, Fill};
use crate::mapping::Mapping;
use crate::parts::Rows;
use crate::raw;
use crate::text::Source;
use crate::times::Times;

#[derive(Clone, Debug)]
pub struct Piece {
    /// Its name alone.
    pub name: String,
    /// As messages name it.
    pub shown: String,
    pub sha256: String,
    /// `IAGA-2002`, `IAF`, `CSV`, `NDJSON`, `Parquet`, ….
    pub format: &'static str,
    /// What `times_ns` counts from.
    pub clock: Clock,
    pub times_ns: Vec<i64>,
    /// Values by the document's column names, in the document's units.
    pub columns: IndexMap<String, Vec<f64>>,
    /// Line (or row, from 1) of each.
    pub lines: Vec<u32>,
    /// The station's code, where the file states one.
    pub station: Option<String>,
    /// Kept in the document: the header of the file, how it was converted.
    pub header: Extra,
    pub notes: Vec<String>,
}

impl Piece {
    pub fn of(source: &Source, format: &'static str) -> Self {
        Piece {
            name: source.name.clone(),
            shown: source.shown.clone(),
            sha256: String::new(),
            format,
            clock: Clock::Utc,
            times_ns: Vec::new(),
            columns: IndexMap::new(),
            lines: Vec::new(),
            station: None,
            header: Extra::new(),
            notes: Vec::new(),
        }
    }

    /// A piece of rows that a mapping took: values converted, times brought to UTC.
    pub fn mapped(
        source: &Source,
        format: &'static str,
        mapping: &Mapping,
        times: &Times,
        mut rows: Rows,
    ) -> Result<Self, Error> {
        let mut piece = Piece::of(source, format);
        if rows.lines.is_empty() {
            return Err(source.no_row());
        }
        piece.clock = times.clock();
        times.settle(source, &mut rows, &mut piece.notes)?;
        for (column, mut values) in mapping.columns.iter().zip(rows.columns) {
            let conversion = column.conversion("columns")?;
            let Fill { missing, not_observed } = fill::without(&mut values, column.to.ends_with("_nt"));
            if missing + not_observed > 0 {
                let fills = counted(missing + not_observed, "fill value");
                piece.notes.push(format!("{fills} (99999, 88888, 1e31) of {}, taken as missing", column.to));
            }
            let (notes, no_integer) = raw::clean(column, &mut values);
            piece.notes.extend(notes);
            if let Some((row, expected)) = no_integer {
                let found = format!("{} for {}", quoted(values[row]), column.to);
                return Err(source.in_line(rows.lines[row], found, expected));
            }
            let values = match (conversion.factor, conversion.offset) {
                (1.0, 0.0) => values,
                (factor, 0.0) => values.into_iter().map(|value| value * factor).collect(),
                (factor, offset) => values.into_iter().map(|value| value * factor + offset).collect(),
            };
            if let Some(row) = range::first_beyond(&column.to, &values) {
                let [low, high] = range::bounds(&column.to).map(bare);
                let found = format!("{} for {}", quoted(values[row]), column.to);
                let expected = format!(
                    "a reading between {low} and {high}; name the value under `missing` of the mapping where it stands for none, or what is a reading under `valid`"
                );
                return Err(source.in_line(rows.lines[row], found, expected));
            }
            piece.columns.insert(column.to.clone(), values);
        }
        piece.times_ns = rows.times_ns;
        piece.lines = rows.lines;
        Ok(piece)
    }
}
