//! Rows within an interval of time.

use common::number::counted;
use common::time::Start;
use common::{Column, Error, Recording};

use crate::times;

/// An end of an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// A moment.
    Moment(Start),
    /// `time_s`.
    Seconds(f64),
}

/// Rows from one bound up to and without the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cut {
    /// The first row's least time.
    pub from: Option<Bound>,
    /// Rows at this time and later go.
    pub to: Option<Bound>,
}

impl Bound {
    /// Reads `2025-03-14T12:00:00Z` or seconds.
    pub fn parse(text: &str) -> Option<Self> {
        let seconds = || text.parse().ok().filter(|seconds: &f64| seconds.is_finite()).map(Bound::Seconds);
        Start::parse(text).map(Bound::Moment).or_else(seconds)
    }

    /// As `time_s` of a recording.
    fn time_s(self, recording: &Recording, path: &str) -> Result<f64, Error> {
        match (self, recording.start()) {
            (Bound::Seconds(seconds), _) => Ok(seconds),
            (Bound::Moment(moment), Some(start)) => Ok(moment.unix_s - start.unix_s),
            (Bound::Moment(_), None) => {
                let expected = "when it began, to be cut at a moment; or seconds of time_s";
                let found = format!("none in \"{}\"", recording.id);
                Err(Error::document(format!("{path}.start"), found, expected))
            }
        }
    }
}

impl Cut {
    /// Cuts a recording; what was done, in words.
    pub fn run(&self, recording: &mut Recording, path: &str) -> Result<String, Error> {
        let bound = |bound: Option<Bound>| bound.map(|bound| bound.time_s(recording, path)).transpose();
        let (from, to) =
            (bound(self.from)?.unwrap_or(f64::NEG_INFINITY), bound(self.to)?.unwrap_or(f64::INFINITY));
        let time = times(recording, path)?;
        let (first, last) = (time.partition_point(|t| *t < from), time.partition_point(|t| *t < to));
        let rows = time.len();
        if first >= last {
            let span = time.first().zip(time.last());
            let span = span.map_or(String::new(), |(a, b)| format!(", which is from {a} s to {b} s"));
            let id = &recording.id;
            return Err(Error::Request(format!(
                "no row of \"{id}\"{span}, is between the two times; expected an interval with rows"
            )));
        }
        for column in recording.columns.values_mut() {
            *column = Column::from(column[first..last].to_vec());
        }
        Ok(format!("{} of {}", last - first, counted(rows, "row")))
    }
}
