//! A piece as one line of JSON, and many lines merged.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::io::BufRead;

use crate::{Error, Partial, merge};

/// Lines that are read and merged at once.
const LINES: usize = 64;

/// A piece as it is written.
#[derive(Serialize, Deserialize)]
struct Written<P> {
    #[serde(rename = "fluxcal-partial")]
    kind: String,
    version: u32,
    statistics: P,
}

/// A piece as JSON without a line break, each number so that it comes back the same.
pub fn to_line<P: Partial>(piece: &P) -> String {
    common::to_line(&Written { kind: P::KIND.to_string(), version: P::VERSION, statistics: piece })
}

/// Reads a piece from JSON.
///
/// Errors: [`Error::Format`] for a text that is none, of another kind or in another version.
pub fn parse<P: Partial>(text: &str) -> Result<P, Error> {
    #[derive(Deserialize)]
    #[serde(expecting = "an object")]
    struct Head {
        #[serde(rename = "fluxcal-partial")]
        kind: String,
        version: u32,
    }
    let no_piece = |reason: String| Error::Format { kind: P::KIND, reason };
    let failed = |error: common::Error| no_piece(error.to_string());
    let Head { kind, version } = common::at_path(text).map_err(failed)?;
    if kind != P::KIND || version != P::VERSION {
        return Err(no_piece(format!(
            "found `{kind}` in version {version}, expected `{}` in version {}",
            P::KIND,
            P::VERSION
        )));
    }
    let Written { statistics: piece, .. } = common::at_path::<Written<P>>(text).map_err(failed)?;
    if !piece.is_whole() {
        return Err(no_piece(
            "its sums are not those of such a piece, or what it covers does not rise; was it edited?".into(),
        ));
    }
    Ok(piece)
}

/// Merges the pieces of several sources, one a line, in memory for a few of them. What comes out does not
/// depend on the number of threads.
///
/// Errors: a source that cannot be read, a line that is no piece, with source and line; [`Error::Empty`] where there
/// is none; pieces that cannot be joined, with the source up to which they were.
pub fn merge_lines<P: Partial>(
    sources: impl IntoIterator<Item = (String, Box<dyn BufRead>)>,
) -> Result<P, common::Error> {
    let mut joined: Option<P> = None;
    for (name, mut source) in sources {
        let mut number = 0;
        loop {
            let (first, lines) = (number, some_lines(source.as_mut(), &name)?);
            number += lines.len();
            let read = |(at, line): (usize, &String)| -> Option<Result<P, common::Error>> {
                let at = first + at + 1;
                let place = |error: Error| common::Error::Request(format!("{name}, line {at}: {error}"));
                (!line.trim().is_empty()).then(|| parse(line).map_err(place))
            };
            let pieces: Vec<P> = lines.par_iter().enumerate().filter_map(read).collect::<Result<_, _>>()?;
            let of_source = |error: P::Error| {
                let error: common::Error = error.into();
                common::Error::Request(format!("{name}: {error}"))
            };
            if !pieces.is_empty() {
                let all = joined.take().into_iter().chain(pieces).collect();
                joined = Some(merge(all).map_err(of_source)?);
            }
            if lines.len() < LINES {
                break;
            }
        }
    }
    joined.ok_or_else(|| Error::Empty.into())
}

/// The next lines, as many as are read at once unless the source ends.
fn some_lines(source: &mut dyn BufRead, name: &str) -> Result<Vec<String>, common::Error> {
    let unreadable = |source| common::Error::file(name, "read", source);
    source.lines().take(LINES).collect::<Result<_, _>>().map_err(unreadable)
}
