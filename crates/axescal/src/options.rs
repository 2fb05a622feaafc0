//! What is asked of axescal.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use common::Axis;

/// What is asked of axescal.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Take calibration.axes.coils as known, with its covariance or std_arcsec
    #[arg(long)]
    pub known_coils: bool,
    /// Where the iteration begins
    #[arg(long, value_enum, default_value_t = Start::Identity)]
    pub start: Start,
    /// Fit the scale factors of sensors and coils, and compare them with the calibration
    #[arg(long)]
    pub free_scales: bool,
    /// Down-weight outliers
    #[arg(long)]
    pub robust: bool,
    /// Use this sensor alone
    #[arg(long, value_parser = axis())]
    pub sensor: Option<Axis>,
    /// Use the readings with this coil alone
    #[arg(long, value_parser = axis())]
    pub coil: Option<Axis>,
}

fn axis() -> impl TypedValueParser<Value = Axis> {
    let of = |letter: String| Axis::ALL.into_iter().find(|axis| axis.letter() == letter);
    PossibleValuesParser::new(Axis::ALL.map(Axis::letter)).try_map(move |letter| of(letter).ok_or("no axis"))
}

/// Where the iteration begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Start {
    /// Along the nominal axes
    #[default]
    Identity,
    /// The matrices in calibration.axes
    Document,
}

impl Options {
    /// Whether one sensor or one coil alone is asked for.
    pub fn is_subset(&self) -> bool {
        self.sensor.is_some() || self.coil.is_some()
    }

    /// What the history records of the request.
    pub fn arguments(&self) -> Vec<String> {
        let flags = [
            (self.known_coils, "--known-coils"),
            (self.start == Start::Document, "--start=document"),
            (self.free_scales, "--free-scales"),
            (self.robust, "--robust"),
        ];
        let flags = flags.into_iter().filter(|(set, _)| *set).map(|(_, name)| name.to_string());
        let sensor = self.sensor.map(|axis| format!("--sensor={axis}"));
        flags.chain(sensor).chain(self.coil.map(|axis| format!("--coil={axis}"))).collect()
    }
}
