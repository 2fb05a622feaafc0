//! Whether the matrix holds still: how often a pair whose matrix does is told otherwise, and that turned
//! axes, induction, a tilting pillar and a late clock are found by name. FLUXCAL_CAMPAIGNS sets how many
//! clean pairs.

use common::{Axis, Document, MatrixStability, OneMatrix};
use serde_json::{Value, json};

use crate::answers::{Said, fit, off, over};
use crate::natural::{plan, simulated};

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
    let mut plan = plan(seed, &case.noise, case.days);
    let temperatures = json!({"sensor_temperature_c": 18.0, "electronics_temperature_c": 20.0});
    plan["truth"]["calibration"]["reference_conditions"] = temperatures.clone();
    plan["temperatures"] = temperatures;
    plan["temperatures"]["daily_k"] = json!(case.daily_k);
    plan["truth"]["model"]["effects"] = case.effects.clone();
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
    simulated(&plan).document
}

fn stability(document: &Document) -> MatrixStability {
    fit(document).stability.expect("long enough")
}

/// Which tests of a pair whose matrix holds still tell otherwise, with p < 0.01.
fn alarms(found: &MatrixStability) -> Said {
    let mut alarms = Said::default();
    let mut add = |name: String, p: f64| alarms.holds(name, p < 0.01);
    let mut add_test = |name: &str, test: &OneMatrix| {
        add(name.into(), test.p);
        test.axes.iter().for_each(|(axis, test)| add(format!("{name}, axis {axis}"), test.p));
    };
    let windows = found.windows.as_ref().expect("windows");
    add_test("windows", &windows.one_matrix);
    add_test("trend", &windows.no_trend);
    if let Some(test) = found.quiet_disturbed.as_ref().and_then(|found| found.one_matrix.as_ref()) {
        add_test("quiet and disturbed", test);
    }
    let bands = found.bands.as_ref().expect("bands");
    add_test("bands", &bands.one_matrix);
    add_test("bands with a clock", &bands.one_matrix_with_clock);
    if let Some(test) = &bands.one_matrix_short_periods {
        add_test("short periods", test);
    }
    add("largest change".into(), windows.largest_change.p);
    let clock = estimate::stats::two_sided_p(off(&bands.clock.offset_s, 0.0), f64::INFINITY);
    add("clock".into(), clock);
    add("clock alike".into(), bands.clock.alike_p);
    for band in bands.bands.iter().filter(|band| band.tested) {
        for (axis, of) in band.axes.iter() {
            add(format!("from {:.0} s axis {axis}", band.from_period_s), of.p.expect("tested"));
        }
    }
    alarms
}

/// Noise of a good pair.
fn good() -> Value {
    json!({"white_rms_nt": 0.02, "flicker_nt2_per_hz_at_1hz": 2e-5})
}

/// Counts how often a clean pair is told otherwise.
fn stays_quiet(name: &str, make: impl Fn(u64) -> Document + Sync) {
    let count = testkit::campaigns(4);
    let rates = over(name, count, |seed| alarms(&stability(&make(seed))));
    // With few campaigns, what a rate of 1 % exceeds in one of a hundred thousand.
    let most = if count < 1000 {
        (0.01 + 4.3 * (0.01_f64 / count as f64).sqrt() + 3.0 / count as f64).min(1.0)
    } else {
        0.02
    };
    let rate = |alarms: f64| alarms / count as f64;
    let outside = rates.iter().filter(|(_, (alarms, _))| rate(*alarms) > most);
    let outside: Vec<String> =
        outside.map(|(key, (alarms, _))| format!("{key}: {:.4}", rate(*alarms))).collect();
    assert!(outside.is_empty(), "{name}: {}", outside.join(", "));
}

#[test]
fn clean_pairs() {
    let white = json!({"white_rms_nt": 0.1});
    let flicker = json!({"white_rms_nt": 0.02, "flicker_nt2_per_hz_at_1hz": 1e-3});
    // Noise of the reference biases quiet times more than disturbed ones, and short periods more than long
    // ones.
    let both = json!({"white_rms_nt": 0.1, "flicker_nt2_per_hz_at_1hz": 1e-4});
    let both = Case { reference_noise: both.clone(), storm: true, ..case(both) };
    for (name, case) in [("white", case(white)), ("flicker", case(flicker)), ("both, with a storm", both)] {
        stays_quiet(name, |seed| document(&case, seed));
    }
}

/// Noise as long records have it: cut out of one that is four times as long, so that its ends do not meet.
#[test]
fn clean_pairs_with_flicker_noise_of_a_longer_record() {
    stays_quiet("longer record", |seed| {
        let mut document = document(&case(json!({"white_rms_nt": 0.02})), seed);
        for axis in Axis::ALL {
            let column = &mut document.recordings[0].columns[&format!("test_{axis}_nt")];
            let rows = column.len();
            let mut stream = noise::Stream::new(seed, &format!("longer {axis}"));
            let longer = noise::power_law(&mut stream, 4 * rows, 60.0, 1e-3, 1.0);
            column.iter_mut().zip(longer).for_each(|(reading, noise)| *reading += noise);
        }
        document
    });
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
    let found = stability(&turned(document(&case(good()), 5), 400.0, 2160));
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
    assert!(off(&change.change_ppm, truth).abs() < 3.5, "{} for {truth}", change.change_ppm.value());
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
        let case = Case { effects: effects.clone(), storm, days: 6.0, ..case(good()) };
        let found = stability(&document(&case, 6));
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
    let of_period = |found: MatrixStability| {
        found.findings.iter().find(|finding| finding.contains("depends on the period")).cloned()
    };
    assert_eq!(of_period(stability(&recorded)), None);
    // Where no temperature is recorded, the matrix takes its place.
    for recording in &mut recorded.recordings {
        recording.columns.retain(|name, _| !name.ends_with("_c"));
    }
    let told = of_period(stability(&recorded)).expect("told");
    assert!(told.contains("a tilting pillar or a temperature"), "{told}");
}

#[test]
fn a_late_clock() {
    let effects = json!([{"effect": "clock_offset", "parameters": {"offset_s": 2.0}}]);
    let found = stability(&document(&Case { effects, ..case(good()) }, 8));
    let bands = found.bands.expect("bands");
    assert!(bands.one_matrix.p < 1e-3 && bands.one_matrix_with_clock.p > 1e-3);
    let offset = &bands.clock.offset_s;
    assert!(off(offset, 2.0).abs() < 3.5, "{offset}");
    assert!(found.findings.iter().any(|finding| finding.contains("clock is late")), "{:?}", found.findings);
    assert!(!found.findings.iter().any(|finding| finding.contains("depends on the period")));
}

#[test]
fn a_short_recording_is_not_divided() {
    assert!(fit(&document(&Case { days: 0.2, ..case(good()) }, 9)).stability.is_none());
}
