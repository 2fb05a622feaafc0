use physics::Unit;
use serde::{Deserialize, Serialize};

use super::Error;
use super::covered::Covered;
use super::sample::Sample;
use super::windows::Closed;
use crate::ends::Ends;
use crate::read::Source;
use crate::terms::{ONE, Terms};

/// What such a file is of.
const KIND: &str = "scalarcal";
/// Of the files written here.
const VERSION: u32 = 1;

/// All that is kept of a piece of a series, whatever its length. Pieces are joined by [`merge`] and answered by [`super::document`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Partial {
    /// What kind of piece this is: `scalarcal`.
    #[serde(rename = "fluxcal-partial")]
    pub kind: String,
    /// Version of the format.
    pub version: u32,
    /// Unit of the readings: `v` or `nt`.
    unit: String,
    /// Whether the magnitude is the length of a known field (`ambient_*_nt`), and not that of a scalar magnetometer.
    ambient: bool,
    /// What is covered, s.
    pub(super) covered: Covered,
    /// Rows with all readings.
    pub rows: u64,
    /// Rows that lack a reading.
    pub missing: u64,
    /// Rows that repeat the one before in all three sensors.
    pub repeated: u64,
    /// The largest and the smallest readings.
    pub(super) ends: Ends,
    /// Factors of the products.
    #[serde(flatten)]
    pub(super) windows: Closed,
    /// A sample of the rows.
    pub(super) sample: Sample,
}

impl Partial {
    /// A piece without rows, which changes none that it is merged with.
    pub fn new(unit: Unit, source: Source) -> Self {
        Self {
            kind: KIND.into(),
            version: VERSION,
            unit: unit.suffix().into(),
            ambient: source == Source::Ambient,
            covered: Covered::default(),
            rows: 0,
            missing: 0,
            repeated: 0,
            ends: Ends::default(),
            windows: Closed::default(),
            sample: Sample::default(),
        }
    }

    /// Unit of the readings.
    pub fn unit(&self) -> Unit {
        if self.unit == Unit::Nanotesla.suffix() { Unit::Nanotesla } else { Unit::Volt }
    }

    /// Where the magnitude comes from.
    pub fn source(&self) -> Source {
        if self.ambient { Source::Ambient } else { Source::Scalar }
    }

    /// Reads a piece from JSON.
    ///
    /// # Errors
    ///
    /// [`Error::Format`] for a text that is none, of another kind or of a later version.
    pub fn parse(text: &str) -> Result<Self, Error> {
        #[derive(Deserialize)]
        struct Head {
            #[serde(rename = "fluxcal-partial")]
            kind: String,
            version: u32,
        }
        let failed = |error: common::Error| Error::Format(error.to_string());
        let head: Head = common::at_path(text).map_err(failed)?;
        if head.kind != KIND || head.version != VERSION {
            let Head { kind, version } = head;
            return Err(Error::Format(format!(
                "found `{kind}` in version {version}, expected `{KIND}` in version {VERSION}"
            )));
        }
        let read: Partial = common::at_path(text).map_err(failed)?;
        let columns = Terms::new(ONE + 1).count();
        let units = [Unit::Volt, Unit::Nanotesla].map(Unit::suffix);
        let whole = units.contains(&read.unit.as_str())
            && read.covered.is_whole()
            && read.ends.is_whole()
            && read.windows.is_whole(columns, read.rows)
            && read.sample.is_whole();
        if !whole {
            return Err(Error::Format(
                "its sums are not those of such a piece, or what it covers does not rise; was it edited?"
                    .into(),
            ));
        }
        Ok(read)
    }

    /// The piece as JSON, each number so that it comes back the same.
    pub fn to_text(&self) -> String {
        serde_json::to_string(self).expect("a piece has string keys")
    }

    /// First and last moment that are covered, s.
    pub fn span_s(&self) -> Option<[f64; 2]> {
        self.covered.span_s()
    }

    fn of(&self) -> String {
        let reference = if self.ambient { "ambient_*_nt" } else { "reference_nt" };
        format!("{} beside {reference}", self.unit)
    }

    /// Takes what another piece holds.
    fn join(&mut self, mut other: Self) -> Result<(), Error> {
        if (&self.unit, self.ambient) != (&other.unit, other.ambient) {
            return Err(Error::Unlike { first: self.of(), second: other.of() });
        }
        self.covered.merge(&other.covered)?;
        self.rows += other.rows;
        self.missing += other.missing;
        self.repeated += other.repeated;
        let (here, there) = self.ends.merge(&other.ends);
        self.windows.no_longer(here);
        other.windows.no_longer(there);
        self.windows.merge(other.windows);
        self.sample.merge(&other.sample);
        Ok(())
    }
}

/// Joins pieces of one series, in any order; between them there may be gaps, which other pieces fill later. Of one piece it is that piece.
///
/// # Errors
///
/// [`Error::Empty`] of none, [`Error::Unlike`] for other units, [`Error::Overlap`] where two pieces cover the same time.
pub fn merge(pieces: Vec<Partial>) -> Result<Partial, Error> {
    let mut pieces = pieces.into_iter();
    let mut joined = pieces.next().ok_or(Error::Empty)?;
    pieces.try_for_each(|piece| joined.join(piece))?;
    Ok(joined)
}
