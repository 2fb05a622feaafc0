//! Statistics of pieces of a long series, merged in any order and grouping.
//!
//! A [`Partial`] is all that a stage keeps of some rows of a series. Partials form a commutative monoid: to
//! join two is associative and commutative, to rounding, and a partial of no rows changes nothing. Its size
//! has a limit, whatever the length of the series, and it is written as one line of JSON. `stream --partial`
//! makes one, `merge` joins many of them, and `merge --partial` writes what was joined, so that merges can be
//! grouped: by day, month and year, or by machine.
//!
//! A stage states its statistics as a [`Partial`], and how rows become them as a [`Series`]; reading files,
//! text and the times that are covered ([`Covered`]) are the same for all.
//!
//! `testkit::partials_merge` tests every [`Partial`] for these laws; `program::pieces` is the command line of
//! `stream --partial` and `merge`.

mod covered;
mod error;
mod sample;
mod series;
mod text;

pub use covered::{Covered, MOST, Moment};
pub use error::Error;
pub use sample::Sample;
pub use series::{Series, Take, take, take_from};
pub use text::{merge_lines, parse, to_line};

use serde::Serialize;
use serde::de::DeserializeOwned;

/// The statistics of a piece of a series.
pub trait Partial: Serialize + DeserializeOwned + Send {
    /// The program whose statistics these are.
    const KIND: &'static str;
    /// Of their format.
    const VERSION: u32;
    /// Why two cannot be joined.
    type Error: From<Error> + Into<common::Error>;

    /// Whether the parts fit each other, after reading them from outside.
    fn is_whole(&self) -> bool;

    /// The first moment that is covered, s; None without rows.
    fn first_s(&self) -> Option<f64>;

    /// Takes what another holds. One without rows changes nothing.
    ///
    /// Errors: [`Error::Unlike`] for what cannot be of the same series, [`Error::Overlap`] where both cover the same
    /// time.
    fn join(&mut self, other: Self) -> Result<(), Self::Error>;
}

/// Joins pieces of one series, in any order; between them there may be holes, which other pieces fill later.
///
/// Errors: [`Error::Empty`] of none; as [`Partial::join`].
pub fn merge<P: Partial>(mut pieces: Vec<P>) -> Result<P, P::Error> {
    pieces.sort_by(|a, b| a.first_s().unwrap_or(f64::MIN).total_cmp(&b.first_s().unwrap_or(f64::MIN)));
    let mut pieces = pieces.into_iter();
    let mut joined = pieces.next().ok_or(Error::Empty)?;
    pieces.try_for_each(|piece| joined.join(piece))?;
    Ok(joined)
}
