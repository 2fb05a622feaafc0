use physics::Kind;

/// What is asked of scalarcal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Use what `calibration` states of the sensors, with its uncertainty.
    pub known: bool,
    /// Weigh rows that are far from the rest down.
    pub robust: bool,
    /// The magnitude is constant and not known in recordings that have no reference.
    pub constant_magnitude: bool,
    /// Fit what the reference reads too much.
    pub reference_offset: bool,
    /// Use the direction of the known field as well, by the attitude.
    pub vector: bool,
    /// Effects of the catalogue that are fitted together with the sensors.
    pub with: Vec<Kind>,
    /// Length of the windows in which the calibration is told, s; None: up to eight parts of each recording.
    pub windows_s: Option<f64>,
}

impl Options {
    /// What the history records of the request.
    pub fn arguments(&self) -> Vec<String> {
        let flags = [
            (self.known, "--known"),
            (self.robust, "--robust"),
            (self.constant_magnitude, "--constant-magnitude"),
            (self.reference_offset, "--reference-offset"),
            (self.vector, "--vector"),
        ];
        let flags = flags.iter().filter(|(set, _)| *set).map(|(_, name)| name.to_string());
        let with = self.with.iter().map(|kind| format!("--with={}", kind.name()));
        flags.chain(with).chain(self.windows_s.map(|length| format!("--windows={length}"))).collect()
    }
}
