//! Formats of the USGS geomagnetism program: PCDCP and the JSON of its web service (as its geomag-algorithms
//! write them).

mod json;
mod pcdcp;

use tables::Content;

use crate::iaga::put;
use crate::piece::Piece;
use crate::text::Source;
use crate::{Error, Options};

/// Reads a file; None for one that is neither.
///
/// # Errors
///
/// A row that is none, with its line; components that are not known; values and times of other numbers.
pub fn read(source: &Source, options: &Options) -> Result<Option<Piece>, Error> {
    let mut piece = Piece::of(source, "");
    let (format, components) = match source.kind {
        Content::Delimited if pcdcp::is_meant(&source.bytes) => ("PCDCP", pcdcp::read(source, &mut piece)?),
        Content::NdJson if json::is_meant(&source.bytes) => ("USGS JSON", json::read(source, &mut piece)?),
        _ => return Ok(None),
    };
    piece.format = format;
    let (letters, columns) = components;
    put(&mut piece, source, (&letters, columns), options.declination_base_arcmin, options)?;
    Ok(Some(piece))
}
