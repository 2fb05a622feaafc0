//! Coverage of the streamed answer's 95 % intervals over simulated pairs, white and flicker noise, under a
//! field like nature's (f^-1.6). FLUXCAL_CAMPAIGNS sets how many.

use diffmag::stream::{Estimate, answer};

use crate::answers::{Said, over};
use crate::stream::{ETA, Truth, pair};

const ROWS: usize = 16_500;

/// For each parameter whether its 95 % interval holds the truth.
fn campaign(truth: Truth, seed: u64) -> Said {
    // The pieces of the pyramid lie elsewhere in each campaign.
    let first_s = 1000.0 + (seed * 7919 % 65_537) as f64;
    let fit = answer(&pair(&truth, ROWS, first_s, seed).partial(0..ROWS, ROWS)).expect("an answer");
    let mut said = Said::default();
    let mut of = |name: &str, estimate: &Estimate, truth: f64| {
        let half = estimate::stats::coverage_factor(0.95, estimate.freedom) * estimate.std;
        said.holds(name, (estimate.value - truth).abs() <= half);
    };
    for (j, axis) in fit.axes.iter().enumerate() {
        for (i, row) in ETA.iter().enumerate() {
            let plain = axis.least_squares[i];
            of("eta weighted", &axis.weighted[i], row[j]);
            of("eta least squares as the source has it", &plain, row[j]);
            if truth.drift_nt_per_day == 0.0 {
                let std = axis.least_squares_std_noise[i];
                of("eta least squares", &Estimate { std, freedom: f64::INFINITY, ..plain }, row[j]);
            }
        }
        of("drift", &axis.drift_nt_per_day, truth.drift_nt_per_day);
        of("white", &axis.noise.white_rms_nt, truth.white_rms_nt);
        if truth.flicker > 0.0 {
            let value = (axis.noise.flicker_nt2_per_hz_at_1hz.value / truth.flicker).ln();
            let log = Estimate { value, std: axis.noise.flicker_log_std, freedom: f64::INFINITY };
            of("flicker at 1 Hz", &log, 0.0);
            of("exponent", &axis.noise.flicker_exponent, truth.exponent);
        } else {
            of("offset", &axis.offset_nt, 0.0);
        }
        for octave in &axis.octaves {
            let octave = octave.agreement;
            if let Some((eta, std)) = octave.matrix.zip(octave.std) {
                let freedom = octave.differences as f64 - 3.0;
                of("eta by octave", &Estimate { value: eta[0], std: std[0], freedom }, ETA[0][j]);
            }
        }
    }
    for axis in &fit.axes {
        if truth.flicker == 0.0 {
            said.holds("no flicker", axis.noise.flicker_nt2_per_hz_at_1hz.value == 0.0);
        }
        for octave in &axis.octaves {
            let [low, high] = octave.allan_interval_nt;
            said.holds("allan", (low..=high).contains(&true_deviation(&truth, octave.agreement.averaging_s)));
        }
    }
    said
}

/// Allan deviation of averages of m samples, the step being 1 s.
fn true_deviation(truth: &Truth, m: f64) -> f64 {
    let level = m.log2() as usize;
    let flicker = estimate::haar::power_law_variances(truth.exponent, level + 1)[level];
    (0.5 * (truth.flicker * flicker + 2.0 * truth.white_rms_nt.powi(2) / m)).sqrt()
}

fn covers(name: &str, truth: Truth) {
    let count = testkit::campaigns(10);
    let shares = over(name, count, |seed| campaign(truth, seed));
    // What is counted together in one campaign is not independent.
    let slack = if count < 1000 { 3.0 * (0.95 * 0.05 / count as f64).sqrt() } else { 0.0 };
    let mut outside = Vec::new();
    for (key, (held, of)) in shares.iter().filter(|(key, _)| !key.ends_with("as the source has it")) {
        let share = held / *of as f64;
        let most = if key == "no flicker" { 1.0 } else { 0.97 + slack };
        if !(0.93 - slack..=most).contains(&share) {
            outside.push(format!("{key}: {share:.3}"));
        }
    }
    assert!(outside.is_empty(), "{name}: {}", outside.join(", "));
}

#[test]
fn intervals_hold() {
    for (name, [white_rms_nt, flicker, exponent, drift_nt_per_day]) in [
        ("white", [0.1, 0.0, 1.0, 0.0]),
        ("flicker", [0.02, 1e-3, 1.0, 0.5]),
        ("weak flicker", [0.1, 2e-5, 1.0, 0.0]),
        ("steep", [0.02, 1e-4, 1.5, 0.0]),
    ] {
        covers(name, Truth { white_rms_nt, flicker, exponent, drift_nt_per_day });
    }
}
