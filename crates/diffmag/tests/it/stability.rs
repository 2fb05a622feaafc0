//! Whether the matrix holds still: how often a pair whose matrix does is told otherwise, and that turned
//! axes, induction, a tilting pillar and a late clock are found by name. FLUXCAL_CAMPAIGNS sets how many
//! clean pairs.

use common::{Axis, Document, MatrixStability, OneMatrix};
use indexmap::IndexMap;
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::outside::outside;

fn campaigns() -> u64 {
    testkit::campaigns(5)
}

/// What the cases differ in; the field has a storm from half time on where that is said.
#[derive(Clone)]
struct Case {
    noise: Value,
    reference_noise: Value,
    days: f64,
    storm: bool,
    effects: Value,
    daily_k: f64,
}

fn case(noise: Value) -> Case {
    Case { noise, reference_noise: Value::Null, days: 3.0, storm: false, effects: json!([]), daily_k: 0.0 }
}

fn document(case: &Case, seed: u64) -> Document {
    let mut plan = json!({
        "fluxcal": 1,
        "seed": seed,
        "start": "2026-03-01T00:00:00Z",
        "instrument": {"noise": case.noise},
        "temperatures": {"sensor_temperature_c": 18.0, "electronics_temperature_c": 20.0, "daily_k": case.daily_k},
        "truth": {
            "calibration": {"reference_conditions": {"sensor_temperature_c": 18.0, "electronics_temperature_c": 20.0}},
            "model": {"effects": case.effects},
            "outside": outside(),
            "differential": {
                "reference": {"alpha_deg": 25.0, "beta_deg": 0.31, "gamma_deg": 0.22, "scale": [1.0012, 0.9985, 1.0007]},
                "test": {"phi_deg": [91.1, 0.9, 40.0], "theta_deg": [89.6, 90.4, 0.35], "scale": [0.9991, 1.0016, 0.9979]},
                "offset_nt": [12.0, -7.5, 21.0]
            }
        },
        "procedures": [
            {"procedure": "differential", "id": "pair", "length_s": case.days * 86_400.0, "step_s": 60}
        ]
    });
    if case.storm {
        plan["truth"]["outside"]["storm"] = json!({
            "time_s": 0.5 * case.days * 86_400.0,
            "sudden_nt": [28, -6, 9],
            "depression_nt": [-160, 25, 45],
            "growth_s": 18000,
            "recovery_s": 40000,
            "unrest": {"flicker_nt2_per_hz_at_1hz": 0.02, "flicker_exponent": 1.5}
        });
    }
    if !case.reference_noise.is_null() {
        plan["truth"]["differential"]["reference_noise"] = case.reference_noise.clone();
    }
    let plan = simulate::Plan::parse(&plan.to_string()).expect("a plan");
    simulate::campaign(&plan).expect("simulated").document
}

fn stability(document: Document) -> MatrixStability {
    let found = diffmag::run(document, &diffmag::Options::default()).expect("fitted");
    let found = found.calibration.expect("a calibration").differential.expect("a result");
    found.fit.expect("a fit").stability.expect("long enough")
}

/// Every probability of no change, by name.
fn probabilities(found: &MatrixStability) -> IndexMap<String, f64> {
    let mut all = IndexMap::new();
    let mut add = |name: &str, test: &OneMatrix| {
        all.insert(name.to_owned(), test.p);
        for (axis, test) in test.axes.iter() {
            all.insert(format!("{name}, axis {axis}"), test.p);
        }
    };
    let windows = found.windows.as_ref().expect("windows");
    add("windows", &windows.one_matrix);
    add("trend", &windows.no_trend);
    if let Some(test) = found.quiet_disturbed.as_ref().and_then(|found| found.one_matrix.as_ref()) {
        add("quiet and disturbed", test);
    }
    let bands = found.bands.as_ref().expect("bands");
    add("bands", &bands.one_matrix);
    add("bands with a clock", &bands.one_matrix_with_clock);
    if let Some(test) = &bands.one_matrix_short_periods {
        add("short periods", test);
    }
    all.insert("largest change".into(), windows.largest_change.p);
    let offset = &bands.clock.offset_s;
    let t = offset.value() / offset.std().expect("a std");
    all.insert("clock".into(), estimate::stats::two_sided_p(t, f64::INFINITY));
    all.insert("clock alike".into(), bands.clock.alike_p);
    for band in bands.bands.iter().filter(|band| band.tested) {
        for (axis, of) in band.axes.iter() {
            all.insert(format!("from {:.0} s axis {axis}", band.from_period_s), of.p.expect("tested"));
        }
    }
    all
}

