use serde::{Deserialize, Serialize};

use crate::{Axis, Extra, Quantity};

/// What was found wrong with the samples and kept out of a differential fit, by diffmag.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct KeptOut {
    /// Runs of samples that lack a reading.
    pub gaps: Vec<Gap>,
    /// Steps, spikes and disturbed intervals, in the order of time.
    pub events: Vec<KeptOutEvent>,
    /// More events were there than are looked for; the rest is still in the fit.
    pub more: bool,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// A run of samples that lack a reading of one of the instruments.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Gap {
    /// Time of the first sample, s; from the earliest `start`, or on the campaign's clock where recordings
    /// have none.
    pub from_s: f64,
    /// Time of the last sample, s.
    pub to_s: f64,
    /// How many samples.
    pub samples: usize,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// An event in the difference of the two instruments.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct KeptOutEvent {
    /// What it is.
    pub kind: EventKind,
    /// The instrument in which it is.
    pub instrument: EventInstrument,
    /// The instrument's axis; the one where it stands out most if it is in several.
    pub axis: Axis,
    /// When it began, as in `gaps`, s.
    pub time_s: f64,
    /// First and last sample taken out, from 0; of a step the first sample after it, twice.
    pub rows: [usize; 2],
    /// Its size, nT. Of an interval the largest part.
    pub size_nt: Quantity,
    /// Size over its uncertainty when it was found, or over the spread of all such ratios where that is
    /// wider.
    pub z: f64,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// The form of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// The level changes and stays; fitted and taken off.
    Step,
    /// One sample; taken out.
    Spike,
    /// Several samples in a row; taken out.
    Interval,
}

/// The instrument of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum EventInstrument {
    /// The one under test.
    Test,
    /// The reference.
    Reference,
    /// Not to be told: the axes of the two lie too close for its size. A step is taken from the test
    /// instrument.
    Either,
}
