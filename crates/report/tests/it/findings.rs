//! Findings by what they do to the result, on documents by hand.

use report::{Effect, Item};
use serde_json::{Value, json};

use crate::page;

/// Of each finding in the list at the head: by how much it moves the result, and its first words.
fn listed(document: &Value) -> Vec<(String, String)> {
    let page = page(document);
    let section = page.sections.iter().find(|section| section.id == "findings").expect("findings");
    let tables = section.items.iter().filter_map(|item| match item {
        Item::Table(table) => Some(table),
        _ => None,
    });
    let words = |text: String| text.split(' ').take(5).collect::<Vec<_>>().join(" ");
    tables.flat_map(|table| &table.rows).map(|row| (row[0].to_string(), words(row[1].to_string()))).collect()
}

/// The effect of a finding that is the only one of a document.
fn effect(document: &Value) -> Effect {
    let page = page(document);
    let all: Vec<_> = page.sections.iter().flat_map(|section| &section.warnings).collect();
    assert_eq!(all.len(), 1, "{all:?}");
    all[0].effect
}

fn sensor(part: &str, content: Value) -> Value {
    json!({"fluxcal": 1, "calibration": {"sensors": {"x": {part: content}}}})
}

#[test]
fn what_moves_most_comes_first_and_what_has_no_number_last() {
    let document = json!({"fluxcal": 1, "calibration": {
        "sensors": {"x": {
            "sensitivity": {
                // The readings scatter by 9 nT: that is not what any of the findings moves.
                "noise": {"rms_nt": 9.0},
                "residuals": {"field_nt": [-1.0, 0.0, 1.0], "deviation_nt": [0.5, -0.1, -0.4], "residual_nt": [0.2, 0.0, -0.2]},
                "findings": ["the residuals are not normal (Anderson-Darling p = 0.001)",
                    "not a straight line: cubic (unadjusted p = 0.001, adjusted p = 0.01); fitted jointly with k and O"],
                "finding_codes": ["residuals_not_normal", "nonlinear"]
            },
            "drift": {
                "dates": {"time_d": [0.0, 365.25, 730.5], "offset_nt": [0.0, 0.4, 0.8], "std_nt": [0.1, 0.1, 0.1], "residual_nt": [0.0, 0.0, 0.0]},
                "trend_nt_per_year": {"value": 0.4, "std": 0.01},
                "findings": ["the trend is significant under correlated noise (p = 0.001); its standard uncertainty would be 0.01 nT a year under white noise"], "finding_codes": ["trend"]
            }
        }},
        "axes": {
            "doubtful": [{"recording": "a", "orientation": 1, "row": 0, "coil": "x", "sensor": "y", "leave_one_out_nt": -2.0, "t": -9.0, "p_adjusted": 1e-6}],
            "readings": {"orientation": [1, 1], "recording": ["a", "a"], "row": [0, 0], "coil": ["x", "x"], "sensor": ["x", "y"],
                "residual_nt": [0.0, -1.5], "leverage": [0.9, 0.25], "leave_one_out_nt": [0.0, -2.0], "t": [0.0, -9.0]},
            "findings": ["the readings put the constant of coil x 5.3 standard uncertainties from the value that the document states; it was fitted without this prior"],
            "finding_codes": ["prior_contradicted:5.3"]
        }
    }});
    let expected = [
        ("0.8 nT", "sensor x: the trend is"),
        ("0.5 nT", "orientation 1 (\"a\", row 0),"),
        ("0.3 nT", "sensor x: not a straight"),
        ("5.3 standard uncertainties", "the readings put the constant"),
        ("– (uncertainties only)", "sensor x: the residuals are"),
    ];
    assert_eq!(listed(&document), expected.map(|(effect, words)| (effect.into(), words.into())));
    // The terminal and the page of a section keep that order.
    let sensors =
        page(&document).sections.into_iter().find(|section| section.id == "sensors").expect("sensors");
    let first: Vec<bool> = sensors.warnings.iter().map(|one| one.words.contains("straight line")).collect();
    assert_eq!(first, [true, false]);
}