/// Noise of a good pair.
fn good() -> Value {
    json!({"white_rms_nt": 0.02, "flicker_nt2_per_hz_at_1hz": 2e-5})
}

/// Counts how often a clean pair is told otherwise with p < 0.01.
fn stays_quiet(name: &str, make: impl Fn(u64) -> Document + Sync) {
    let count = campaigns();
    let all: Vec<IndexMap<String, f64>> =
        (0..count).into_par_iter().map(|seed| probabilities(&stability(make(seed)))).collect();
    let mut rates: IndexMap<&str, f64> = IndexMap::new();
    for (key, p) in all.iter().flatten() {
        *rates.entry(key).or_default() += f64::from(u8::from(*p < 0.01)) / count as f64;
    }
    // With few campaigns, what a rate of 1 % exceeds in one of a hundred thousand.
    let most = if count < 1000 {
        (0.01 + 4.3 * (0.01_f64 / count as f64).sqrt() + 3.0 / count as f64).min(1.0)
    } else {
        0.02
    };
    let mut outside = Vec::new();
    for (key, rate) in rates {
        println!("{name}: {key}: {:.2} % of {count}", 100.0 * rate);
        if rate > most {
            outside.push(format!("{key}: {rate:.4}"));
        }
    }
    assert!(outside.is_empty(), "{name}: {}", outside.join(", "));
}

#[test]
fn clean_pairs_with_white_noise() {
    stays_quiet("white", |seed| document(&case(json!({"white_rms_nt": 0.1})), seed));
}

fn flicker() -> Value {
    json!({"white_rms_nt": 0.02, "flicker_nt2_per_hz_at_1hz": 1e-3})
}

#[test]
fn clean_pairs_with_flicker_noise() {
    stays_quiet("flicker", |seed| document(&case(flicker()), seed));
}

/// Noise as long records have it: cut out of one that is four times as long, so that its ends do not meet.
#[test]
fn clean_pairs_with_flicker_noise_of_a_longer_record() {
    stays_quiet("longer record", |seed| {
        let mut document = document(&case(json!({"white_rms_nt": 0.02})), seed);
        for axis in Axis::ALL {
            let column =
                document.recordings[0].columns.get_mut(&format!("test_{axis}_nt")).expect("a column");
            let rows = column.len();
            let mut stream = noise::Stream::new(seed, &format!("longer {axis}"));
            let longer = noise::power_law(&mut stream, 4 * rows, 60.0, 1e-3, 1.0);
            column.iter_mut().zip(longer).for_each(|(reading, noise)| *reading += noise);
        }
        document
    });
}

/// Noise of the reference biases quiet times more than disturbed ones, and short periods more than long ones.
#[test]
fn clean_pairs_with_noise_in_both_and_a_storm() {
    let noise = json!({"white_rms_nt": 0.1, "flicker_nt2_per_hz_at_1hz": 1e-4});
    let both = Case { reference_noise: noise.clone(), storm: true, ..case(noise) };
    stays_quiet("both", |seed| document(&both, seed));
}

/// Turns the test instrument about z by so many arcsec from a row on.
fn turned(mut document: Document, arcsec: f64, from: usize) -> Document {
    let angle = (arcsec / 3600.0).to_radians();
    let columns = &mut document.recordings[0].columns;
    let (x, y) = (columns["test_x_nt"].clone(), columns["test_y_nt"].clone());
    for row in from..x.len() {
        columns["test_x_nt"][row] = angle.cos() * x[row] + angle.sin() * y[row];
        columns["test_y_nt"][row] = angle.cos() * y[row] - angle.sin() * x[row];
    }
    document
}

#[test]
fn a_turn_halfway() {
    let found = stability(turned(document(&case(good()), 5), 400.0, 2160));
    println!("{:#?}", found.findings);
    let windows = found.windows.expect("windows");
    assert!(windows.one_matrix.p < 1e-3, "{}", windows.one_matrix.p);
    let change = &windows.largest_change;
    // Test x takes in y by the angle, or test y takes in x by its opposite.
    let sign = match change.element.as_str() {
        "yx" => 1.0,
        "xy" => -1.0,
        other => panic!("{other}"),
    };
    let truth = sign * 1e6 * (400.0_f64 / 3600.0).to_radians();
    let apart = (change.change_ppm.value() - truth) / change.change_ppm.std().expect("a std");
    assert!(apart.abs() < 3.5, "{} for {truth}", change.change_ppm.value());
    assert!(found.findings.iter().any(|finding| finding.contains("is not constant")), "{:?}", found.findings);
}

