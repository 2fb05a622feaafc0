use serde::{Deserialize, Serialize};

use crate::{Axis, Findings, Matrix3x3, PerAxis, Quantity};

/// Whether the matrix η holds still.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct MatrixStability {
    /// In time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub windows: Option<MatrixWindows>,
    /// In quiet and in disturbed times.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quiet_disturbed: Option<QuietDisturbed>,
    /// From short to long periods.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bands: Option<TransferBands>,
    /// What moved, and what could not be asked, in words.
    #[serde(flatten)]
    pub findings: Findings,
}

/// Whether several estimates of η are one. The share that noise of the reference may have in the difference
/// biases each of them in another way; it is fitted with them, between none and all.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OneMatrix {
    /// Probability of estimates that lie as far apart by chance, all axes of the test instrument together.
    pub p: f64,
    /// The same for each axis.
    pub axes: PerAxis<ChiSquared>,
}

/// A sum of squares and what chance makes of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ChiSquared {
    /// χ².
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub freedom: f64,
    /// Probability of a greater one.
    pub p: f64,
}

/// One estimate of η.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MatrixEstimate {
    /// η as in `calibration.differential.matrix`.
    pub matrix: Matrix3x3,
    /// Standard uncertainty of each element.
    pub std: Matrix3x3,
    /// Covariance of each column: of what the reference's x, y, z give to one axis of the test instrument.
    pub covariance: PerAxis<Matrix3x3>,
}

/// η in windows of equal length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MatrixWindows {
    /// The windows, each with a level and a straight drift of its own.
    pub windows: Vec<MatrixWindow>,
    /// Whether all windows have one η.
    pub one_matrix: OneMatrix,
    /// The change of one element at one moment that stands out most.
    pub largest_change: ElementChange,
    /// Change of η per day, a straight line through the windows.
    pub trend_per_day: Matrix3x3,
    /// Standard uncertainty of each of its elements.
    pub trend_std_per_day: Matrix3x3,
    /// Whether there is none.
    pub no_trend: OneMatrix,
}

/// η in one window.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MatrixWindow {
    /// Time of its first sample, s.
    pub from_s: f64,
    /// Time of its last sample, s.
    pub to_s: f64,
    /// Samples in which nothing is missing.
    pub samples: usize,
    /// Rms of the reference's variation about its mean, nT.
    pub variation_nt: PerAxis<f64>,
    /// η.
    pub estimate: MatrixEstimate,
    /// Mean of T − R η with the η of the whole recording, less that of the whole recording, nT.
    pub offset_change_nt: PerAxis<Quantity>,
}

/// How an element differs after a moment from before.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ElementChange {
    /// `xz` from the reference's x to the test's z.
    pub element: String,
    /// The last window before ends here, s.
    pub at_s: f64,
    /// After less before, 1e-6.
    pub change_ppm: Quantity,
    /// Probability of one as large by chance, anywhere.
    pub p: f64,
}

/// η from times in which the field varies little and much.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct QuietDisturbed {
    /// Length of the stretches that are ranked by the rms of the first differences of the reference, s.
    pub stretch_s: f64,
    /// Stretches ranked.
    pub stretches: usize,
    /// Rms of first differences, disturbed over quiet. Below 2 there is no contrast and nothing further.
    pub activity_ratio: f64,
    /// The lower half.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quiet: Option<MatrixOfTimes>,
    /// The upper quarter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disturbed: Option<MatrixOfTimes>,
    /// Whether both have one η.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub one_matrix: Option<OneMatrix>,
}

/// η from variations within certain times.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MatrixOfTimes {
    /// From and to, s; neighbouring stretches joined.
    pub times_s: Vec<[f64; 2]>,
    /// Rms of the reference's first differences, all axes together, nT.
    pub activity_nt: f64,
    /// η.
    pub estimate: MatrixEstimate,
}

/// T = R Z(f): the matrix as a transfer function, in bands.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TransferBands {
    /// The bands, long periods first.
    pub bands: Vec<TransferBand>,
    /// Whether Z is real and the same in all bands that have freedom enough.
    pub one_matrix: OneMatrix,
    /// Offset of the test instrument's clock as the phases have it.
    pub clock: PhaseClock,
    /// Whether Z is one matrix once that is taken off.
    pub one_matrix_with_clock: OneMatrix,
    /// The same over the bands of periods below half a day alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub one_matrix_short_periods: Option<OneMatrix>,
}

/// Phases of Z as a clock offset.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PhaseClock {
    /// Positive where the test instrument's times are late, s.
    pub offset_s: Quantity,
    /// Probability that all axes have one offset and yet differ as much.
    pub alike_p: f64,
}

/// Z in one band.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TransferBand {
    /// Shortest period, s.
    pub from_period_s: f64,
    /// Longest period, s.
    pub to_period_s: f64,
    /// Degrees of freedom of the noise, from which the uncertainties come by Student's t.
    pub freedom: f64,
    /// Whether the band has freedom enough to be tested.
    pub tested: bool,
    /// Real part.
    pub real: Matrix3x3,
    /// Standard uncertainty of each element.
    pub real_std: Matrix3x3,
    /// Imaginary part, negative where the test instrument is late.
    pub imaginary: Matrix3x3,
    /// Standard uncertainty of each element.
    pub imaginary_std: Matrix3x3,
    /// Each axis of the test instrument.
    pub axes: PerAxis<BandAxis>,
}

/// One axis of the test instrument in one band.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BandAxis {
    /// Share of its power that the reference explains: the multiple coherence.
    pub coherence: f64,
    /// Rms of what is left in the band, nT.
    pub residual_rms_nt: f64,
    /// Probability of a Z so far from the common matrix by chance, where the band is tested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p: Option<f64>,
}

impl MatrixEstimate {
    /// Puts the column of one axis of the test instrument.
    pub fn put(&mut self, axis: Axis, column: [f64; 3], covariance: Matrix3x3) {
        for i in 0..3 {
            self.matrix[i][axis.index()] = column[i];
            self.std[i][axis.index()] = covariance[i][i].sqrt();
        }
        *self.covariance.entry(axis) = Some(covariance);
    }
}
