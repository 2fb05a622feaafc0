//! Reversals, noise and offset drift in a shield.

use noise::Stream;
use serde_json::{Value, json};

use crate::build::{K, change, near, read, recording, sensor, with};

/// + − − + … with a shield's field that drifts, and one bad pair where `bad` says.
fn reversals(seed: u64, pairs: usize, noise: f64, bad: Option<usize>) -> Value {
    let mut stream = Stream::new(seed, "reversal");
    let (mut time, mut position, mut volts) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..2 * pairs {
        let p = if matches!(row % 4, 0 | 3) { 1.0 } else { -1.0 };
        let t = 30.0 * row as f64;
        let shield = 4.0 + 0.002 * t;
        let slip = if bad.is_some_and(|pair| row == 2 * pair) { 3.0 } else { 0.0 };
        time.push(t);
        position.push(p);
        volts.push(read(&mut stream, p * shield + slip, 1.5, noise));
    }
    let columns = [("time_s", time), ("position", position), ("sensor_x_v", volts)];
    recording("reversal", "sensor_offset_reversal", &columns)
}

#[test]
fn by_hand() {
    // NASA eq. 26, sign right: V = (±4 − 1.5)/k, O = −k (V₁ + V₂)/2 = 1.5 nT; the shield's drift drops out.
    let found = sensor(&with(vec![reversals(1, 10, 1e-6, None)]));
    let reversal = found.reversal.expect("reversals");
    assert!((reversal.offset_nt.value() - 1.5).abs() < 1e-5);
    let one = &reversal.recordings[0];
    let drift = one.shield_drift_nt_per_s.as_ref().expect("a drift");
    assert!((drift.value() - 0.002).abs() < 1e-7);
    // The middle of 570 s.
    assert!((one.shield_field_nt.value() - 4.57).abs() < 1e-4);
    assert!(one.pairs.offset_nt.iter().all(|offset| (offset - 1.5).abs() < 1e-4));
    // Three degrees: 4.57 (1 − cos 3°)/2 and sin 3°/2 for each nT across.
    assert!((reversal.imperfect_turn.bound_nt - 4.57 * 0.001_370_5 / 2.0).abs() < 1e-5);
    assert!((reversal.imperfect_turn.bound_per_nt_across - 0.052_336 / 2.0).abs() < 1e-5);
}

#[test]
fn one_bad_pair_moves_nothing() {
    let clean = sensor(&with(vec![reversals(2, 10, 0.02, None)])).reversal.expect("reversals");
    let bad = sensor(&with(vec![reversals(2, 10, 0.02, Some(4))])).reversal.expect("reversals");
    assert_eq!(bad.recordings[0].pairs.used.iter().filter(|used| !**used).count(), 1);
    assert!(!bad.recordings[0].pairs.used[4]);
    assert!((bad.offset_nt.value() - clean.offset_nt.value()).abs() < 0.02);
    assert!(bad.findings.iter().any(|finding| finding.contains("from row 8")), "{:?}", bad.findings);
}

fn noise(seed: u64, rows: usize, step: f64, white: f64, code: f64) -> Value {
    let mut stream = Stream::new(seed, "noise");
    let time: Vec<f64> = (0..rows).map(|row| row as f64 * step).collect();
    let round = |v: f64| if code > 0.0 { (v / code).round() * code } else { v };
    let volts = time.iter().map(|_| round((white * stream.normal() + 0.3) / K)).collect();
    recording("noise", "sensor_noise", &[("time_s", time), ("sensor_x_v", volts)])
}

#[test]
fn was_it_the_sensor_or_the_quantiser() {
    // Codes of 0.064 nT round by 0.0185 nT rms: beside noise of 0.2, 0.03 and 0.02 nT 1, 28 and 46 %.
    for (white, verdict) in [(0.2, "sensor"), (0.03, "both")] {
        let noise = sensor(&with(vec![noise(3, 20_000, 0.01, white, 1e-5)])).noise.expect("noise");
        let series = &noise.series[0];
        assert_eq!(series.measured, verdict, "{white}");
        assert!((series.code_nt.expect("a code") / 0.064 - 1.0).abs() < 1e-9);
        assert!(near(&noise.white_rms_nt, white, 4.0), "{:?}", noise.white_rms_nt);
        // δ²Δt/6.
        let rounding = series.rounding_nt2_per_hz.expect("rounding");
        assert!((rounding / (0.064f64.powi(2) * 0.01 / 6.0) - 1.0).abs() < 1e-9);
    }
    let coarse = sensor(&with(vec![noise(3, 20_000, 0.01, 0.02, 2e-5)])).noise.expect("noise");
    assert_eq!(coarse.series[0].measured, "quantiser");
    // Rounding of 0.128/√12 g nT is to be a tenth of the whole: g² = (0.037²)/(0.02²/9), about 5.5. Codes of
    // six times the noise hide how small it is, so that the figure is a lower bound.
    let gain = coarse.series[0].amplification_needed.expect("an amplification");
    assert!((2.0..5.5).contains(&gain), "{gain}");
    assert!(coarse.findings.iter().any(|finding| finding.contains("amplify")));
}

#[test]
fn a_line_is_told_and_kept_out() {
    let mut document = with(vec![noise(4, 20_000, 0.01, 0.1, 0.0)]);
    let line = |row: usize| 0.05 * (std::f64::consts::TAU * 16.7 * 0.01 * row as f64).sin();
    change(&mut document["recordings"][0], "sensor_x_v", |row, volts| volts + line(row) / K);
    let noise = sensor(&document).noise.expect("noise");
    let [line] = &noise.lines[..] else { panic!("one line") };
    assert!((line.frequency_hz - 16.7).abs() < 0.003 && (line.amplitude_nt - 0.05).abs() < 0.006);
    assert!((noise.white_rms_nt.value() - 0.1).abs() < 0.003);
}

