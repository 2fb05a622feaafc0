//! Campaigns that are drawn.

use serde_json::{Value, json};

/// Random numbers that follow from a seed (SplitMix64).
pub struct Draw(u64);

impl Draw {
    /// From a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(0x1234_5678_9ABC_DEF1))
    }

    /// From −1 to 1, all alike.
    pub fn even(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// A whole number from 0 up to `end`, without it.
    pub fn below(&mut self, end: usize) -> usize {
        (((self.even() + 1.0) / 2.0 * end as f64) as usize).min(end.saturating_sub(1))
    }

    /// Rows whose columns are unit vectors, each up to about `tilt` rad from its axis.
    fn directions(&mut self, tilt: f64) -> Value {
        let columns = [0, 1, 2].map(|k| {
            let vector = [0, 1, 2].map(|i| if i == k { 1.0 } else { tilt * self.even() });
            let length = vector.iter().map(|part| part * part).sum::<f64>().sqrt();
            vector.map(|part| part / length)
        });
        json!([0, 1, 2].map(|i| [0, 1, 2].map(|j: usize| columns[j][i])))
    }
}

/// The plan of a campaign with a truth that is drawn: constants, offsets, directions, what is left in the
/// coils and in the shield. Constants are stated with an uncertainty within which they are true, directions
/// as nominal. Readings are exact but for white and flicker noise; a law that needs other noise, temperatures
/// or effects puts them in.
pub fn plan(seed: u64, procedures: Value) -> Value {
    let mut draw = Draw::new(seed);
    let axes = ["x", "y", "z"];
    let object = |items: Vec<Value>| -> Value {
        axes.iter().map(|axis| axis.to_string()).zip(items).collect::<serde_json::Map<_, _>>().into()
    };
    let coil = json!({"resistor_ohm": 5.0, "resistor_relative_uncertainty": 1e-6, "max_nt": 65000});
    let (mut stated, mut truth) = ((Vec::new(), Vec::new()), (Vec::new(), Vec::new()));
    for _ in axes {
        let (constant, off) = (42_000.0 + 1500.0 * draw.even(), [draw.even(), draw.even()]);
        stated.0.push(json!({"constant_nt_per_a": {"value": constant, "std": 0.1}, "offset_nt": {"value": 0.0, "std": 0.2}}));
        truth.0.push(json!({"constant_nt_per_a": constant + 0.1 * off[0], "offset_nt": 0.2 * off[1]}));
        let (sensitivity, off) = (6400.0 + 5.0 * draw.even(), [draw.even(), draw.even()]);
        stated.1.push(json!({"sensitivity_nt_per_v": {"value": sensitivity, "std": 0.05}, "offset_nt": {"value": 0.0, "std": 0.3}}));
        truth.1.push(json!({"sensitivity_nt_per_v": sensitivity + 0.05 * off[0], "offset_nt": 0.3 * off[1]}));
    }
    let nominal = json!([[1, 0, 0], [0, 1, 0], [0, 0, 1]]);
    let mut three = |size: f64| object(axes.iter().map(|_| (size * draw.even()).into()).collect());
    let (residual, shield) = (three(0.3), three(3.0));
    json!({
        "fluxcal": 1,
        "seed": seed,
        "start": "2026-03-02T08:00:00Z",
        "facility": {
            "coils": {"x": coil, "y": coil, "z": coil},
            "voltmeter": {"absolute_v": 2e-5, "relative": 1e-6},
            "reference_std_nt": 0.1, "reference_range_nt": [1000, 70000],
            "theodolite_arcsec": 1.0, "residual_field_std_nt": 0.2
        },
        "instrument": {
            "sensors": axes, "range_nt": 70000, "nominal_sensitivity_nt_per_v": 6400,
            "noise": {"white_rms_nt": 0.05, "flicker_nt2_per_hz_at_1hz": 1e-4, "flicker_exponent": 1.0}
        },
        "calibration": {
            "coils": object(stated.0),
            "sensors": object(stated.1),
            "axes": {"sensors": {"matrix": nominal}, "coils": {"matrix": nominal}},
            "reference_conditions": {"sensor_temperature_c": 23.0, "electronics_temperature_c": 24.0, "coil_temperature_c": 21.0}
        },
        "temperatures": {"sensor_temperature_c": 23.5, "electronics_temperature_c": 23.0, "coil_temperature_c": 21.5, "daily_k": 0.5},
        "truth": {
            "calibration": {
                "coils": object(truth.0),
                "sensors": object(truth.1),
                "axes": {"sensors": {"matrix": draw.directions(0.03)}, "coils": {"matrix": draw.directions(0.03)}}
            },
            "residual_field_nt": residual,
            "shield_field_nt": shield
        },
        "procedures": procedures
    })
}

/// A model in which temperatures act on every sensor and coil, the sensitivity's change listed before the
/// offset's.
pub fn warm(seed: u64) -> Value {
    let mut draw = Draw::new(seed);
    let mut effects = Vec::new();
    for axis in ["x", "y", "z"] {
        for (name, unit, size) in [
            ("sensitivity_temperature", "ppm", 30.0),
            ("offset_temperature", "nt", 0.2),
            ("sensitivity_electronics_temperature", "ppm", 5.0),
            ("offset_electronics_temperature", "nt", 0.1),
        ] {
            let parameters = json!({
                format!("coefficient_{unit}_per_k"): size * draw.even(),
                format!("curvature_{unit}_per_k2"): 0.02 * size * draw.even()
            });
            effects.push(json!({"effect": name, "sensor": axis, "parameters": parameters}));
        }
        let parameters = json!({"coefficient_ppm_per_k": 5.0 * draw.even()});
        effects.push(json!({"effect": "coil_temperature", "coil": axis, "parameters": parameters}));
    }
    json!({"effects": effects})
}
