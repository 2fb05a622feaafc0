//! Formats of observatories besides IAGA-2002 and ImagCDF: those of INTERMAGNET's Technical Reference Manual, which are
//! the archive format (IAF), minute values of the data centres (IMF 1.22 and 1.23) and baselines (IBF); PCDCP and the
//! JSON of the web service of the USGS, as its geomag-algorithms write them.

mod iaf;
mod ibf;
mod imf;
mod pcdcp;
mod usgs;

use tables::{Content, Place};

use crate::iaga::{letter, put};
use crate::piece::Piece;
use crate::text::{Source, decoded, lines};
use crate::{Error, Options};

/// Letters of components and their values: nT, minutes of arc for D and I.
type Components = (Vec<char>, Vec<Vec<f64>>);

/// Reads a file; None for one of another format. Errors: headers and values that the format does not have,
/// with their place; yearly means, which are no readings.
pub fn read(source: &Source, options: &Options) -> Result<Option<Piece>, Error> {
    let first = first_line(&source.bytes);
    let (mut piece, mut base_arcmin) = (Piece::of(source, ""), None);
    let (format, (letters, columns)) = match source.kind {
        Content::Iaf => ("IAF", iaf::read(source, &mut piece)?),
        Content::Delimited if imf::Header::of(&first).is_some() => {
            let (components, base) = imf::read(source, &mut piece)?;
            base_arcmin = base;
            ("IMF", components)
        }
        Content::Delimited if ibf::Header::of(&first).is_some() => return ibf::read(source).map(Some),
        Content::Delimited if first.to_ascii_uppercase().contains("ANNUAL MEAN") => {
            let expected = "minute values of the station (IAGA-2002, ImagCDF, IAF), or yearly means as CSV with a date in each row";
            return Err(source.fault(Place::Whole, "yearly means of an observatory (IYF)", expected));
        }
        Content::Delimited if pcdcp::is_meant(&source.bytes) => ("PCDCP", pcdcp::read(source, &mut piece)?),
        Content::NdJson if usgs::is_meant(&source.bytes) => ("USGS JSON", usgs::read(source, &mut piece)?),
        _ => return Ok(None),
    };
    piece.format = format;
    let base_arcmin = options.declination_base_arcmin.or(base_arcmin);
    put(&mut piece, source, (&letters, columns), base_arcmin, options)?;
    Ok(Some(piece))
}

/// The first line that is not blank.
fn first_line(bytes: &[u8]) -> String {
    let head = &bytes[..bytes.len().min(400)];
    let first = lines(head).find(|(_, line)| !line.trim_ascii().is_empty());
    decoded(first.map_or(&[], |(_, line)| line)).into_owned()
}

/// The letters of elements as a header runs them together, each once.
fn elements(text: &str) -> Option<Vec<char>> {
    let letters: Vec<char> = text.chars().map(|name| letter(&name.to_string())).collect::<Option<_>>()?;
    let is_new = |(index, name): (usize, &char)| !letters[..index].contains(name);
    letters.iter().enumerate().all(is_new).then_some(letters)
}

/// The whole numbers of a line, none larger than `most`.
fn whole_numbers(text: &str, most: i64) -> Option<Vec<i64>> {
    let value = |word: &str| word.parse().ok().filter(|value: &i64| (-most..=most).contains(value));
    text.split_whitespace().map(value).collect()
}

/// Tenths or hundredths as files store them; NaN for 999999 (missing) and 888888 (not observed), which may have a
/// digit more.
fn scaled(stored: i64, per_unit: f64) -> f64 {
    match stored {
        999_999 | 9_999_999 | 888_888 | 8_888_888 => f64::NAN,
        stored => stored as f64 / per_unit,
    }
}

/// A header as that of IAGA-2002, without what the file leaves blank.
fn header<const N: usize>(records: [(&str, String); N]) -> serde_json::Value {
    let records = records.into_iter().filter(|(_, content)| !content.is_empty());
    records.map(|(label, content)| (label.to_string(), serde_json::Value::from(content))).collect()
}