#[test]
fn induction_that_differs() {
    let mut parameters = json!({"zx_ppm": 10_000.0, "time_constant_s": 600.0});
    for place in ["xx", "xy", "xz", "yx", "yy", "yz", "zy", "zz"] {
        parameters[format!("{place}_ppm")] = json!(0.0);
    }
    let effects = json!([{"effect": "induction_difference", "parameters": parameters}]);
    for storm in [false, true] {
        let found =
            stability(document(&Case { effects: effects.clone(), storm, days: 6.0, ..case(good()) }, 6));
        println!("{:#?}", found.findings);
        let named = |finding: &&String| finding.contains("induced currents") && finding.contains("z from x");
        assert!(found.findings.iter().filter(|f| f.contains("depends on the period")).any(|f| named(&f)));
        let disturbed = found.quiet_disturbed.expect("ranked");
        assert_eq!(disturbed.one_matrix.is_some(), storm, "{}", disturbed.activity_ratio);
        assert!(!found.findings.iter().any(|finding| finding.contains("clock")), "{:?}", found.findings);
    }
}

#[test]
fn a_pillar_that_tilts_by_day() {
    let effects = json!([{
        "effect": "pillar_tilt",
        "parameters": {"about_x_arcsec_per_k": 0.8, "about_y_arcsec_per_k": -0.5, "lag_s": 14400}
    }]);
    let mut recorded = document(&Case { effects, daily_k: 0.6, days: 15.0, ..case(good()) }, 7);
    let found = stability(recorded.clone());
    assert!(
        !found.findings.iter().any(|finding| finding.contains("depends on the period")),
        "{:?}",
        found.findings
    );
    // Where no temperature is recorded, the matrix takes its place.
    for recording in &mut recorded.recordings {
        recording.columns.retain(|name, _| !name.ends_with("_c"));
    }
    let found = stability(recorded);
    println!("{:#?}", found.findings);
    let told = found.findings.iter().find(|finding| finding.contains("depends on the period")).expect("told");
    assert!(told.contains("a tilting pillar or a temperature"), "{told}");
}

#[test]
fn a_late_clock() {
    let effects = json!([{"effect": "clock_offset", "parameters": {"offset_s": 2.0}}]);
    let found = stability(document(&Case { effects, ..case(good()) }, 8));
    println!("{:#?}", found.findings);
    let bands = found.bands.expect("bands");
    assert!(bands.one_matrix.p < 1e-3 && bands.one_matrix_with_clock.p > 1e-3);
    let offset = &bands.clock.offset_s;
    let apart = (offset.value() - 2.0) / offset.std().expect("a std");
    assert!(apart.abs() < 3.5, "{} ± {}", offset.value(), offset.std().expect("a std"));
    assert!(found.findings.iter().any(|finding| finding.contains("clock is late")), "{:?}", found.findings);
    assert!(!found.findings.iter().any(|finding| finding.contains("depends on the period")));
}

#[test]
fn a_short_recording_is_not_divided() {
    let found = diffmag::run(document(&Case { days: 0.2, ..case(good()) }, 9), &diffmag::Options::default());
    let found = found.expect("fitted").calibration.expect("a calibration").differential.expect("a result");
    assert!(found.fit.expect("a fit").stability.is_none());
}

/// Where the matrix rests on long periods only, the stretches that are quiet or disturbed are long enough to
/// have them.
#[test]
fn long_periods_alone_are_compared() {
    let plan = testkit::read_fixture("plans/observatory-pair.json");
    let plan = simulate::Plan::parse(&plan).expect("a plan");
    let document = simulate::campaign(&plan).expect("simulated").document;
    let found = diffmag::run(document, &diffmag::Options::default()).expect("fitted");
    let fit = found.calibration.and_then(|c| c.differential?.fit).expect("a fit");
    let highest =
        fit.axes.iter().filter_map(|(_, axis)| axis.weighted_up_to_hz).fold(f64::INFINITY, f64::min);
    let found = fit.stability.expect("long enough");
    println!("{:#?}", found.findings);
    assert!(!found.findings.iter().any(|finding| finding.contains("cannot be determined")));
    let compared = found.quiet_disturbed.expect("ranked");
    assert!(compared.one_matrix.is_some() && compared.stretch_s * highest >= 4.0, "{}", compared.stretch_s);
    assert!(found.windows.is_some() && found.bands.is_some());
}
