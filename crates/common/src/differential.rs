use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::residual::ABSURD;
use crate::{
    AllanDeviation, Extra, Findings, HeldOutPrediction, Matrix3x3, PerAxis, Quantity, ResidualSeries,
};

mod clock;
mod contribution;
mod drift;
mod fourteen;
mod kept_out;
mod reference_noise;
mod stability;

pub use clock::*;
pub use contribution::*;
pub use drift::*;
pub use fourteen::*;
pub use kept_out::*;
pub use reference_noise::*;
pub use stability::*;

/// The test magnetometer against the reference: T = R η + d, rows are samples.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DifferentialCalibration {
    /// η: column j holds what the reference's x, y, z give to the test's axis j.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matrix: Option<Matrix3x3>,
    /// d, nT: mean of T − R η.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_nt: Option<PerAxis<Quantity>>,
    /// Covariance of the matrix in the order of `covariance_order`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<Vec<Vec<f64>>>,
    /// `matrix[0][0]`, `matrix[1][0]`, …: column by column.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance_order: Option<Vec<String>>,
    /// Five values of one of the instruments, known beforehand; the fourteen parameters follow with the
    /// matrix.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub known: Option<KnownInstrument>,
    /// How the instruments and their axes stand to each other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fourteen: Option<Box<FourteenParameters>>,
    /// How they were found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit: Option<Box<DifferentialFit>>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// How a test magnetometer was held against its reference, by diffmag.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct DifferentialFit {
    /// The recordings, by their ids.
    pub recordings: Vec<String>,
    /// Samples used.
    pub samples: usize,
    /// From one sample to the next, s.
    pub step_s: f64,
    /// Samples of which a reading is missing or was taken out; they are left out.
    pub missing: usize,
    /// What was kept out.
    pub kept_out: KeptOut,
    /// Every element of the matrix by its place, `xy` from the reference's x to the test's y.
    pub elements: IndexMap<String, MatrixElement>,
    /// Which interval to quote, and why.
    pub quoted: String,
    /// Each axis of the test instrument.
    pub axes: PerAxis<DifferenceAxis>,
    /// The clock of the test instrument against the reference's.
    pub clock: Option<ClockDifference>,
    /// η by octave of averaging times, where only statistics of the series are left.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub octaves: Option<PerAxis<Vec<OctaveAgreement>>>,
    /// Whether the matrix holds still; None where the recording is too short to be divided.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stability: Option<MatrixStability>,
    /// How far noise of the reference pulls the matrix, and what was done about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_noise: Option<ReferenceNoise>,
    /// Noise of each of three instruments, where there is a third.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub three_cornered: Option<ThreeCornered>,
    /// The answer in one sentence, with its size and what it does to the difference.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub answer: String,
    /// How well held-out readings are predicted; absent where nothing was recorded beside the instruments.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOutPrediction>,
    /// What adds to the difference, the largest first; absent where only statistics of the series are left.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub contributions: Vec<Contribution>,
    /// The difference along `time_s`, the field's rate of change along the test axis (`field_rate_nt_per_s`)
    /// and each housekeeping column, for plots. Along time `before_nt` is T − R of axes of the same name,
    /// less its mean. Along the field's rate of change it has the clock's difference in it, along a column
    /// the drift; nothing else. `after_nt` is without.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub series: Vec<ResidualSeries>,
    /// What looks wrong, in words: what can be taken off first, by what it does to the difference.
    #[serde(flatten)]
    pub findings: Findings,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// One element of the matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MatrixElement {
    /// By least squares of the reference's axes alone, as the source has it: a drift is not taken off.
    pub least_squares: f64,
    /// Its standard uncertainty if the errors were independent, with N − 4 degrees of freedom (the source's).
    pub std_independent: f64,
    /// The same by Newey and West; absent where only statistics of the series are left.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_newey_west: Option<f64>,
    /// The same under the noise that was fitted to the difference.
    pub std_noise: f64,
    /// By least squares weighted with the spectrum of that noise.
    pub weighted: f64,
    /// Its standard uncertainty.
    pub weighted_std: f64,
    /// The degrees of freedom of that, from how well the noise is known; absent where they were not counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degrees_of_freedom: Option<f64>,
}

/// How two magnetometers agree at one octave of averaging times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct OctaveAgreement {
    /// Averaging time of the blocks of which neighbours were compared, s.
    pub averaging_s: f64,
    /// Differences of neighbouring blocks.
    pub differences: u64,
    /// η from the reference's x, y, z by these alone; absent where they are too few.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub matrix: Option<[f64; 3]>,
    /// Its standard uncertainty, the differences taken as independent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std: Option<[f64; 3]>,
    /// Share of the square of the test's differences that the reference explains.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coherence: Option<f64>,
}

/// The difference d along one axis of the test instrument.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct DifferenceAxis {
    /// Rms of d about its mean, nT.
    pub rms_nt: f64,
    /// Rms of what the whole fit leaves: d without its drift, nT.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_left_nt: Option<f64>,
    /// Rms of the axis's own readings about their mean, nT.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_of_readings_nt: Option<f64>,
    /// Rms of the readings less those of the reference's axis of the same name, about its mean: levels alone,
    /// nT.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_of_levels_nt: Option<f64>,
    /// 95 % interval of its standard deviation by χ² with N − 4 degrees of freedom, as the source has it, nT.
    pub rms_interval_independent_nt: [f64; 2],
    /// A of its flicker noise A f^-α, nT²/Hz at 1 Hz.
    pub flicker_nt2_per_hz_at_1hz: Quantity,
    /// α.
    pub flicker_exponent: Quantity,
    /// White noise of one reading, nT.
    pub white_rms_nt: Quantity,
    /// √P at 1 Hz of the flicker noise, nT/√Hz.
    pub density_at_1hz_nt_per_sqrt_hz: Quantity,
    /// Probability of a worse agreement of the spectrum with that form by chance.
    pub goodness_p: f64,
    /// The weighted matrix rests on frequencies up to this: above, the instruments do not answer alike, Hz.
    /// Absent: on all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weighted_up_to_hz: Option<f64>,
    /// Overlapping Allan deviation.
    pub allan: AllanDeviation,
    /// Its drift.
    pub drift: Drift,
    /// Housekeeping columns that it follows, in the order in which they were found; the matrix and d are
    /// without what follows them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub follows: Vec<Followed>,
}

impl DifferenceAxis {
    /// What is left, nT.
    pub fn left_nt(&self) -> f64 {
        self.rms_left_nt.unwrap_or(self.rms_nt)
    }

    /// The rms that is known without any fit, if what is left exceeds it, nT: such a fit is worse than none.
    pub fn exceeded_nt(&self) -> Option<f64> {
        let own = [self.rms_of_readings_nt, self.rms_of_levels_nt].into_iter().flatten();
        own.reduce(f64::min).filter(|own| self.left_nt() > ABSURD * own)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_held_against_what_there_was() {
        let axis = |rms_nt, readings, levels| DifferenceAxis {
            rms_nt,
            rms_of_readings_nt: readings,
            rms_of_levels_nt: levels,
            ..DifferenceAxis::default()
        };
        assert_eq!(axis(3.0, Some(0.5), Some(2.0)).exceeded_nt(), Some(0.5));
        assert_eq!(axis(0.5, Some(0.5), Some(2.0)).exceeded_nt(), None);
        assert_eq!(axis(3.0, None, None).exceeded_nt(), None);
    }
}
