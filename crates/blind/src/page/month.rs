//! What diffmag and diagnose made of the observatory's month, in words and figures.

use concealed::case::Truth;
use serde_json::Value;

/// 0 °C, K.
const ZERO_C: f64 = 273.15;

/// What the two stages made of the month.
pub fn section(truth: &Truth, compared: &Value, answer: &Value) -> String {
    let of = |which: usize, key: &str| truth.effects[which].parameters[key].as_f64().unwrap_or(f64::NAN);
    let differential = &compared["calibration"]["differential"]["fit"];
    let list = |value: &Value| -> Vec<String> {
        let all = value.as_array().into_iter().flatten();
        all.filter_map(|one| one.as_str().map(str::to_string)).collect()
    };
    let entry = &answer["diagnosis"][0];
    let fit = |key: &str| entry["fit"][key].as_f64().unwrap_or(f64::NAN);
    let mut text = format!(
        "## A month of an observatory\n\n\
        A variometer beside the reference, {} rows of a minute. Concealed: on y an offset whose slope changes sign at {:.2} K (± {:.2} nT/K far from it, along a hyperbola), a clock {:.2} s late, \
        on z one step of {:.2} nT after {:.2} days. Noise {:.3} nT.\n\n`diffmag --correct-clock` says of it:\n\n",
        truth.readings / 3,
        of(0, "inflection_c") + ZERO_C,
        of(0, "slope_nt_per_k"),
        of(1, "offset_s"),
        of(2, "height_nt"),
        of(2, "time_s") / 86_400.0,
        truth.noise_nt
    );
    let quantity = |of: &Value| {
        let part = |key: &str| of[key].as_f64().unwrap_or(f64::NAN);
        format!("{:.3} ± {:.3}", part("value"), part("std"))
    };
    text += &format!("- the clocks differ by {} s\n", quantity(&differential["clock"]["offset_s"]));
    for event in differential["kept_out"]["events"].as_array().into_iter().flatten() {
        text += &format!(
            "- a {} on {} of {} nT after {:.2} days\n",
            event["kind"].as_str().unwrap_or_default(),
            event["axis"].as_str().unwrap_or_default(),
            quantity(&event["size_nt"]),
            event["time_s"].as_f64().unwrap_or(f64::NAN) / 86_400.0
        );
    }
    for finding in list(&differential["findings"]).iter().filter(|words| words.starts_with("axis y")) {
        text += &format!("- {finding}\n");
    }
    text += &format!(
        "\n`diagnose`, given that calibration, and the clock in its model: **{}**; rms {:.3} nT with the calibration fitted again, {:.3} nT with what was found, readings left out {:.3} nT.\n\n",
        entry["verdict"].as_str().unwrap_or("none").replace('_', " "),
        fit("rms_refitted_nt"),
        fit("rms_after_nt"),
        fit("held_out_after_nt")
    );
    for effect in entry["effects"].as_array().into_iter().flatten() {
        let target =
            ["sensor", "coil", "column"].iter().find_map(|key| effect[*key].as_str()).unwrap_or("all");
        let parameters: Vec<String> = effect["parameters"]
            .as_object()
            .into_iter()
            .flatten()
            .filter_map(|(name, found)| {
                let (value, std) = (found["value"].as_f64()?, found["std"].as_f64().unwrap_or(0.0));
                Some(format!("{name} = {value:.4} ± {std:.4}"))
            })
            .collect();
        text += &format!(
            "- `{}` of {target}: {}\n",
            effect["effect"].as_str().unwrap_or_default(),
            parameters.join(", ")
        );
    }
    for place in entry["where"].as_array().into_iter().flatten() {
        let share = place["energy_share"].as_f64();
        let share = share.map_or(String::new(), |share| format!(", {:.0} % of the energy", 100.0 * share));
        text += &format!("- where: {}{share}\n", place["description"].as_str().unwrap_or_default());
    }
    for reason in list(&entry["reasons"]).iter().filter(|words| words.starts_with("rejected ")) {
        text += &format!("- {reason}\n");
    }
    let sets: Vec<String> =
        entry["ambiguity"].as_array().into_iter().flatten().map(|set| list(set).join(" with ")).collect();
    if !sets.is_empty() {
        text += &format!("\nIndistinguishable: {}.\n", sets.join("; "));
    }
    text
}
