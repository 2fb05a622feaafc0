//! Coverage of the streamed answer's 95 % intervals over simulated pairs, white and flicker noise, under a
//! field like nature's (f^-1.6). FLUXCAL_CAMPAIGNS sets how many.

use common::Quantity;
use diffmag::stream::answer;

use crate::answers::{Said, elements, holds, over};
use crate::stream::{ETA, Truth, pair};

const ROWS: usize = 16_500;

/// For each parameter whether its 95 % interval holds the truth.
fn campaign(truth: Truth, seed: u64) -> Said {
    // The pieces of the pyramid lie elsewhere in each campaign.
    let first_s = 1000.0 + (seed * 7919 % 65_537) as f64;
    let found = answer(&pair(&truth, ROWS, first_s, seed).partial(0..ROWS, ROWS)).expect("an answer");
    let (fit, offset_nt) = (found.fit.expect("a fit"), found.offset_nt.expect("an offset"));
    let mut said = Said::default();
    let mut inside = |name: &str, off: f64, std: f64, freedom: f64| {
        said.holds(name, off.abs() <= estimate::stats::coverage_factor(0.95, freedom) * std);
    };
    for (name, i, j) in elements() {
        let (element, truth_of) = (&fit.elements[&name], ETA[i][j]);
        let freedom = element.degrees_of_freedom.unwrap_or(f64::INFINITY);
        inside("eta weighted", element.weighted - truth_of, element.weighted_std, freedom);
        let off = element.least_squares - truth_of;
        inside("eta least squares as the source has it", off, element.std_independent, f64::INFINITY);
        if truth.drift_nt_per_day == 0.0 {
            inside("eta least squares", off, element.std_noise, f64::INFINITY);
        }
    }
    for (axis, of) in fit.axes.iter() {
        let mut quantity = |name: &str, found: &Quantity, truth: f64| {
            inside(name, found.value() - truth, found.std().expect("a std"), f64::INFINITY);
        };
        quantity("white", &of.white_rms_nt, truth.white_rms_nt);
        let flicker = &of.flicker_nt2_per_hz_at_1hz;
        if truth.flicker > 0.0 {
            let log_std = flicker.std().expect("a std") / flicker.value();
            let log = Quantity::new((flicker.value() / truth.flicker).ln(), log_std);
            quantity("flicker at 1 Hz", &log, 0.0);
            quantity("exponent", &of.flicker_exponent, truth.exponent);
        } else {
            quantity("offset", offset_nt.get(axis).expect("an offset"), 0.0);
        }
        for octave in &fit.octaves.as_ref().and_then(|octaves| octaves.get(axis)).expect("octaves")[..] {
            if let Some((eta, std)) = octave.matrix.zip(octave.std) {
                let off = eta[0] - ETA[0][axis.index()];
                inside("eta by octave", off, std[0], octave.differences as f64 - 3.0);
            }
        }
    }
    for (_, of) in fit.axes.iter() {
        let drift = &of.drift.straight_nt_per_day;
        // The document has no degrees of freedom of a drift, but its probability by chance.
        let is_level = truth.drift_nt_per_day == 0.0;
        said.holds(
            "drift",
            if is_level { of.drift.straight_p >= 0.05 } else { holds(drift, truth.drift_nt_per_day) },
        );
        if truth.flicker == 0.0 {
            said.holds("no flicker", of.flicker_nt2_per_hz_at_1hz.value() == 0.0);
        }
        for ((averaging_s, low), high) in
            of.allan.averaging_s.iter().zip(&of.allan.low_nt).zip(&of.allan.high_nt)
        {
            said.holds("allan", (*low..=*high).contains(&true_deviation(&truth, *averaging_s)));
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
