//! Parquet, as a mapping describes it.

use std::io::Cursor;
use tables::{Place, Reader};

use crate::Error;
use crate::mapping::{Mapping, SourceColumn};
use crate::parts::Rows;
use crate::piece::Piece;
use crate::text::Source;
use crate::times::Times;

/// Reads a file. Errors: a column of the mapping that is not there or holds no numbers; a time that is
/// missing or beyond the years 1677 to 2262.
pub fn read(source: &Source, mapping: &Mapping) -> Result<Piece, Error> {
    let times = Times::new(source, mapping.time.as_ref(), '.')?;
    let time = mapping.time.as_ref().map_or(&[][..], |time| time.columns.as_slice());
    if time.len() > 1 {
        let expected = "one column with the time, of numbers or of type TIMESTAMP";
        return Err(source.fault(Place::Whole, "a mapping with several columns of time", expected));
    }
    let wanted = time.iter().chain(mapping.columns.iter().map(|column| &column.from));
    let wanted: Vec<&str> = wanted.map(SourceColumn::name).collect();
    let missing: Vec<f64> = mapping.missing.iter().filter_map(|text| text.parse().ok()).collect();
    let mut rows = Rows { columns: vec![Vec::new(); mapping.columns.len()], ..Rows::default() };
    for batch in Reader::parquet(Cursor::new(source.bytes.clone()), &source.shown, Some(&wanted))? {
        let batch = batch?;
        rows.lines.extend((0..batch.rows() as u64).map(|row| (batch.first_row + row + 1) as u32));
        let mut columns = batch.columns.into_iter();
        if let (false, Some(column)) = (times.are_counted(), time.first()) {
            for (row, value) in columns.next().unwrap_or_default().into_iter().enumerate() {
                let moment = times.read_number(value).map_err(|expected| {
                    let (row, name) = (batch.first_row + row as u64 + 1, column.name().to_string());
                    let found = if value.is_nan() { "no time".into() } else { value.to_string() };
                    source.fault(Place::Row { row, name }, found, expected)
                })?;
                rows.times_ns.push(moment);
            }
        }
        for (all, mut values) in rows.columns.iter_mut().zip(columns) {
            values.iter_mut().filter(|value| missing.contains(value)).for_each(|value| *value = f64::NAN);
            all.extend(values);
        }
    }
    Piece::mapped(source, "Parquet", mapping, &times, rows)
}
