use clap::ValueEnum;
use common::Axis;

/// What is asked of axescal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Whether η is to be found or is given.
    pub coils: Coils,
    /// Where the iteration begins.
    pub start: Start,
    /// Leave the scales of sensors and coils free.
    pub free_scales: bool,
    /// Weigh readings far from the rest down.
    pub robust: bool,
    /// Use this sensor alone.
    pub sensor: Option<Axis>,
    /// Use the readings with this coil alone.
    pub coil: Option<Axis>,
}

/// Whether η is to be found or is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Coils {
    /// η is found with μ.
    #[default]
    Unknown,
    /// η is `calibration.axes.coils`, with its covariance.
    Known,
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
        let mut arguments = Vec::new();
        let mut flag = |set: bool, name: &str| {
            if set {
                arguments.push(name.to_string());
            }
        };
        flag(self.coils == Coils::Known, "--known-coils");
        flag(self.start == Start::Document, "--start=document");
        flag(self.free_scales, "--free-scales");
        flag(self.robust, "--robust");
        arguments.extend(self.sensor.map(|axis| format!("--sensor={axis}")));
        arguments.extend(self.coil.map(|axis| format!("--coil={axis}")));
        arguments
    }
}
