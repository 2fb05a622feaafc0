//! What is asked of scalarcal.

use crate::assumed::Assumed;
use clap::Args;
use physics::Kind;
use program::number;
use program::place::KnownMagnitude;

/// What is asked of rows at hand.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// What is asked of a stream too.
    #[command(flatten)]
    pub fit: FitOptions,
    /// Leave out rows that are outliers
    #[arg(long)]
    pub robust: bool,
    /// Fit one constant magnitude of the field in recordings without a reference
    #[arg(long, conflicts_with_all = ["magnitude_nt", "place"])]
    pub constant_magnitude: bool,
    /// What is assumed of the sensors.
    #[command(flatten)]
    pub assumed: Assumed,
    /// A magnitude that was not measured.
    #[command(flatten)]
    pub magnitude: KnownMagnitude,
    /// Compare the readings with the known field (ambient_*_nt) rotated by the attitude: determines the directions of the sensors fully
    #[arg(long)]
    pub vector: bool,
    /// Fit an effect of the catalogue too (offset_temperature, sensitivity_temperature, stray_current, …); may be repeated
    #[arg(long, value_name = "EFFECT", value_parser = Kind::known)]
    pub with: Vec<Kind>,
}

/// What is asked of them and of a stream alike.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub struct FitOptions {
    /// Use the stated calibration of the sensors as a prior, with its uncertainty
    #[arg(long)]
    pub known: bool,
    /// Fit a constant error of the reference
    #[arg(long)]
    pub reference_offset: bool,
    /// Calibrate in windows of this length, s, and test whether they agree
    #[arg(long = "windows", value_name = "SECONDS", value_parser = number::positive)]
    pub windows_s: Option<f64>,
}

impl Options {
    /// What the history records of the request.
    pub fn arguments(&self) -> Vec<String> {
        let flags = [
            (self.fit.known, "--known"),
            (self.robust, "--robust"),
            (self.constant_magnitude, "--constant-magnitude"),
            (self.fit.reference_offset, "--reference-offset"),
            (self.vector, "--vector"),
        ];
        let flags = flags.iter().filter(|(set, _)| *set).map(|(_, name)| name.to_string());
        let with = self.with.iter().map(|kind| format!("--with={}", kind.name()));
        let Assumed { scales_within, angles_within, only } = &self.assumed;
        let limits = [("scales", scales_within), ("angles", angles_within)];
        let limits = limits
            .into_iter()
            .filter_map(|(name, limit)| Some(format!("--{name}-within={}", limit.as_ref()?)));
        let assumed = limits.chain(only.iter().map(|only| format!("--only={only}")));
        let magnitude = assumed.chain(self.magnitude.arguments());
        flags
            .chain(magnitude)
            .chain(with)
            .chain(self.fit.windows_s.map(|length| format!("--windows={length}")))
            .collect()
    }
}
