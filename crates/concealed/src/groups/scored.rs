//! What a published proof has scored, and printed for everybody to look at.
//!
//! By the rule of [`super::Group`] it is looked at from then on. After each proof its own entries are added
//! here: everything in the table of kinds, every name among the failures, and all that its set of the outside
//! went through.

/// Names and forms that were scored in the proof of the commitment `9b9e46d668ab`: first those of its table,
/// then those that stood in failures of several effects at once.
pub const KINDS: [(&str, &str); 17] = [
    ("ageing", "stretched exponential"),
    ("sensitivity_ageing", "logarithm of age"),
    ("axis_creep", "three relaxation times"),
    ("offset_temperature_inflection", "hyperbola"),
    ("hysteresis", "play operators"),
    ("offset_temperature_lag", "diffusion"),
    ("offset_temperature_lag", "thermometer elsewhere"),
    ("sensitivity_temperature_lag", "one body in still air"),
    ("sensitivity_temperature_lag", "three bodies"),
    ("sensitivity_temperature_lag", "diffusion"),
    ("offset_electronics_temperature_lag", "two bodies"),
    ("offset_electronics_temperature_lag", "diffusion"),
    ("sensitivity_electronics_temperature_lag", "three bodies"),
    ("sensitivity_electronics_temperature", "band gap"),
    ("warm_up", "board and box"),
    ("clipping", "rounded end"),
    ("eddy_currents", "two rings"),
];

/// What is outside the catalogue and was scored there: twelve cases went through all ten of the group, and
/// through two of them again.
pub const OUTSIDE: [&str; 10] = [
    "heat flow of either direction",
    "bend that follows temperature",
    "humidity that turns an axis",
    "beat with a switching supply",
    "loop that rings in large fields",
    "multiplexer that slews",
    "relay that toggles",
    "sensitivity with a load",
    "geomagnetic pulsations",
    "coils that share a supply",
];
