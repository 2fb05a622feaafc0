//! The calibration document and its way through a pipe.
//!
//! Every fluxcal program reads one [`Document`], adds what it found and writes the document on.
//! Here are its types (one file for each part), the quantity with its uncertainty, the errors with
//! their exit codes, and the reading and writing that all stages share. No physics, no estimation.

mod axes;
mod axis;
pub mod beside;
mod calibration;
mod coil;
mod diagnosis;
mod differential;
mod document;
mod error;
mod facility;
mod history;
mod instrument;
mod json;
pub mod manual;
mod model;
mod nulling;
pub mod pipe;
mod quantity;
mod recording;
pub mod schema;
mod sensor;
mod sensor_conditions;
mod sensor_noise;
mod sensor_offset;
pub mod series;
pub mod time;

pub use axes::{
    Assumption, AxesCalibration, AxesDirections, AxesFit, AxesReadings, DoubtfulReading, IterationStep,
    OrientationResult, PairComparison, PhaseResult, ScaleResult, ScalesResult,
};
pub use axis::{Axis, PerAxis};
pub use calibration::{Calibration, CoilCalibration, ReferenceConditions};
pub use coil::{
    Budget, CoilFit, CoilResiduals, CoilSurvey, Departure, FTest, GradientCoil, OffCentre, SurveyPlaces,
};
pub use diagnosis::{
    BaseShift, Detectable, Diagnosis, DoubtfulValue, EnergyShare, ExplainedEffect, Remaining, Residual,
    ResidualOf, ResidualSeries, Rival, Share, Verdict,
};
pub use differential::{
    Angle, BandAxis, ChiSquared, ClockDifference, DifferenceAxis, DifferentialCalibration, DifferentialFit,
    Drift, DriftChange, DriftForm, ElementChange, EventInstrument, EventKind, FourteenParameters, Gap,
    InSpectrum, IteratedDrift, JointDrift, KeptOut, KeptOutEvent, KnownInstrument, Magnetometer,
    MatrixElement, MatrixEstimate, MatrixOfTimes, MatrixStability, MatrixWindow, MatrixWindows,
    OctaveAgreement, OneMatrix, OwnNoise, PhaseClock, PulledElement, QuietDisturbed, ReferenceNoise,
    ReferenceNoiseSource, ThreeCornered, TransferBand, TransferBands,
};
pub use document::{Document, FORMAT_VERSION, parse};
pub use error::{Error, ExitCode};
pub use facility::{Coil, Facility, Voltmeter};
pub use history::HistoryEntry;
pub use instrument::{Instrument, Noise, NoiseOfSensors};
pub use json::to_text;
pub use model::{AdoptedEffect, Model};
pub use nulling::{
    ExpectedRms, MergedSpectrum, NullingCalibration, SeriesOfSpectrum, SiteSpectra, SpectralLine,
};
pub use quantity::{Matrix3x3, OneOrEach, Quantity};
pub use recording::{Column, Columns, Conditions, Recording, Theodolite, procedure};
pub use sensor::{
    FieldErrors, FitNoise, PolynomialOrder, Saturation, SensitivityFit, SensitivityResiduals,
    SensorCalibration, TestResult,
};
pub use sensor_conditions::{
    CommonExtremum, CrossFieldFit, CrossFieldLevels, HeldOut, Misalignment, TemperatureFit,
    TemperatureLevels, TemperatureOfPart,
};
pub use sensor_noise::{AllanDeviation, BandRms, BudgetTerm, ErrorBudget, NoiseSeriesResult, SensorNoise};
pub use sensor_offset::{
    AnnualTerm, DriftDates, ImperfectTurn, OffsetDrift, Reversal, ReversalOffset, ReversalPairs,
};

/// Keys that this version does not know. They are kept and written on as they were.
pub type Extra = serde_json::Map<String, serde_json::Value>;
