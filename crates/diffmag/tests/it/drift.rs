//! The drift of simulated pairs of three days: what is claimed where there is none, coverage, power, and the
//! change over the next day. The noise is cut out of a series sixteen times as long, so that it is not
//! periodic over the recording. FLUXCAL_CAMPAIGNS sets how many, each with three axes.

use std::ops::Range;

use common::{Axis, Document, Drift, DriftForm, MatrixElement, Quantity};
use indexmap::IndexMap;
use rayon::prelude::*;
use serde_json::json;

use crate::outside::outside;

/// The noise is cut out of a series so many times as long.
const LONGER: usize = 16;
const STEP_S: f64 = 60.0;
const DAYS: usize = 3;
/// Rows of a day.
const DAY: usize = 1440;
const DAY_S: f64 = 86_400.0;

fn campaigns() -> u64 {
    testkit::campaigns(3)
}

#[derive(Clone, Copy)]
struct Noise {
    white_nt: f64,
    amplitude: f64,
    exponent: f64,
}

const WHITE: Noise = Noise { white_nt: 0.1, amplitude: 0.0, exponent: 1.0 };
const FLICKER: Noise = Noise { white_nt: 0.02, amplitude: 1e-3, exponent: 1.0 };
const STEEP: Noise = Noise { white_nt: 0.02, amplitude: 1e-4, exponent: 1.4 };

impl Noise {
    /// Of `rows` readings.
    fn draw(&self, rows: usize, name: &str, seed: u64) -> Vec<f64> {
        let mut stream = noise::Stream::new(seed, name);
        let white: Vec<f64> = (0..rows).map(|_| self.white_nt * stream.normal()).collect();
        let all = noise::power_law(&mut stream, LONGER * rows, STEP_S, self.amplitude, self.exponent);
        white.iter().zip(&all[LONGER / 2 * rows..]).map(|(white, flicker)| white + flicker).collect()
    }
}

#[derive(Clone, Copy, Default)]
struct True {
    nt_per_day: f64,
    amplitude_nt: f64,
    time_constant_s: f64,
}

impl True {
    /// At a time from the first row, nT.
    fn at(&self, time_s: f64) -> f64 {
        let exponential = if self.amplitude_nt == 0.0 { 0.0 } else { (-time_s / self.time_constant_s).exp() };
        self.nt_per_day * time_s / DAY_S + self.amplitude_nt * exponential
    }

    /// Over some rows, nT.
    fn mean(&self, rows: Range<usize>) -> f64 {
        let count = rows.len() as f64;
        rows.map(|row| self.at(row as f64 * STEP_S)).sum::<f64>() / count
    }

    /// Between two times, nT.
    fn change(&self, from_s: f64, to_s: f64) -> f64 {
        self.at(to_s) - self.at(from_s)
    }
}

/// A pair with that drift on each axis, the matrix, and by how much the noise of each axis changes over the
/// day after.
struct Pair {
    document: Document,
    matrix: [[f64; 3]; 3],
    noise_change: [f64; 3],
}

fn pair(noise: &Noise, drift: &True, seed: u64) -> Pair {
    let plan = json!({
        "fluxcal": 1,
        "seed": seed,
        "start": "2026-03-01T00:00:00Z",
        "instrument": {"noise": {"white_rms_nt": 0.0}},
        "truth": {
            "outside": outside(),
            "differential": {
                "reference": {"alpha_deg": 25.0, "beta_deg": 0.31, "gamma_deg": 0.22, "scale": [1.0012, 0.9985, 1.0007]},
                "test": {"phi_deg": [91.1, 0.9, 40.0], "theta_deg": [89.6, 90.4, 0.35], "scale": [1.0, 1.0, 1.0]},
                "offset_nt": [12.0, -7.5, 21.0]
            }
        },
        "procedures": [{"procedure": "differential", "id": "pair", "length_s": DAYS * DAY * 60, "step_s": STEP_S}]
    });
    let plan = simulate::Plan::parse(&plan.to_string()).expect("a plan");
    let simulate::Campaign { mut document, truth, .. } = simulate::campaign(&plan).expect("simulated");
    let mut noise_change = [0.0; 3];
    for axis in Axis::ALL {
        let name = format!("test_{axis}_nt");
        let column = &mut document.recordings[0].columns.get_mut(&name).expect("a column");
        let rows = column.len();
        let noise = noise.draw(rows + DAY, &name, seed);
        for (row, (reading, noise)) in column.iter_mut().zip(&noise).enumerate() {
            *reading += noise + drift.at(row as f64 * STEP_S);
        }
        noise_change[axis.index()] = noise[rows - 1 + DAY] - noise[rows - 1];
    }
    let two = truth.differential.as_ref().expect("two instruments");
    let matrix = two.calibration().expect("a matrix").matrix.expect("a matrix");
    Pair { document, matrix, noise_change }
}

struct FoundDrift {
    drifts: Vec<Drift>,
    elements: IndexMap<String, MatrixElement>,
}

fn run(document: Document) -> FoundDrift {
    let found = diffmag::run(document, &diffmag::Options::default()).expect("fitted");
    let fit = found.calibration.expect("a calibration").differential.expect("a fit").fit.expect("a fit");
    FoundDrift { drifts: fit.axes.iter().map(|(_, of)| of.drift.clone()).collect(), elements: fit.elements }
}

fn holds(quantity: &Quantity, truth: f64) -> bool {
    (quantity.value() - truth).abs() <= 1.96 * quantity.std().expect("a std")
}

