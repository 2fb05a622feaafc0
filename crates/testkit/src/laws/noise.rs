//! Noise of twice the size.

use serde_json::{Value, json};

use super::walk::{is_apart, numbers, objects, recordings};

/// The plan without any noise, error or uncertainty that is drawn: what would have been read.
pub fn quiet(plan: &Value) -> Value {
    let mut quiet = plan.clone();
    if let Some(instrument) = quiet["instrument"].as_object_mut() {
        instrument.insert("noise".into(), json!({"white_rms_nt": 0.0}));
    }
    for drawn in ["site", "offset_wander"] {
        quiet["truth"].as_object_mut().expect("a truth").remove(drawn);
    }
    quiet["facility"]["reference_std_nt"] = 0.0.into();
    quiet["facility"]["voltmeter"] = json!({});
    objects(&mut quiet["facility"], "", &mut |_, object| {
        object.remove("resistor_relative_uncertainty");
    });
    quiet
}

/// The document with everything that its readings have beyond the quiet ones twice as large, and twice the
/// uncertainties that it declares.
pub fn double_noise(document: &Value, quiet: &Value) -> Value {
    let mut doubled = document.clone();
    for (recording, quiet) in
        recordings(&mut doubled).zip(quiet["recordings"].as_array().expect("recordings"))
    {
        assert_eq!(recording["id"], quiet["id"], "the same recordings");
        for (name, column) in recording["columns"].as_object_mut().expect("columns") {
            let without = quiet["columns"][name].as_array().expect("the same columns");
            for (value, without) in column.as_array_mut().expect("a column").iter_mut().zip(without) {
                if let (Some(noisy), Some(without)) = (value.as_f64(), without.as_f64()) {
                    *value = (without + 2.0 * (noisy - without)).into();
                }
            }
        }
    }
    for part in ["facility", "instrument", "calibration"] {
        objects(&mut doubled[part], "", &mut |_, object| {
            for (name, value) in object.iter_mut() {
                match declared(name) {
                    0 => {}
                    power => numbers(value, &|number| number * 2_f64.powi(power)),
                }
            }
        });
    }
    doubled
}

/// By which power of the noise a declared uncertainty grows.
fn declared(name: &str) -> i32 {
    match name {
        "std"
        | "white_rms_nt"
        | "random_walk_nt_per_sqrt_s"
        | "reference_std_nt"
        | "residual_field_std_nt"
        | "theodolite_arcsec"
        | "theodolite_shared_arcsec"
        | "std_arcsec"
        | "absolute_v"
        | "relative"
        | "resistor_relative_uncertainty" => 1,
        "covariance" | "flicker_nt2_per_hz_at_1hz" => 2,
        _ => 0,
    }
}

/// Holds the standard uncertainties of an answer against twice those of another one, to a part of them, and
/// says how many they are; those of power densities go with the square, those of pure numbers (exponents,
/// shares) and what stands `apart` are left out.
pub fn doubled(law: &str, found: &Value, once: &Value, part: f64, apart: &[&str]) -> usize {
    let mut differences = Vec::new();
    let count = twice("", found, once, part, apart, &mut differences);
    assert!(differences.is_empty(), "{law}:\n{}", differences.join("\n"));
    count
}

fn twice(path: &str, found: &Value, once: &Value, part: f64, apart: &[&str], out: &mut Vec<String>) -> usize {
    if is_apart(path, apart) {
        return 0;
    }
    let number = |value: &Value| if value.get("value").is_some() { value.get("std")?.as_f64() } else { None };
    if let (Some(found), Some(once)) = (number(found), number(once)) {
        let key = path.rsplit('.').next().unwrap_or(path);
        let factor = match key {
            _ if key.contains("exponent") || key.contains("share") => return 0,
            _ if key.contains("nt2_per_hz") => 4.0,
            _ => 2.0,
        };
        if (found - factor * once).abs() > part * factor * once {
            out.push(format!("{path}: {found} is not {factor} times {once} (ratio {:.9})", found / once));
        }
        return 1;
    }
    match (found, once) {
        (Value::Object(a), Value::Object(b)) => {
            let both = a.iter().filter_map(|(key, a)| Some((key, a, b.get(key)?)));
            both.map(|(key, a, b)| twice(&format!("{path}.{key}"), a, b, part, apart, out)).sum()
        }
        (Value::Array(a), Value::Array(b)) => {
            let both = a.iter().zip(b).enumerate();
            both.map(|(place, (a, b))| twice(&format!("{path}.{place}"), a, b, part, apart, out)).sum()
        }
        _ => 0,
    }
}
