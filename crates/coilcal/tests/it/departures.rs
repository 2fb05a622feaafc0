//! Each departure is found where it is, and not claimed where it is not (FLUXCAL_CAMPAIGNS clean runs).

use common::{Axis, CoilFit, Document, Recording, procedure};
use noise::Stream;

use crate::build::{calibrated, simulated};

/// 20 000 to 60 000 nT in both directions, five readings each; `field` gives |B| at a current and time.
fn run(seed: u64, field: impl Fn(f64, f64) -> f64, noise: fn(f64) -> f64) -> CoilFit {
    let mut stream = Stream::new(seed, "reference");
    let (mut current, mut time, mut reference) = (Vec::new(), Vec::new(), Vec::new());
    for sign in [1.0, -1.0] {
        for level in 0..9 {
            for _ in 0..5 {
                let (i, t) = (sign * (0.5 + 0.125 * f64::from(level)), 12.0 * current.len() as f64);
                current.push(i);
                time.push(t);
                reference.push(field(i, t) + noise(i) * stream.normal());
            }
        }
    }
    let mut recording =
        Recording { id: "coil".into(), procedure: procedure::COIL_CONSTANT.into(), ..Recording::default() };
    recording.conditions.coil = Some(Axis::X);
    let columns = [("time_s", time), ("coil_x_a", current), ("reference_nt", reference)];
    recording.columns = columns.map(|(name, column)| (name.to_string(), column.into())).into_iter().collect();
    let document = Document { fluxcal: 1, recordings: vec![recording], ..Document::default() };
    *calibrated(document).coil(Axis::X).expect("coil x").constant.clone().expect("a fit")
}

const K: f64 = 40_000.0;
const EVEN: fn(f64) -> f64 = |_| 0.3;

#[test]
fn each_departure_is_named_where_it_is() {
    type Field = fn(f64, f64) -> f64;
    let cases: [(&str, Field, f64); 7] = [
        ("quadratic", |i, _| (K * i + 1.0 + 2.0 * i * i).abs(), 2.0),
        ("cubic", |i, _| (K * i + 1.0 - 2.0 * i.powi(3)).abs(), -2.0),
        ("transverse_field", |i, _| (K * i + 1.0).hypot(600.0), 360_000.0),
        ("jump_between_ranges", |i, _| (K * i + if i < 0.0 { 2.0 } else { 0.0 }).abs(), 2.0),
        ("constant_between_ranges", |i, _| ((K + if i < 0.0 { 4.0 } else { 0.0 }) * i + 1.0).abs(), 4.0),
        ("constant_drift", |i, t| (K * i * (1.0 - 5e-8 * t) + 1.0).abs(), -5e-8 * K),
        ("offset_drift", |i, t| (K * i + 1.0 + 0.003 * t).abs(), 0.003),
    ];
    for (name, field, size) in cases {
        let (mut named, mut rival) = (0, 0);
        for seed in 0..20 {
            let fit = run(seed, field, EVEN);
            let found =
                fit.departures.iter().find(|departure| departure.departure == name).expect("looked for");
            if !fit.model.contains(name) {
                println!("{name}, seed {seed}: {} {:?}", fit.model, fit.departures);
            }
            rival += usize::from(fit.rivals.iter().any(|other| other == name));
            if fit.model.starts_with(&format!("line with {name}")) && found.found {
                named += 1;
                let quantity = &found.parameter[0];
                let sigmas = (quantity.value() - size) / quantity.std().expect("a std");
                assert!(sigmas.abs() < 5.0, "{name}: {sigmas} sigma from {size}");
            }
        }
        println!("{name}: named in {named} of 20, a rival in {rival}");
        assert!(named + rival == 20 && named >= 15, "{name}: named in {named} of 20, a rival in {rival}");
    }
}

#[test]
fn nothing_is_claimed_where_nothing_is() {
    let count = testkit::campaigns(200);
    let model = |seed: u64| run(1000 + seed, |i, _| (K * i + 1.0).abs(), EVEN).model;
    let claimed = (0..count).filter(|seed| model(*seed) != "line").count();
    println!("claimed in {claimed} of {count}");
    // The level is 1 % for all departures together.
    assert!(testkit::agrees(claimed, count as usize, [0.0, 0.01], 1), "{claimed} of {count}");
}

#[test]
fn levels_that_scatter_more_weigh_less() {
    // 3 nT at the two largest fields, 0.3 nT elsewhere.
    let noise: fn(f64) -> f64 = |i| if i.abs() > 1.4 { 3.0 } else { 0.3 };
    let (mut errors, mut ratio) = ([0.0, 0.0], 0.0);
    for seed in 0..40 {
        let [fit, even] = [noise, EVEN].map(|noise| run(seed, |i, _| (K * i + 1.0).abs(), noise));
        assert!(fit.noise_source.ends_with("weighted by level"), "{}", fit.noise_source);
        assert!(!even.noise_source.contains("weighted"));
        let std = |current: f64| {
            let level = fit.residuals.drive_a.iter().position(|drive| *drive == current).expect("a level");
            fit.residuals.std_nt[level]
        };
        ratio += std(1.5) / std(1.0) / 40.0;
        for (sum, fit) in errors.iter_mut().zip([&fit, &even]) {
            *sum += fit.uncertainty["constant_nt_per_a"].type_a / 40.0;
        }
    }
    println!("u(k): {:.3} nT/A with four noisy levels, {:.3} without", errors[0], errors[1]);
    // Ten times the noise; four degrees of freedom of the common scatter draw them together.
    assert!(ratio > 1.8, "{ratio}");
    assert!(errors[0] < 2.5 * errors[1], "{errors:?}");
}

#[test]
fn a_coil_that_heats_is_seen_to_fall() {
    let mut falls = 0;
    for seed in 0..10 {
        let plan = serde_json::json!({
            "fluxcal": 1,
            "seed": seed,
            "facility": {"reference_std_nt": 0.2, "reference_range_nt": [15000, 65000]},
            "calibration": {"coils": {"z": {"constant_nt_per_a": 43000}}},
            "truth": {"model": {"effects": [{"effect": "coil_heating", "coil": "z", "parameters": {"fall_ppm_per_a2": 200, "lag_s": 1500}}]}},
            "procedures": [{"procedure": "coil_constant", "id": "coil", "coil": "z"}]
        });
        let found = calibrated(simulated(&plan));
        let fit = found.coil(Axis::Z).and_then(|coil| coil.constant.clone()).expect("a fit");
        let drift = fit.departures.iter().find(|d| d.departure == "constant_drift").expect("looked for");
        println!(
            "heating: {}, constant_drift {:.2e}, p {:.1e}",
            fit.model,
            drift.parameter[0].value(),
            drift.p_adjusted
        );
        falls +=
            u32::from(fit.model != "line" && drift.parameter[0].value() < 0.0 && drift.p_adjusted < 0.01);
    }
    assert_eq!(falls, 10);
}
