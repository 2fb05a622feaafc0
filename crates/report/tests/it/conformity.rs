//! The statement of conformity: against numbers made in SciPy, by hand, and as it stands.

use common::{Axis, Document};
use report::conformity::{Judged, RequirementKind, Shown, ShownValue, Spec, Verdict};
use report::{Page, text};
use serde_json::{Value, json};
use std::fs;

use crate::{REPORT, fixture, magsat, parsed, same};

fn calibrated() -> Value {
    fixture("specs/calibrated/input.json")
}

/// What a document shows of each requirement of a specification.
fn judged(document: &Value, spec: &Value) -> Vec<Judged<'static>> {
    let spec = Spec::parse(&spec.to_string()).expect("a specification");
    report::conformity::judge(&parsed(document), Box::leak(spec.into())).expect("judged")
}

/// What a document shows of one requirement.
fn one(document: &Value, mut requirement: Value) -> Judged<'static> {
    requirement["title"] = "a requirement".into();
    judged(document, &json!({"fluxcal": 1, "title": "one", "requirements": [requirement]})).swap_remove(0)
}

/// Adds an effect of each sensor to the model.
fn add_effect(document: &mut Value, effect: &str, parameters: &Value) {
    for axis in ["x", "y", "z"] {
        let effect = json!({"effect": effect, "sensor": axis, "parameters": parameters});
        document["model"]["effects"].as_array_mut().expect("a list").push(effect);
    }
}

fn found(shown: &Shown) -> &ShownValue {
    shown.as_ref().expect("a value")
}

#[track_caller]
fn near(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance * expected.abs(), "{value} where {expected} is expected");
}

#[test]
fn values_and_uncertainties_are_those_of_draws_in_numpy() {
    let reference = fixture("reference/certificate.json");
    let all = judged(&calibrated(), &fixture("specs/magsat.json"));
    let pairs = |key: &str, kind: RequirementKind, years: bool| {
        let is = |one: &&Judged<'_>| one.requirement.kind == kind && one.requirement.years.is_some() == years;
        let shown = &all.iter().find(is).expect("a requirement").shown;
        let expected = reference["calibrated"][key].as_array().expect("a list");
        assert_eq!(expected.len(), shown.len(), "{key}");
        let pair = |(expected, shown): (&Value, &Shown)| {
            let [value, std] = ["value", "std"].map(|key| expected[key].as_f64().expect("a number"));
            let found = found(shown);
            println!("{key}: {:.5} ± {:.5}; by draws {value:.5} ± {std:.5}", found.value.abs(), found.std);
            [[found.value.abs(), value], [found.std, std]]
        };
        expected.iter().zip(shown).map(pair).collect::<Vec<_>>()
    };
    // The spread of 20 000 draws is known to 0.5 %; the largest of the two ways to turn is a little high in
    // draws.
    for (key, kind, years, of_value, of_std) in [
        ("orthogonality_deg", RequirementKind::OrthogonalityDeg, false, 1e-9, 0.015),
        ("axes_arcsec", RequirementKind::AxesArcsec, false, 0.015, 0.015),
        ("offset_over_temperature_nt", RequirementKind::OffsetStabilityNt, false, 1e-4, 0.015),
        ("offset_over_year_nt", RequirementKind::OffsetStabilityNt, true, 1e-9, 1e-9),
    ] {
        for [[value, value_by_draws], [std, std_by_draws]] in pairs(key, kind, years) {
            near(value, value_by_draws, of_value);
            near(std, std_by_draws, of_std);
        }
    }
    // The worst of 157 places is not quite the worst of 2 006.
    for [values, stds] in pairs("absolute_accuracy_nt", RequirementKind::AbsoluteAccuracyNt, true) {
        let [size, by_draws] = [0, 1].map(|of| values[of] + 1.96 * stds[of]);
        assert!((0.99..1.02).contains(&(size / by_draws)), "{size} beside {by_draws}");
    }
}

