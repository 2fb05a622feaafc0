//! Another unit of everything electrical.

use common::covariance::rows;
use faer::diag::DiagRef;
use serde_json::{Map, Value};

use super::walk::{covariance, numbers};

/// Volts and amperes by another measure, of which there are `factor` times as many: readings and drives grow
/// by it, and nT/V and nT/A shrink. Resistances stay.
pub fn scale_volts(document: &Value, factor: f64) -> Value {
    let mut scaled = document.clone();
    scale(&mut scaled, factor);
    scaled
}

fn scale(value: &mut Value, factor: f64) {
    match value {
        Value::Array(list) => list.iter_mut().for_each(|item| scale(item, factor)),
        Value::Object(object) => {
            covariances(object, factor);
            for (name, value) in object.iter_mut() {
                let power = power(name, value);
                if power == 0 {
                    scale(value, factor);
                } else {
                    numbers(value, &|number| number * factor.powi(power));
                }
            }
            shift(object, factor);
        }
        _ => {}
    }
}

/// By which power of the factor what stands at a key grows: `_v` and `_a` by one, `_per_v` and `_per_m_a` by
/// minus one.
fn power(name: &str, value: &Value) -> i32 {
    // Lists in the unit of the recording, whose keys cannot say it.
    let plain = value.is_array() || value.is_number();
    match name {
        "type_a" | "covariance" => return 0,
        "reading" if plain => return 1,
        "sensitivity" | "sensitivity_std" if plain => return -1,
        _ => {}
    }
    let all: Vec<&str> = name.split(|c: char| !c.is_ascii_alphanumeric()).collect();
    let electrical = |word: &str| match word {
        "v" | "a" => 1,
        "a2" => 2,
        "a3" => 3,
        _ => 0,
    };
    match all.iter().position(|word| *word == "per") {
        Some(per) => -all[per..].iter().map(|word| electrical(word)).sum::<i32>(),
        None => all.last().map_or(0, |word| electrical(word)),
    }
}

fn covariances(object: &mut Map<String, Value>, factor: f64) {
    let Some((covariance, names)) = covariance(object) else { return };
    let of = |name: &String| factor.powi(power(name.rsplit('.').next().unwrap_or(name), &Value::Null));
    let factors: Vec<f64> = names.iter().map(of).collect();
    let factors = DiagRef::from_slice(&factors);
    object.insert("covariance".into(), rows(&(factors * covariance * factors)).into());
}

/// By how much a parameter moved: its unit stands in its name.
fn shift(object: &mut Map<String, Value>, factor: f64) {
    let Some(name) = object.get("parameter").and_then(Value::as_str) else { return };
    let power = power(name.rsplit('.').next().unwrap_or(name), &Value::Null);
    if let Some(shift) = object.get_mut("shift") {
        numbers(shift, &|number| number * factor.powi(power));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_is_electrical_grows_or_shrinks() {
        let document = json!({
            "columns": {"sensor_x_v": [2.0], "coil_x_a": [4.0], "time_s": [1.0]},
            "sensitivity_nt_per_v": {"value": 8.0, "std": 2.0}, "gradient_nt_per_m_a": 6.0, "fall_ppm_per_a2": 4.0,
            "uncertainty": {"offset_nt": {"type_a": 1.0}},
            "covariance": [[4.0, 2.0], [2.0, 1.0]], "covariance_order": ["sensitivity_nt_per_v", "offset_nt"]
        });
        let expected = json!({
            "columns": {"sensor_x_v": [4.0], "coil_x_a": [8.0], "time_s": [1.0]},
            "sensitivity_nt_per_v": {"value": 4.0, "std": 1.0}, "gradient_nt_per_m_a": 3.0, "fall_ppm_per_a2": 1.0,
            "uncertainty": {"offset_nt": {"type_a": 1.0}},
            "covariance": [[1.0, 1.0], [1.0, 1.0]], "covariance_order": ["sensitivity_nt_per_v", "offset_nt"]
        });
        assert_eq!(scale_volts(&document, 2.0), expected);
    }
}
