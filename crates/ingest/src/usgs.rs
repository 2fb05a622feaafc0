//! Formats of the USGS geomagnetism program: PCDCP and the JSON of its web service (as its geomag-algorithms
//! write them).

mod json;
mod pcdcp;
mod said;

use tables::{Content, Place};

use crate::iaga::convert;
use crate::piece::Piece;
use crate::text::Source;
use crate::{Error, Options};

/// Reads a file; None for one that is neither.
///
/// # Errors
///
/// A row that is none, with its line; components that are not known; values and times of other numbers.
pub fn read(source: &Source, options: &Options) -> Result<Option<Piece>, Error> {
    let (format, said) = match source.kind {
        Content::Delimited if pcdcp::is_meant(&source.bytes) => ("PCDCP", pcdcp::read(source)?),
        Content::NdJson if json::is_meant(&source.bytes) => ("USGS JSON", json::read(source)?),
        _ => return Ok(None),
    };
    let mut piece = Piece::of(source, format);
    if said.times_ns.is_empty() {
        return Err(source.fault(
            Place::Whole,
            "a header and no row",
            "rows of readings; was it copied in full?",
        ));
    }
    let converted = convert(&said.letters, said.columns, options.declination_base_arcmin, &options.quantity);
    if converted.columns.is_empty() {
        let expected = "a reading in one row at least";
        return Err(source.fault(Place::Whole, "nothing but missing values", expected));
    }
    piece.columns = converted.columns;
    piece.times_ns = said.times_ns;
    piece.lines = said.lines;
    piece.station = Some(said.station);
    piece.header.extend(said.header);
    piece.header.insert("components".into(), said.letters.iter().collect::<String>().into());
    piece.header.extend(converted.words.map(|words| ("converted".to_string(), words.into())));
    Ok(Some(piece))
}