/// Shares of what holds, and means of numbers, over campaigns and axes.
fn over(name: &str, noise: &Noise, drift: &True) -> IndexMap<String, f64> {
    let count = campaigns();
    let all: Vec<Vec<(String, f64)>> = (0..count)
        .into_par_iter()
        .map(|seed| {
            let Pair { document, matrix, noise_change } = pair(noise, drift, seed);
            let found = run(document);
            let mut all = Vec::new();
            let mut add = |name: &str, number: f64| all.push((name.to_owned(), number));
            let share = |holds: bool| f64::from(u8::from(holds));
            for (axis, of) in Axis::ALL.into_iter().zip(&found.drifts) {
                let j = axis.index();
                let joint = of.joint.as_ref().expect("a joint fit");
                add("claimed", share(of.demanded != DriftForm::None));
                add("claimed exponential", share(of.exponential_p < of.level));
                add("claimed straight", share(of.straight_p < of.level));
                add("b", share(holds(&of.straight_nt_per_day, drift.nt_per_day)));
                add("joint b", share(holds(&joint.straight_nt_per_day, drift.nt_per_day)));
                add("joint a", share(holds(&joint.amplitude_nt, drift.amplitude_nt)));
                let [low, high] = joint.time_constant_interval_s;
                add("joint ln τ", share((low..=high).contains(&drift.time_constant_s)));
                add("joint τ ± 1.96 std", share(holds(&joint.time_constant_s, drift.time_constant_s)));
                for (i, from) in Axis::ALL.into_iter().enumerate() {
                    let element = &found.elements[&format!("{from}{axis}")];
                    let off = (element.weighted - matrix[i][j]).abs();
                    add("η", share(off <= 1.96 * element.weighted_std));
                    add("joint η", share(holds(&joint.eta[i], matrix[i][j])));
                    let least = (element.least_squares - matrix[i][j]).abs();
                    add("η by least squares", share(least <= 1.96 * element.std_noise));
                    let joint_std = joint.eta[i].std().expect("a std");
                    add("std of η, joint over quoted", joint_std / element.weighted_std);
                }
                let (windows, rows) = (&of.windows, DAYS * DAY / of.windows.len());
                for (number, window) in windows.iter().enumerate() {
                    let truth = drift.mean(number * rows..(number + 1) * rows) - drift.mean(0..DAYS * DAY);
                    add("window means", share(holds(&window.mean_nt, truth)));
                }
                let end = (DAYS * DAY - 1) as f64 * STEP_S;
                let change = noise_change[j] + drift.change(end, end + DAY_S);
                let [low, high] = of.per_day.as_ref().expect("a change").interval_nt;
                add("change over the next day", share((low..=high).contains(&change)));
                add("std of a", joint.amplitude_nt.std().expect("a std"));
                add("std of ln τ", joint.covariance[5][5].sqrt());
                // Where an exponential is significant the source's iteration stands beside the joint fit.
                assert_eq!(of.iteration.is_some(), of.exponential_p < of.level);
                if let Some(iteration) = &of.iteration {
                    add("rounds", iteration.rounds as f64);
                    add("settled", share(iteration.settled));
                    let far = iteration.from_joint_std.iter().map(|off| off * off).sum::<f64>() / 6.0;
                    add("iteration from joint, mean square in std", far);
                }
            }
            all
        })
        .collect();
    let mut sums: IndexMap<String, (f64, f64)> = IndexMap::new();
    for (key, number) in all.into_iter().flatten() {
        let sum = sums.entry(key).or_default();
        *sum = (sum.0 + number, sum.1 + 1.0);
    }
    let means: IndexMap<String, f64> = sums.into_iter().map(|(key, (sum, n))| (key, sum / n)).collect();
    for (key, mean) in &means {
        println!("{name}: {key}: {mean:.4}");
    }
    means
}

/// Three standard deviations of a share of so many fits.
fn slack(share: f64) -> f64 {
    3.0 * (share * (1.0 - share) / (3 * campaigns()) as f64).sqrt()
}

fn covers(means: &IndexMap<String, f64>, keys: &[&str]) {
    for key in keys {
        let share = means[*key];
        assert!((0.93 - slack(0.95)..=0.97 + slack(0.95)).contains(&share), "{key}: {share}");
    }
}

fn none_is_claimed(name: &str, noise: &Noise) {
    let means = over(name, noise, &True::default());
    for key in ["claimed straight", "claimed exponential"] {
        assert!(means[key] <= 0.01 + slack(0.01), "{key}: {}", means[key]);
    }
    covers(&means, &["b", "η", "η by least squares", "change over the next day", "window means"]);
}

#[test]
fn none_under_white_noise() {
    none_is_claimed("white", &WHITE);
}

#[test]
fn none_under_flicker_noise() {
    none_is_claimed("flicker", &FLICKER);
}

#[test]
fn none_under_steep_noise() {
    none_is_claimed("steep", &STEEP);
}

#[test]
fn both_parts_under_flicker_noise() {
    let drift = True { nt_per_day: 0.2, amplitude_nt: 3.0, time_constant_s: 20_000.0 };
    let means = over("both", &FLICKER, &drift);
    assert_eq!(means["settled"], 1.0);
    assert!(means["claimed exponential"] > 0.99);
    let all =
        ["joint b", "joint a", "joint ln τ", "joint η", "b", "η", "change over the next day", "window means"];
    covers(&means, &all);
}

#[test]
fn exponentials_of_three_and_six_standard_deviations() {
    let sized = |amplitude_nt: f64| True { nt_per_day: 0.0, amplitude_nt, time_constant_s: 20_000.0 };
    let std = {
        let found = run(pair(&FLICKER, &sized(3.0), 1).document);
        found.drifts[0].joint.as_ref().expect("a joint fit").amplitude_nt.std().expect("a std")
    };
    for (times, least) in [(3.0, 0.2), (6.0, 0.95)] {
        let means = over(&format!("{times} std of a"), &FLICKER, &sized(times * std));
        assert!(means["claimed exponential"] > least);
    }
}