#[test]
fn turns_count_in_a_field_of_50_000_nt() {
    let second = std::f64::consts::PI / 648_000.0;
    let unit = |turn: f64| json!([[1.0, 0.0, 0.0], [turn, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let document = json!({"fluxcal": 1, "calibration": {
        "axes": {"coils": {"matrix": unit(10.0 * second)}, "known_coils": {"matrix": unit(0.0)},
            "findings": ["the readings contradict the known directions of the coils; the coils may have moved"], "finding_codes": ["known_coils_contradicted"]},
        "scalar": {"reference_offset": {"offset_nt": {"value": -2.0, "std": 0.1}, "p_value": 1e-9, "fitted": false},
            "findings": ["the reference reads -2.0 nT too high (p = 1e-9), or another error"], "finding_codes": ["reference_offset"]}
    }});
    // 10 arcsec are 2.4 nT.
    let found: Vec<String> = listed(&document).into_iter().map(|(effect, _)| effect).collect();
    assert_eq!(found, ["10 arcsec", "2 nT"]);
}

#[test]
fn offsets_that_disagree_and_pairs_that_were_left_out() {
    let both = json!({"fluxcal": 1, "calibration": {"sensors": {"x": {
        "sensitivity": {"offset_nt": {"value": 1.25, "std": 0.1}, "findings": ["the offset in the coil is 1.25, by reversals 0.5: they disagree (p = 0.001)"], "finding_codes": ["offsets_disagree"]},
        "reversal": {"offset_nt": {"value": 0.5, "std": 0.1}}}}}});
    assert_eq!(effect(&both), Effect::Nt(0.75));
    // Means of 0, 2 and 10, and of 0 and 2.
    let pairs = sensor(
        "reversal",
        json!({"offset_nt": {"value": 1.0, "std": 0.1},
            "recordings": [{"recording": "r", "offset_nt": {"value": 1.0, "std": 0.1}, "shield_field_nt": 0.0,
                "pairs": {"row": [0, 2, 4], "offset_nt": [0.0, 2.0, 10.0], "used": [true, true, false]}, "noise": {}}],
            "findings": ["recording \"r\": the pair from row 4 is an outlier and left out"], "finding_codes": ["outliers:r"]}),
    );
    assert_eq!(effect(&pairs), Effect::Nt(3.0));
}

#[test]
fn a_part_of_the_time_counts_by_the_parameter_that_stands_out_most() {
    let scalar = |values: Value| {
        json!({"fluxcal": 1, "calibration": {"scalar": {
            "parameters": [{"name": "sensitivity of x", "unit": "nT/V", "value": 5000.0, "std": 0.1},
                {"name": "offset of x", "unit": "nT", "value": 10.0, "std": 0.1}],
            "stability": {"p_value": 1e-9, "windows": [{"from_s": 0.0, "to_s": 1.0, "rows": 9, "rms_nt": 1.0, "values": values, "std": [0.1, 0.1]}]},
            "findings": ["the calibration is not constant in time: 1 part differ from it"], "finding_codes": ["not_constant"]}}})
    };
    // Five uncertainties of the offset against two of the sensitivity; then eight of that, 0.8 of 5000 in 50
    // 000 nT.
    assert_eq!(effect(&scalar(json!([5000.2, 10.5]))), Effect::Nt(0.5));
    let Effect::Nt(size) = effect(&scalar(json!([5000.8, 10.5]))) else { panic!("a field") };
    assert!((size - 8.0).abs() < 1e-9, "{size}");
}

#[test]
fn findings_on_absolute_measurements_and_their_baselines() {
    let set = |recording: &str, day: u8| json!({"recording": recording, "time": format!("2025-01-{day:02}T12:00:00Z")});
    let mut misread = set("b", 2);
    misread["readings"] = json!([{"residual_arcsec": 40.0, "leave_one_out_arcsec": 60.0, "t": 9.0}, {"residual_arcsec": 1.0, "leave_one_out_arcsec": 1.1, "t": -2.0}]);
    misread["findings"] = json!(["row 0 is off by 60″"]);
    misread["finding_codes"] = json!(["outliers:b"]);
    let step = |size: f64| json!({"value": [0.0], "std": [1.0], "steps": [{"after": "a", "before": "c", "size": size}]});
    let document = json!({"fluxcal": 1, "calibration": {"absolute": {
        "sets": [set("a", 1), misread, set("c", 3)],
        "adopted": {"start": "2025-01-01T00:00:00Z", "time_s": [0.0], "components": {"h_nt": step(-3.0), "d_deg": step(0.01)}},
        "findings": ["h_nt of \"c\" is off", "h_nt steps by −3", "d_deg steps by 0.01"],
        "finding_codes": ["outliers:c", "baseline_steps:h_nt", "baseline_steps:d_deg"]}}});
    let expected = [
        ("36 arcsec", "d_deg steps by 0.01"),
        ("20 arcsec", "b: row 0 is off"),
        ("3 nT", "h_nt steps by −3"),
        ("– (left out of the result)", "h_nt of \"c\" is off"),
    ];
    assert_eq!(listed(&document), expected.map(|(effect, words)| (effect.into(), words.into())));
}

#[test]
fn a_number_that_the_document_does_not_hold_is_not_made_up() {
    let said = ["without numbers", "of a later version", "without a code"];
    let bare = sensor("sensitivity", json!({"findings": said, "finding_codes": ["nonlinear", "of_later"]}));
    let found: Vec<String> = listed(&bare).into_iter().map(|(effect, _)| effect).collect();
    assert_eq!(found, ["– (not in the document)"; 3]);
    let insignificant = sensor(
        "drift",
        json!({"dates": {"time_d": [0.0, 365.25]}, "trend_nt_per_year": {"value": 9.0, "std": 9.0},
            "findings": ["the trend is not significant under correlated noise (p = 0.3); its standard uncertainty would be 9 nT a year"], "finding_codes": ["trend_not_significant"]}),
    );
    assert_eq!(effect(&insignificant), Effect::Unstated("not significant"));
}