/// Sensor x turned by 3″ and known to 0.3″; the nominal directions are known to 0.4″: u = 0.5″.
#[test]
fn turned_since_the_nominal_directions_were_found() {
    let turned = (3.0f64 / 3600.0).to_radians();
    let matrix = json!([[turned.cos(), 0.0, 0.0], [turned.sin(), 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let document =
        json!({"fluxcal": 1, "calibration": {"axes": {"sensors": {"matrix": matrix, "std_arcsec": 0.3}}}});
    let with = |limit: f64| {
        let requirement = json!({"kind": "axes_from_nominal_arcsec", "limit": limit, "nominal_std_arcsec": 0.4,
            "nominal_matrix": [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]]});
        let one = one(&document, requirement);
        assert_eq!(one.decisive, Some(0));
        near(found(&one.shown[0]).value, 3.0, 1e-6);
        near(found(&one.shown[0]).std, 0.5, 1e-9);
        one.verdict
    };
    // 3 + 1.645 · 0.5 = 3.8225, 3 − 1.645 · 0.5 = 2.1775.
    assert_eq!(
        [3.8226, 3.8224, 2.1776, 2.1774].map(with),
        [Verdict::Pass, Verdict::NotShown, Verdict::NotShown, Verdict::Fail]
    );
}

/// 0.06″/K and 0.08″/K over 30 K are 3″; their uncertainties of 0.01 and 0.02″/K make 0.6″.
#[test]
fn turned_by_temperature() {
    let mut document = json!({"fluxcal": 1, "model": {"effects": []},
        "calibration": {"reference_conditions": {"sensor_temperature_c": 20.0}}});
    let turn = json!({"first_arcsec_per_k": {"value": 0.06, "std": 0.01}, "second_arcsec_per_k": {"value": -0.08, "std": 0.02}});
    add_effect(&mut document, "axis_temperature", &turn);
    let requirement =
        json!({"kind": "axes_over_temperature_arcsec", "limit": 5.0, "sensor_temperature_c": [-10.0, 40.0]});
    let one = one(&document, requirement);
    near(found(&one.shown[2]).value, 3.0, 1e-12);
    near(found(&one.shown[2]).std, 0.6, 1e-12);
    assert_eq!(one.verdict, Verdict::Pass);
}

/// A lag of 4 ms lets 39.79 Hz through; u(τ)/τ = 1/40. An output that stands at 60 000 nT is a range of 60
/// 000 nT.
#[test]
fn bandwidth_by_its_lag_and_a_range_by_its_end() {
    let mut input = calibrated();
    add_effect(&mut input, "loop_bandwidth", &json!({"lag_s": {"value": 0.004, "std": 0.0001}}));
    input["calibration"]["sensors"]["y"]["sensitivity"]["saturation"] =
        json!({"readings": [null, 9.4], "fields_nt": [null, 60000.0], "count": 5});
    let bandwidth = one(&input, json!({"kind": "bandwidth_hz", "limit": 25.0}));
    near(found(&bandwidth.shown[0]).value, 39.788_735_773, 1e-11);
    near(found(&bandwidth.shown[0]).std, 0.994_718_394_324, 1e-12);
    assert_eq!(bandwidth.verdict, Verdict::Pass);
    let of = |limit: f64| {
        let one = one(&input, json!({"kind": "range_nt", "limit": limit}));
        (one.verdict, found(&one.shown[one.decisive.expect("one")]).of.clone())
    };
    assert_eq!(of(64000.0), (Verdict::Fail, "sensor y above zero".into()));
    // Below zero it was seen to follow to −50 025 nT, and no farther.
    assert_eq!(of(55000.0), (Verdict::NotShown, "sensor x below zero".into()));
    assert_eq!(of(50000.0).0, Verdict::Pass);
}

#[test]
fn accuracy_is_shown_where_the_calibration_covers_all_that_is_asked() {
    let with = |input: &Value, range: f64| {
        let requirement = json!({"kind": "absolute_accuracy_nt", "limit": 5.0, "range_nt": range, "years": 1.0,
            "sensor_temperature_c": "calibrated", "electronics_temperature_c": [0.0, 50.0]});
        one(input, requirement)
    };
    let mut input = calibrated();
    assert_eq!(with(&input, 50000.0).verdict, Verdict::NotShown);
    let turn = json!({"first_arcsec_per_k": {"value": 0.01, "std": 0.005}, "second_arcsec_per_k": {"value": 0.0, "std": 0.005}});
    add_effect(&mut input, "axis_temperature", &turn);
    assert_eq!(with(&input, 50000.0).verdict, Verdict::Pass);
    assert_eq!(with(&input, 64000.0).verdict, Verdict::NotShown);
    // A known drift of 20 nT in a year is more than any uncertainty: that fails.
    for axis in ["x", "y", "z"] {
        input["calibration"]["sensors"][axis]["drift"]["trend_nt_per_year"] =
            json!({"value": 20.0, "std": 0.1});
    }
    assert_eq!(with(&input, 50000.0).verdict, Verdict::Fail);
    // What the budget has no term for is named.
    let mut other = calibrated();
    let warm_up = json!({"effect": "warm_up", "sensor": "y", "parameters": {"amplitude_nt": 1.0, "time_constant_s": 600.0}});
    other["model"]["effects"].as_array_mut().expect("a list").push(warm_up);
    let one = with(&other, 50000.0);
    let gaps = &found(&one.shown[0]).gaps;
    assert!(gaps.iter().any(|gap| gap.contains("sensor y") && gap.contains("warm_up")), "{gaps:?}");
}

/// Constants that are stated without their recordings give a figure over the whole range, and no pass.
#[test]
fn a_stated_calibration_passes_no_accuracy() {
    let requirement = json!({"kind": "absolute_accuracy_nt", "limit": 5.0, "range_nt": 64000.0});
    let one = one(&fixture("axescal/magsat/expected.json"), requirement);
    assert_eq!(one.verdict, Verdict::NotShown);
    // 1.36″ in 64 000 nT across are 0.42 nT; axes that are 5.8° off a right angle make it a little more.
    let largest = one.shown.iter().map(|shown| found(shown).std).fold(0.0, f64::max);
    assert!((0.42..0.60).contains(&largest), "{largest}");
    let gaps = &found(&one.shown[0]).gaps;
    assert!(gaps.iter().any(|gap| gap.contains("its calibrated range of fields is unknown")), "{gaps:?}");
}

/// A document with nothing in it shows nothing, and says for each requirement what would.
#[test]
fn nothing_is_shown_of_an_empty_document() {
    for one in judged(&json!({"fluxcal": 1}), &fixture("specs/magsat.json")) {
        assert_eq!((one.verdict, one.decisive), (Verdict::NotShown, None), "{:?}", one.requirement.kind);
        assert!(!one.shown.is_empty() && one.shown.iter().all(Result::is_err));
    }
}

/// What a fixture may show in part is not taken as shown: each part that is taken away turns the requirement
/// to not shown.
#[test]
fn what_is_taken_away_is_not_shown() {
    for (part, kind) in [
        ("noise", "noise_zero_to_peak_nt"),
        ("drift", "offset_stability_nt"),
        ("temperature", "offset_stability_nt"),
        ("sensitivity", "range_nt"),
    ] {
        let mut input = calibrated();
        input["calibration"]["sensors"]["y"].as_object_mut().expect("an object").remove(part);
        for one in judged(&input, &fixture("specs/magsat.json"))
            .iter()
            .filter(|one| one.requirement.kind.name() == kind)
        {
            let years = one.requirement.years.is_some();
            if kind == "offset_stability_nt" && years != (part == "drift") {
                continue;
            }
            let missing = one.shown[Axis::Y.index()].as_ref().expect_err(kind);
            assert!(missing.of.starts_with("sensor y"), "{missing:?}");
        }
    }
    let mut input = calibrated();
    input["calibration"]["sensors"]["y"]["temperature"]["electronics"] = Value::Null;
    let requirement =
        json!({"kind": "offset_stability_nt", "limit": 9.0, "electronics_temperature_c": [0.0, 40.0]});
    assert_eq!(one(&input, requirement).verdict, Verdict::NotShown);
}

/// A value without an uncertainty decides nothing; a sensor that the instrument does not have is not asked
/// for.
#[test]
fn without_uncertainty_nothing_is_shown() {
    let lag = json!({"effect": "loop_bandwidth", "sensor": "x", "parameters": {"lag_s": 0.004}});
    let mut input = json!({"fluxcal": 1, "instrument": {"sensors": ["x"]}, "model": {"effects": [lag]}});
    let requirement = json!({"kind": "bandwidth_hz", "limit": 25.0});
    let bare = one(&input, requirement.clone());
    assert_eq!((bare.verdict, bare.shown.len()), (Verdict::NotShown, 1));
    assert!(bare.shown[0].as_ref().expect_err("no uncertainty").why.contains("no uncertainty"));
    input["model"]["effects"][0]["parameters"]["lag_s"] = json!({"value": 0.004, "std": 0.0001});
    assert_eq!(one(&input, requirement).verdict, Verdict::Pass);
}

#[test]
fn a_covariance_that_does_not_go_with_its_order_is_refused() {
    let mut input = calibrated();
    input["calibration"]["sensors"]["x"]["temperature"]["covariance"].as_array_mut().expect("a list").pop();
    let error = Document::parse(&input.to_string()).expect_err("a wrong covariance");
    assert_eq!(
        error.to_string(),
        "calibration.sensors.x.temperature.covariance: found 7 rows of up to 8 numbers; expected 8 rows of 8, as its `covariance_order` has names"
    );
}

/// The statement of the fixture, word for word.
#[test]
fn golden() {
    let section = report::conformity::section(&parsed(&calibrated()), &magsat()).expect("a statement");
    let page = Page { title: "Golden".into(), sections: vec![section], ..Page::default() };
    same("specs/calibrated/expected.txt", &text::render(&page));
}

/// Every specification of `fixtures/specs/bad` brings its message, exit code 2, and nothing on standard
/// output.
#[test]
fn each_fault_of_a_specification_has_its_message() {
    let folder = testkit::fixture("specs/bad");
    let entries = fs::read_dir(&folder).expect("a folder").map(|entry| entry.expect("an entry").file_name());
    let names = entries.map(|name| name.into_string().expect("UTF-8"));
    let mut names: Vec<String> = names.filter(|name| name.ends_with(".json")).collect();
    names.sort();
    assert!(names.len() >= 20);
    for name in names {
        let run = testkit::run_in(REPORT, &folder, &["--spec", &name, "../calibrated/input.json"]);
        same(&format!("specs/bad/{}", name.replace(".json", ".txt")), &run.stderr);
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{name}");
    }
}

/// Whatever the verdicts, the exit code is 0; the words count them, and no verdict stands in a colour alone.
#[test]
fn a_statement_by_the_program() {
    let run = |more: &[&str]| {
        let arguments = [more, &["--spec", "magsat.json", "calibrated/input.json"]].concat();
        let run = testkit::run_in(REPORT, &testkit::fixture("specs"), &arguments);
        assert_eq!(run.code, 0);
        (run.stdout, run.stderr)
    };
    let (html, said) = run(&[]);
    assert!(said.contains("conformity: 11 requirements: 4 pass, 2 fail, 5 not shown."), "{said}");
    for verdict in [Verdict::Pass, Verdict::NotShown, Verdict::Fail] {
        assert!(html.contains(&format!(">{}<", verdict.word())), "{verdict:?}");
    }
    assert_eq!(html, run(&["-q"]).0);
    let help = testkit::run(REPORT, &["--help"], "").stdout;
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(help.contains("the exit code is 0 whatever its verdicts"), "{help}");
}

/// The committed schema is the one that the types give; the specification is valid by it. BLESS=1 writes it
/// anew.
#[test]
fn committed_schema_and_fixtures() {
    let schema =
        common::schema::titled(schemars::schema_for!(Spec), "fluxcal specification", "spec.schema.json");
    let file = testkit::fixture("../schemas/spec.schema.json");
    if testkit::bless() {
        fs::write(&file, common::to_text(&schema)).expect("written");
    }
    let committed: Value =
        serde_json::from_str(&fs::read_to_string(&file).expect("committed")).expect("JSON");
    assert!(committed == schema, "the types have changed: run with BLESS=1, read the difference, commit it");
    let specifications = jsonschema::validator_for(&schema).expect("a schema");
    assert!(specifications.is_valid(&fixture("specs/magsat.json")));
    let documents = jsonschema::validator_for(&common::schema::document()).expect("a schema");
    assert!(documents.is_valid(&calibrated()));
    for name in ["key-unknown", "kind-unknown", "limit-missing", "limit-as-text", "temperatures-as-words"] {
        assert!(!specifications.is_valid(&fixture(&format!("specs/bad/{name}.json"))), "{name}");
    }
}
