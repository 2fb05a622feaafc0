use serde::{Deserialize, Serialize};

use crate::Quantity;
use crate::number::uncertain;

/// The clock of the test instrument against the reference's: positive where the test instrument's times are
/// late.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ClockDifference {
    /// Its offset in the middle of the recording, s; where times jump, in the middle of the longest segment.
    /// Its uncertainty covers what parts of the recording and bands of period give, where these scatter by
    /// more than their own uncertainties.
    pub offset_s: Quantity,
    /// How much faster it runs, ppm; where times jump, within the segments.
    pub rate_ppm: Quantity,
    /// Whether the test instrument's times were corrected for both.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub corrected: bool,
    /// Offset left after the correction, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_offset_s: Option<Quantity>,
    /// Rate left after the correction, ppm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_rate_ppm: Option<Quantity>,
    /// Between jumps of the times, where there are any: each with an offset of its own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub segments: Vec<ClockSegment>,
    /// Where the times jump, and what the field says of it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub jumps: Vec<ClockJump>,
    /// The offset in parts of the recording; absent where it is too short to be divided.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parts: Option<OffsetScatter>,
    /// The offset in bands of period; absent where fewer than two say anything.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bands: Option<DelayBands>,
}

/// The clock between two jumps of the times.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ClockSegment {
    /// Time of its first row, s.
    pub from_s: f64,
    /// Time of its last row, s.
    pub to_s: f64,
    /// Offset in its middle, s; absent where it is too short.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_s: Option<Quantity>,
    /// Rate within it, ppm; absent where it is too short.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_ppm: Option<Quantity>,
}

/// A jump of an instrument's times.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ClockJump {
    /// Id of the recording.
    pub recording: String,
    /// The instrument whose times jump; absent where both have the same times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instrument: Option<String>,
    /// First row of the recording after it.
    pub row: usize,
    /// The time of that row, s.
    pub time_s: f64,
    /// How much later the times are from there on, beyond whole steps, s.
    pub by_s: Quantity,
    /// What the offset between the instruments, that of this one less the other's, changes by there, s;
    /// absent where nothing says it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_change_s: Option<Quantity>,
    /// What follows.
    pub verdict: JumpVerdict,
}

/// What the field says of a jump of the times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum JumpVerdict {
    /// The sampling jumped with the times: the offset is the same before and after.
    Confirmed,
    /// Only the times jumped: the offset changes by as much, and the sampling went on.
    Contradicted,
    /// The offset changes, by something else.
    Other,
    /// It cannot be told.
    #[default]
    Unclear,
}

/// Offsets of several parts, each with an uncertainty of its own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OffsetScatter {
    /// How many.
    pub count: usize,
    /// Standard uncertainty of the offset if all were the same, s.
    pub std_if_same_s: f64,
    /// √(Q/(count − 1)): how many times as far apart as their uncertainties they are.
    pub birge_ratio: f64,
    /// Probability of a larger scatter by chance.
    pub p: f64,
    /// Standard deviation of the parts' own offsets, their uncertainties taken off (Paule and Mandel), s.
    pub between_s: f64,
}

/// The delay in bands of period.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DelayBands {
    /// From short to long periods.
    pub bands: Vec<DelayBand>,
    /// How they scatter.
    pub scatter: OffsetScatter,
    /// How the delay depends on the period.
    pub form: DelayForm,
    /// Time constant of a low-pass filter of first order, s: of the test instrument where it is positive, of
    /// the reference where it is negative.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_constant_s: Option<Quantity>,
    /// Length of the running mean that the readings of one instrument are, s: of the test instrument where it
    /// is positive, of the reference where it is negative.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub average_s: Option<Quantity>,
    /// The delay at long periods less that of the filter, s: what is left for the clock.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beside_filter_s: Option<Quantity>,
}

/// The delay of the test instrument against the reference in a band.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DelayBand {
    /// Shortest period, s.
    pub shortest_s: f64,
    /// Longest period, s.
    pub longest_s: f64,
    /// The delay, s.
    pub delay_s: Quantity,
    /// Response over that of all periods together.
    pub gain: Quantity,
}

/// How a delay depends on the period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum DelayForm {
    /// Not at all: clocks, or filters of linear phase such as averages.
    #[default]
    Constant,
    /// atan(2πfτ)/(2πf), as of a low-pass filter of first order.
    LowPass,
    /// Not at all, with a response of sin(πfT)/(πfT), as of a running mean over T.
    Average,
    /// In another way.
    Other,
}

impl DelayBand {
    /// `1.40 ± 0.01 s late`, or `early`.
    pub fn delay_in_words(&self) -> String {
        in_words(&self.delay_s, "s", ["late", "early"])
    }
}

impl ClockDifference {
    /// `1.40 ± 0.01 s late`, or `early`.
    pub fn offset_in_words(&self) -> String {
        in_words(&self.offset_s, "s", ["late", "early"])
    }

    /// `7.7 ± 0.3 ppm fast`, or `slow`.
    pub fn rate_in_words(&self) -> String {
        in_words(&self.rate_ppm, "ppm", ["fast", "slow"])
    }
}

/// A size without its sign, and the word for it.
fn in_words(of: &Quantity, unit: &str, [above, below]: [&str; 2]) -> String {
    let word = if of.value() < 0.0 { below } else { above };
    format!("{} {unit} {word}", uncertain(of.value().abs(), of.std().unwrap_or(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_is_late_or_early_and_never_negative() {
        let clock = |offset, rate| ClockDifference {
            offset_s: Quantity::new(offset, 0.011),
            rate_ppm: Quantity::new(rate, 0.3),
            ..ClockDifference::default()
        };
        assert_eq!(clock(1.4, 7.7).offset_in_words(), "1.400 ± 0.011 s late");
        assert_eq!(clock(-18.4, 7.7).offset_in_words(), "18.400 ± 0.011 s early");
        assert_eq!(clock(0.0, 7.7).rate_in_words(), "7.70 ± 0.30 ppm fast");
        assert_eq!(clock(0.0, -7.7).rate_in_words(), "7.70 ± 0.30 ppm slow");
    }
}