fn dates(offset: impl Fn(f64) -> f64) -> Vec<Value> {
    let date = |number: usize| {
        let days = 7.0 * number as f64;
        let mut one = reversals(100 + number as u64, 6, 0.02, None);
        change(&mut one, "sensor_x_v", |_, volts| volts - offset(days) / K);
        let start = common::time::Start { unix_s: 1.7e9 + 86_400.0 * days, offset_s: 0.0 };
        one["procedure"] = json!("offset_drift");
        one["id"] = json!(format!("drift-{number}"));
        one["start"] = json!(start.text().expect("a date"));
        one
    };
    (0..53).map(date).collect()
}

#[test]
fn trend_and_year_are_found_where_they_are() {
    let year = |days: f64| std::f64::consts::TAU * days / 365.25;
    let with_both = dates(|days| 0.4 * days / 365.25 + 0.2 * year(days).cos() - 0.1 * year(days).sin());
    let drift = sensor(&with(with_both)).drift.expect("a drift");
    let trend = drift.trend_nt_per_year.as_ref().expect("a trend");
    let annual = drift.annual.as_ref().expect("a year");
    assert!(near(trend, 0.4, 3.5) && drift.trend_p.expect("p") < 0.01, "{trend:?}");
    assert!(near(&annual.cosine_nt, 0.2, 3.5) && near(&annual.sine_nt, -0.1, 3.5), "{annual:?}");
    assert!(annual.p_value < 1e-4, "{annual:?}");
    let still = sensor(&with(dates(|_| 0.0))).drift.expect("a drift");
    assert!(still.trend_p.expect("p") > 0.01 && still.annual.expect("a year").p_value > 0.01);
    assert!((still.mean_nt.value() - 1.5).abs() < 0.01 && still.rms_nt < 0.02);
}

#[test]
fn a_drift_follows_the_temperature_that_was_recorded() {
    let mut all = dates(|days| 0.05 * (days / 9.0).sin() * 3.0);
    for (number, one) in all.iter_mut().enumerate() {
        let temperature = 20.0 + 3.0 * (7.0 * number as f64 / 9.0).sin();
        one["columns"]["sensor_temperature_c"] = json!(vec![temperature; 12]);
    }
    let drift = sensor(&with(all)).drift.expect("a drift");
    let coefficient = drift.temperature_nt_per_k.expect("a coefficient");
    assert!(near(&coefficient, 0.05, 3.5), "{coefficient:?}");
}

#[test]
fn coarse_codes_do_not_make_an_offset_sure() {
    // Codes of 1.92 nT, nothing else: all pairs read the same, and the offset is rounded by half a code.
    let mut reversal = reversals(5, 10, 0.0, None);
    reversal["columns"].as_object_mut().expect("columns").remove("time_s");
    change(&mut reversal, "sensor_x_v", |_, volts| (volts / 3e-4).round() * 3e-4);
    let mut document = with(vec![reversal]);
    document["instrument"]["quantisation_v"] = json!(3e-4);
    let offset = sensor(&document).reversal.expect("reversals").offset_nt;
    let std = offset.std().expect("a std");
    assert!(std >= 1.92 / 24f64.sqrt() && near(&offset, 1.5, 2.0), "{offset:?}");
}

#[test]
fn few_pairs_of_unknown_noise_cover() {
    // White noise that nobody states: 95 % intervals cover in 90 % of 300 at least.
    for pairs in [2, 3, 5, 10] {
        let mut covered = 0;
        for seed in 0..300 {
            let reversal =
                sensor(&with(vec![reversals(1000 + seed, pairs, 0.02, None)])).reversal.expect("reversals");
            let half = reversal.coverage_factor_95 * reversal.offset_nt.std().expect("a std");
            covered += u32::from((reversal.offset_nt.value() - 1.5).abs() <= half);
        }
        println!("{pairs} pairs: {covered} of 300");
        assert!((273..=300).contains(&covered), "{pairs} pairs: {covered} of 300");
    }
}

#[test]
fn noise_at_uneven_times_is_read_and_that_is_said() {
    let at = |seed: u64, time: &dyn Fn(usize) -> f64| {
        let mut made = noise(seed, 5000, 0.01, 0.1, 0.0);
        change(&mut made, "time_s", |row, _| time(row));
        sensor(&with(vec![made])).noise.expect("noise")
    };
    let off = |row: usize| 0.9 * f64::from((row as u32 * 7) % 5) / 4.0;
    let uneven = at(8, &|row| 0.01 * (row as f64 + off(row)));
    assert!(uneven.findings.iter().any(|finding| finding.contains("uneven")), "{:?}", uneven.findings);
    // A cubic between two readings has less than their noise, least of all at short periods.
    assert!(uneven.white_rms_nt.value() < 0.1, "{:?}", uneven.white_rms_nt);
    // Printed to the millisecond, at three readings in ten milliseconds.
    let even = at(9, &|row| (row as f64 / 0.3).round() * 1e-3);
    assert!(!even.findings.iter().any(|finding| finding.contains("uneven")), "{:?}", even.findings);
    assert!(near(&even.white_rms_nt, 0.1, 4.0), "{:?}", even.white_rms_nt);
}
