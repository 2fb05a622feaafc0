//! A mapping guessed from a file: its notation, where the time is, what the columns are. What the file does
//! not say stays open.

mod circles;
mod columns;
mod content;
mod hapi;
mod names;
mod notation;
mod open;
mod sample;
mod temperatures;
mod time;

pub use open::Guess;

use std::path::Path;

use crate::Error;
use crate::mapping::{Mapping, SourceColumn};
use crate::sheets;
use crate::text::Source;

use sample::Sample;

/// Guesses how a file of columns is read; `quantity` is what its vector readings are called (`sensor`).
///
/// # Errors
///
/// A file that cannot be read, holds no rows, or is IAGA-2002 or IAF, which need no mapping.
pub fn guess(file: &Path, quantity: &str) -> Result<Guess, Error> {
    let source = Source::read(file)?;
    if source.kind.is_observatory() {
        let name = source.kind.name();
        let expected = format!("CSV, NDJSON or Parquet; {name} needs no mapping: ingest FILE");
        return Err(source.fault(tables::Place::Whole, name, expected));
    }
    if sheets::read(&source)?.is_some() {
        let expected = "CSV, NDJSON or Parquet; absolute measurements need no mapping: ingest FILE";
        return Err(source.fault(tables::Place::Whole, "absolute measurements", expected));
    }
    of(&source, quantity)
}

fn of(source: &Source, quantity: &str) -> Result<Guess, Error> {
    let sample = Sample::of(source)?;
    let mut guess = Guess { mapping: sample.notation.mapping.clone(), doubts: Vec::new(), notes: Vec::new() };
    if let Some(mark) = guess.mapping.thousands.filter(|_| sample.notation.thousands_are_doubtful) {
        let doubt =
            format!("whether {mark:?} separates thousands or is the decimal mark (`thousands`, `decimal`)");
        guess.doubts.push(doubt);
    }
    let time = time::guess(&sample, &source.name, &mut guess);
    columns::guess(&sample, &time, quantity, &mut guess);
    let hapi = hapi::header(&source.bytes).unwrap_or_default();
    for column in &mut guess.mapping.columns {
        let SourceColumn::Number(number) = column.from else { continue };
        column.missing.extend(hapi.get(number.get() - 1).and_then(|column| column.fill));
    }
    if guess.mapping.columns.is_empty() {
        let expected = "a table with a column of numbers at least; is it a file of readings?";
        return Err(source.fault(tables::Place::Whole, "no column of readings", expected));
    }
    Ok(guess)
}

/// The mapping that a file itself says, without any doubt, and what was taken as usual. Errors: what the file
/// does not say.
pub fn certain(source: &Source, quantity: &str) -> Result<(Mapping, Vec<String>), Error> {
    let guess = of(source, quantity)?;
    if guess.doubts.is_empty() {
        return Ok((guess.mapping, guess.notes));
    }
    let (shown, doubts) = (&source.shown, guess.doubts.join("; "));
    Err(Error::Request(format!(
        "{shown}: the file leaves open: {doubts}. Write a mapping with\n  ingest guess {shown} > map.json\n\
         look at it, edit it, then\n  ingest --map map.json {shown}"
    )))
}
