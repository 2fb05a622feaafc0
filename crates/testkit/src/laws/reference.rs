//! The temperatures from which changes count.

use serde_json::{Value, json};

use super::walk::quantity;

/// Sensor and electronics, as the catalogue's names have them.
const PARTS: [(&str, &str); 2] =
    [("sensor_temperature_c", ""), ("electronics_temperature_c", "electronics_")];

/// Moves the reference temperatures of sensors, electronics and coils by so many kelvin and states every
/// constant and coefficient as it is there: the same instrument, in other numbers.
///
/// A reading is V = (E(S(B)) − O)/k, S and E each the change by one part's temperature, B (1 + s) + o with s
/// and o polynomials of T − T_ref. At another T_ref, S = a S' + o₀ with a = 1 + s₀: so k' = k/a, O' = (O −
/// o₀)/a, and what E does to o₀ belongs to its offset, and what is listed behind the temperatures, an effect
/// of fields across, shrinks by a. That is exact where the sensitivity's change is listed before the
/// offset's, as the law asks. Uncertainties stay, though they belong to the old reference.
pub fn move_reference(document: &Value, by_k: [f64; 3]) -> Value {
    let mut moved = document.clone();
    let names = [PARTS[0].0, PARTS[1].0, "coil_temperature_c"];
    for (name, by) in names.iter().zip(by_k) {
        let reference = &mut moved["calibration"]["reference_conditions"][*name];
        *reference = (reference.as_f64().expect("a reference temperature") + by).into();
    }
    for axis in ["x", "y", "z"] {
        for ((_, part), by) in PARTS.iter().zip(by_k) {
            sensor(&mut moved, axis, part, by);
        }
        coil(&mut moved, axis, by_k[2]);
    }
    moved
}

/// a + b T + c T² as [a, b, c], moved.
fn shifted([a, b, c]: [f64; 3], by: f64) -> [f64; 3] {
    [a + b * by + c * by * by, b + 2.0 * c * by, c]
}

fn sensor(document: &mut Value, axis: &str, part: &str, by: f64) {
    let names = |of: &str| [format!("{of}_{part}temperature"), format!("{of}_{part}temperature_lag")];
    let (mut scale, mut offset) = (1.0, 0.0);
    for (of, parameters) in [
        ("sensitivity", ["coefficient_ppm_per_k", "curvature_ppm_per_k2"]),
        ("offset", ["coefficient_nt_per_k", "curvature_nt_per_k2"]),
    ] {
        for name in names(of) {
            change(document, axis, &name, &mut |effect| {
                let [constant, slope, curvature] = shifted(polynomial(effect, parameters), by);
                if of == "sensitivity" {
                    scale = 1.0 + 1e-6 * constant
                } else {
                    offset += constant
                }
                put(effect, parameters, [slope / scale, curvature / scale]);
            });
        }
    }
    for key in ["sensitivity_nt_per_v", "sensitivity_nt_per_nt", "offset_nt"] {
        let Some(value) = document["calibration"]["sensors"][axis].get_mut(key).and_then(quantity) else {
            continue;
        };
        let old = value.as_f64().expect("a number");
        *value = if key == "offset_nt" { (old - offset) / scale } else { old / scale }.into();
    }
    if part.is_empty() {
        of_electronics(document, axis, offset, scale);
        for name in ["cross_field", "cross_field_sensitivity"] {
            change(document, axis, name, &mut |effect| {
                for name in ["first_nt", "second_nt", "mixed_nt"] {
                    let shrunk = size(effect, name) / scale;
                    put(effect, [name, ""], [shrunk, 0.0]);
                }
            });
        }
    }
}

/// What the electronics make of the part o₀ of the sensor's change that is now constant goes to their offset.
fn of_electronics(document: &mut Value, axis: &str, offset: f64, scale: f64) {
    let mut more = [0.0; 3];
    change(document, axis, "sensitivity_electronics_temperature", &mut |effect| {
        more = polynomial(effect, ["coefficient_ppm_per_k", "curvature_ppm_per_k2"])
            .map(|ppm| 1e-6 * ppm * offset);
    });
    change(document, axis, "offset_electronics_temperature", &mut |effect| {
        let parameters = ["coefficient_nt_per_k", "curvature_nt_per_k2"];
        let [_, slope, curvature] = polynomial(effect, parameters);
        put(effect, parameters, [(slope + more[1]) / scale, (curvature + more[2]) / scale]);
    });
}

/// k (1 + c (T − T_ref)) of a coil.
fn coil(document: &mut Value, axis: &str, by: f64) {
    let mut scale = 1.0;
    change(document, axis, "coil_temperature", &mut |effect| {
        let parameters = ["coefficient_ppm_per_k", ""];
        let [constant, slope, _] = shifted(polynomial(effect, parameters), by);
        scale = 1.0 + 1e-6 * constant;
        put(effect, parameters, [slope / scale, 0.0]);
    });
    let constant = document["calibration"]["coils"][axis].get_mut("constant_nt_per_a");
    if let Some(value) = constant.and_then(quantity) {
        *value = (value.as_f64().expect("a number") * scale).into();
    }
}

/// The effects of a name on a sensor or a coil.
fn change(document: &mut Value, axis: &str, name: &str, with: &mut dyn FnMut(&mut Value)) {
    let effects = document.get_mut("model").and_then(|model| model.get_mut("effects"));
    let effects = effects.and_then(Value::as_array_mut).into_iter().flatten();
    let here = |effect: &&mut Value| {
        effect["effect"] == name && (effect["sensor"] == axis || effect["coil"] == axis)
    };
    effects.filter(here).for_each(with);
}

fn polynomial(effect: &mut Value, names: [&str; 2]) -> [f64; 3] {
    [0.0, size(effect, names[0]), size(effect, names[1])]
}

/// A parameter; zero where there is none.
fn size(effect: &mut Value, name: &str) -> f64 {
    effect["parameters"].get_mut(name).and_then(quantity).and_then(|value| value.as_f64()).unwrap_or(0.0)
}

fn put(effect: &mut Value, names: [&str; 2], values: [f64; 2]) {
    for (name, value) in names.iter().zip(values) {
        if let Some(old) = effect["parameters"].get_mut(*name).and_then(quantity) {
            *old = json!(value);
        }
    }
}
