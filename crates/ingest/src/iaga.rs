//! IAGA-2002, the exchange format of observatories (IAGA Division V, working group V-DAT, 2001 with additions
//! to 2015;
//! <https://www.ncei.noaa.gov/services/world-data-system/v-dat-working-group/iaga-2002-data-exchange-format>),
//! as it is met: labels in capitals or not, lines with and without their bar, fewer or more components than
//! four, times with or without milliseconds.

mod components;
mod header;
mod rows;

use tables::Place;

use crate::piece::Piece;
use crate::text::Source;
use crate::{Error, Options};

pub use components::{convert, letter, put};
use header::Header;

/// Reads a file. Errors: a header that is not one, or says something else than the titles or rows; with line
/// and column, a row that is none.
pub fn read(source: &Source, options: &Options) -> Result<Piece, Error> {
    let header = Header::read(source)?;
    let mut piece = Piece::of(source, "IAGA-2002");
    piece.station = header.station.clone();
    let components = header.components(source, options.trust_rows, &mut piece.notes)?;
    let data = rows::read(source, &header, &components, options.trust_rows)?;
    check_interval(source, &header, &data.rows.times_ns, options.trust_rows, &mut piece.notes)?;
    for (component, not_observed) in components.iter().zip(&data.not_observed) {
        if *not_observed == data.rows.lines.len() {
            piece.notes.push(format!("{component} was not observed (88888 throughout)"));
        }
    }
    piece.times_ns = data.rows.times_ns;
    piece.lines = data.rows.lines;
    piece.header = header.kept();
    let base = options.declination_base_arcmin.or(header.declination_base_arcmin());
    put(&mut piece, source, (&components, data.rows.columns), base, options)?;
    piece.notes.extend(source.latin_1(source.bytes.len() - header.data(source).len()));
    Ok(piece)
}

/// The header's interval is that of the rows, to a hundredth.
fn check_interval(
    source: &Source,
    header: &Header,
    times_ns: &[i64],
    trust_rows: bool,
    notes: &mut Vec<String>,
) -> Result<(), Error> {
    let (Some((line, said, declared_s)), Some(step_s)) = (header.interval(), crate::series::step_s(times_ns))
    else {
        return Ok(());
    };
    // A month has no length.
    let fits = if declared_s >= 28.0 * 86_400.0 {
        step_s >= 28.0 * 86_400.0
    } else {
        (step_s / declared_s - 1.0).abs() < 0.01
    };
    match (fits, trust_rows) {
        (true, _) => Ok(()),
        (false, true) => {
            notes.push(format!("the header says {said:?}, the rows are {step_s} s apart; the rows are used"));
            Ok(())
        }
        (false, false) => Err(source.fault(
            Place::Line(line),
            format!("the interval {said:?} where the rows are {step_s} s apart"),
            "a header with the interval of the rows; correct it, or use the rows with --trust-rows",
        )),
    }
}
