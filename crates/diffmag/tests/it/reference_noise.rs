//! Coverage of η where the reference is noisy: with its noise declared, with a third instrument, from the
//! spectra alone; of the noise of each instrument; and the bound on the pull. FLUXCAL_CAMPAIGNS sets how many
//! pairs.

use common::{
    Axis, Calibration, DifferentialFit, Document, Noise, OwnNoise, PerAxis, Recording, ReferenceNoise,
    ReferenceNoiseSource, procedure,
};
use indexmap::IndexMap;
use noise::{Stream, power_law};
use rayon::prelude::*;
use serde_json::{Value, json};

const ROWS: usize = 4320;
const STEP_S: f64 = 60.0;
/// Columns of η and ζ: a test instrument turned by some degrees, a third turned by 30° about the vertical.
const ETA: [[f64; 3]; 3] = [[0.997, 0.062, -0.021], [-0.058, 1.004, 0.035], [0.018, -0.034, 0.996]];
const ZETA: [[f64; 3]; 3] = [[0.866, -0.5, 0.01], [0.5, 0.866, -0.02], [-0.01, 0.02, 1.003]];

fn campaigns() -> u64 {
    testkit::campaigns(2)
}

fn noise_of(json: &Value) -> Noise {
    serde_json::from_value(json.clone()).expect("a noise")
}

fn times() -> Vec<f64> {
    (0..ROWS).map(|row| row as f64 * STEP_S).collect()
}

/// Noises of an instrument's three axes.
fn errors(name: &str, noise: &Noise, seed: u64) -> [Vec<f64>; 3] {
    Axis::ALL.map(|axis| {
        noise::series(noise, seed, &format!("{name}_{axis}"), ROWS, Some(&times())).expect("noise")
    })
}

/// Three days of natural field: daily variation and a background of f^-1.6.
fn field(seed: u64) -> [Vec<f64>; 3] {
    let daily = [[22.0, 0.3], [28.0, 1.9], [12.0, 2.6]];
    Axis::ALL.map(|axis| {
        let [amplitude, phase] = daily[axis.index()];
        let main = [20_800.0, 700.0, 47_500.0][axis.index()];
        let background = power_law(&mut Stream::new(seed, &format!("field_{axis}")), ROWS, STEP_S, 2e-4, 1.6);
        let day = |row: usize| (std::f64::consts::TAU * row as f64 * STEP_S / 86_400.0 + phase).sin();
        (0..ROWS).map(|row| main + amplitude * day(row) + background[row]).collect()
    })
}

/// Columns `name_x_nt`, …: field × matrix + errors.
fn readings(
    recording: &mut Recording,
    name: &str,
    field: &[Vec<f64>; 3],
    matrix: &[[f64; 3]; 3],
    errors: &[Vec<f64>; 3],
) {
    for axis in Axis::ALL {
        let j = axis.index();
        let column: Vec<f64> = (0..ROWS)
            .map(|row| (0..3).map(|i| field[i][row] * matrix[i][j]).sum::<f64>() + errors[j][row])
            .collect();
        recording.columns.insert(format!("{name}_{axis}_nt"), column.into());
    }
}

const UNIT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Noises of the reference, the test instrument and, where there is one, the third.
struct Scene {
    reference: Noise,
    test: Noise,
    third: Option<Noise>,
}

impl Scene {
    fn new(reference: Value, test: Value, third: Option<Value>) -> Self {
        Self { reference: noise_of(&reference), test: noise_of(&test), third: third.as_ref().map(noise_of) }
    }

    /// The calibration that diffmag makes of one campaign, the noise of the reference declared or not.
    fn calibrated(&self, seed: u64, declared: Option<Noise>) -> common::DifferentialCalibration {
        let field = field(seed);
        let mut recording = Recording {
            id: "pair".into(),
            procedure: procedure::DIFFERENTIAL.into(),
            ..Recording::default()
        };
        recording.columns.insert("time_s".into(), times().into());
        readings(&mut recording, "reference", &field, &UNIT, &errors("reference", &self.reference, seed));
        readings(&mut recording, "test", &field, &ETA, &errors("test", &self.test, seed));
        if let Some(third) = &self.third {
            readings(&mut recording, "third", &field, &ZETA, &errors("third", third, seed));
        }
        recording.conditions.reference_noise = declared.map(common::NoiseOfSensors::Same);
        let document = Document { recordings: vec![recording], ..Document::default() };
        let done = diffmag::run(document, &diffmag::Options::default()).expect("fitted");
        let Some(Calibration { differential: Some(found), .. }) = done.calibration else { panic!("no fit") };
        found
    }
}

/// Whether the truth is in the interval of each element of the corrected matrix, and of the pulled one.
fn elements(report: &ReferenceNoise) -> IndexMap<String, bool> {
    let mut all = IndexMap::new();
    for (i, from) in Axis::ALL.into_iter().enumerate() {
        for (j, to) in Axis::ALL.into_iter().enumerate() {
            let (name, truth) = (format!("{from}{to}"), ETA[i][j]);
            let element = &report.elements[&name];
            all.insert(format!("{name} pulled"), (element.pulled - truth).abs() <= 1.96 * element.pulled_std);
            if let Some(corrected) = &element.corrected {
                let std = corrected.std().expect("a std");
                all.insert(format!("{name} corrected"), (corrected.value() - truth).abs() <= 1.96 * std);
            }
        }
    }
    all
}

/// Whether the truth is in the interval of each element by least squares.
fn least_squares(fit: &DifferentialFit) -> IndexMap<String, bool> {
    let mut all = IndexMap::new();
    for (i, from) in Axis::ALL.into_iter().enumerate() {
        for (j, to) in Axis::ALL.into_iter().enumerate() {
            let element = &fit.elements[&format!("{from}{to}")];
            let inside = (element.least_squares - ETA[i][j]).abs() <= 1.96 * element.std_noise;
            all.insert(format!("{from}{to} least squares"), inside);
        }
    }
    all
}

/// Whether the noise of an instrument is in the intervals that are stated.
fn own(name: &str, truth: &Noise, found: &PerAxis<OwnNoise>) -> IndexMap<String, bool> {
    let mut all = IndexMap::new();
    let inside = |interval: [f64; 2], truth: f64| (interval[0]..=interval[1]).contains(&truth);
    for (axis, own) in found.iter() {
        let white = truth.white_rms_nt.unwrap_or(0.0);
        all.insert(format!("{name} {axis} white"), inside(own.white_interval_nt, white));
        let density = truth.flicker_nt2_per_hz_at_1hz.unwrap_or(0.0).sqrt();
        let found = inside(own.density_interval_nt_per_sqrt_hz, density);
        all.insert(format!("{name} {axis} density at 1 Hz"), found);
    }
    all
}

/// Prints the shares, and gives those that do not agree with `band`, all that are judged taken together.
fn shares(
    name: &str,
    all: &[IndexMap<String, bool>],
    band: [f64; 2],
    judged: impl Fn(&str) -> bool,
) -> (Vec<String>, IndexMap<String, f64>) {
    let mut counts: IndexMap<String, [usize; 2]> = IndexMap::new();
    for (key, inside) in all.iter().flatten() {
        let [held, tried] = counts.entry(key.clone()).or_default();
        *held += usize::from(*inside);
        *tried += 1;
    }
    let cells = counts.keys().filter(|key| judged(key)).count();
    let (mut outside, mut shares) = (Vec::new(), IndexMap::new());
    for (key, [inside, tried]) in counts {
        let share = inside as f64 / tried as f64;
        println!("{name}: {key}: {:.1} % of {tried}", 100.0 * share);
        if judged(&key) && !testkit::agrees(inside, tried, band, cells) {
            outside.push(format!("{key}: {share:.3} of {tried}"));
        }
        shares.insert(key, share);
    }
    (outside, shares)
}

/// What 95 % intervals hold.
const HOLD: [f64; 2] = [0.93, 0.97];
/// What a bound of something that is not there holds: it cannot be below its interval.
const AT_LEAST: [f64; 2] = [0.93, 1.0];

fn noisy() -> Scene {
    Scene::new(json!({"white_rms_nt": 0.1}), json!({"white_rms_nt": 0.06}), None)
}

fn noisy_with_memory() -> Scene {
    Scene::new(
        json!({"white_rms_nt": 0.08, "flicker_nt2_per_hz_at_1hz": 1e-3}),
        json!({"white_rms_nt": 0.05, "flicker_nt2_per_hz_at_1hz": 4e-4}),
        None,
    )
}

fn average(shares: &IndexMap<String, f64>, ending: &str) -> f64 {
    let of: Vec<f64> =
        shares.iter().filter(|(key, _)| key.ends_with(ending)).map(|(_, share)| *share).collect();
    of.iter().sum::<f64>() / of.len() as f64
}

#[test]
fn declared_noise_puts_back_what_it_pulled() {
    for (name, scene) in [("declared, white", noisy()), ("declared, flicker", noisy_with_memory())] {
        let all: Vec<IndexMap<String, bool>> = (0..campaigns())
            .into_par_iter()
            .map(|seed| {
                // Declared with an error of 5 % in the noise.
                let factor = 1.0 + 0.05 * Stream::new(seed, "declaration").normal();
                let declared = Noise {
                    white_rms_nt: scene.reference.white_rms_nt.map(|white| white * factor),
                    flicker_nt2_per_hz_at_1hz: scene
                        .reference
                        .flicker_nt2_per_hz_at_1hz
                        .map(|a| a * factor * factor),
                    relative_std: Some(0.05),
                    ..Noise::default()
                };
                let fit = scene.calibrated(seed, Some(declared)).fit.expect("a fit");
                let report = fit.reference_noise.as_ref().expect("a report");
                assert_eq!(report.known_from, ReferenceNoiseSource::Declared);
                let mut all = elements(report);
                all.extend(least_squares(&fit));
                all.extend(own("test", &scene.test, report.test.as_ref().expect("its noise")));
                all
            })
            .collect();
        let (outside, shares) =
            shares(name, &all, HOLD, |key| key.ends_with("corrected") || key.ends_with("white"));
        // What is not put right: white noise pulls least squares, flicker noise the weighted fit too, which
        // leaves out short periods.
        let [pulled, plain] = ["pulled", "least squares"].map(|of| average(&shares, of));
        println!(
            "{name}: in their intervals are of weighted elements {pulled:.2}, of least squares {plain:.2}"
        );
        assert!(pulled.min(plain) < 0.8, "{name}: nothing was to be put back: {pulled}, {plain}");
        assert!(outside.is_empty(), "{name}: {}", outside.join(", "));
    }
}

#[test]
fn spectra_show_the_noise_of_the_reference() {
    for (name, scene) in [("spectrum, white", noisy()), ("spectrum, flicker", noisy_with_memory())] {
        let all: Vec<IndexMap<String, bool>> = (0..campaigns())
            .into_par_iter()
            .map(|seed| {
                let found = scene.calibrated(seed, None);
                let report = found.fit.expect("a fit").reference_noise.expect("a report");
                let spectrum = report.in_spectrum.as_ref().expect("bands");
                let mut all = elements(&report);
                all.insert("used".into(), spectrum.used);
                all.insert("consistent at 5 %".into(), spectrum.consistency_p > 0.05);
                if let Some(test) = &report.test {
                    all.extend(own("test", &scene.test, test));
                }
                all
            })
            .collect();
        let (outside, _) =
            shares(name, &all, HOLD, |key| key.ends_with("corrected") || key.starts_with("consistent"));
        let used = all.iter().filter(|of| of["used"]).count();
        assert!(testkit::agrees(used, all.len(), [0.9, 1.0], 1), "{name}: used in {used}");
        assert!(outside.is_empty(), "{name}: {}", outside.join(", "));
    }
}

#[test]
fn three_instruments_tell_the_noise_of_each() {
    let white = |rms: f64| json!({"white_rms_nt": rms});
    let flicker = |rms: f64, a: f64, alpha: f64| json!({"white_rms_nt": rms, "flicker_nt2_per_hz_at_1hz": a, "flicker_exponent": alpha});
    let scenes = [
        ("three, white", Scene::new(white(0.1), white(0.06), Some(white(0.15)))),
        (
            "three, flicker",
            Scene::new(flicker(0.08, 1e-3, 1.0), flicker(0.05, 4e-4, 1.0), Some(flicker(0.1, 2e-3, 1.2))),
        ),
        ("three, a good test instrument", Scene::new(white(0.1), white(0.01), Some(white(0.15)))),
    ];
    for (name, scene) in scenes {
        let all: Vec<IndexMap<String, bool>> = (0..campaigns())
            .into_par_iter()
            .map(|seed| {
                let found = scene.calibrated(seed, None);
                let fit = found.fit.expect("a fit");
                let report = fit.reference_noise.expect("a report");
                assert_eq!(report.known_from, ReferenceNoiseSource::ThirdInstrument);
                let split = fit.three_cornered.expect("three instruments");
                let mut all = elements(&report);
                all.extend(own("reference", &scene.reference, &split.reference));
                all.extend(own("test", &scene.test, &split.test));
                all.extend(own("third", scene.third.as_ref().expect("a third"), &split.third));
                all.insert("goodness at 5 %".into(), split.goodness_p > 0.05);
                all
            })
            .collect();
        let has_flicker = name.ends_with("flicker");
        let judged = |key: &str| {
            let of_good = name.ends_with("test instrument") && key.starts_with("test");
            !key.ends_with("pulled") && !of_good && (has_flicker || !key.ends_with("Hz"))
        };
        let (mut outside, _) = shares(name, &all, HOLD, judged);
        outside.extend(shares(name, &all, AT_LEAST, |key| !judged(key) && !key.ends_with("pulled")).0);
        assert!(outside.is_empty(), "{name}: {}", outside.join(", "));
    }
}

fn rows(value: &Value) -> Vec<Vec<f64>> {
    serde_json::from_value(value.clone()).expect("rows of numbers")
}

/// White noise, the reference's known: what SciPy's orthogonal distance regression finds.
#[test]
fn orthogonal_distance_regression_of_scipy() {
    let text = testkit::read_fixture("reference/diffmag_reference_noise.json");
    let expected: Value = serde_json::from_str(&text).expect("the fixture is JSON");
    let (reference, test) = (rows(&expected["reference"]), rows(&expected["test"]));
    let step_s = expected["step_s"].as_f64().expect("a step");
    let time: Vec<f64> = (0..test[0].len()).map(|row| row as f64 * step_s).collect();
    let mut recording =
        Recording { id: "pair".into(), procedure: procedure::DIFFERENTIAL.into(), ..Recording::default() };
    recording.columns.insert("time_s".into(), time.into());
    let noise: Vec<f64> = serde_json::from_value(expected["reference_white_rms_nt"].clone()).expect("three");
    let mut declared = PerAxis::default();
    for axis in Axis::ALL {
        let i = axis.index();
        recording.columns.insert(format!("reference_{axis}_nt"), reference[i].clone().into());
        recording.columns.insert(format!("test_{axis}_nt"), test[i].clone().into());
        *declared.entry(axis) = Some(Noise { white_rms_nt: Some(noise[i]), ..Noise::default() });
    }
    recording.conditions.reference_noise = Some(common::NoiseOfSensors::Each(Box::new(declared)));
    let document = Document { recordings: vec![recording], ..Document::default() };
    let done = diffmag::run(document, &diffmag::Options::default()).expect("fitted");
    let found = done.calibration.and_then(|c| c.differential).expect("a fit");
    let (matrix, covariance) = (found.matrix.expect("a matrix"), found.covariance.expect("a covariance"));
    let [eta, std] = ["matrix", "std"].map(|key| rows(&expected[key]));
    let mut worst = [0.0_f64; 2];
    for i in 0..3 {
        for j in 0..3 {
            let stated = covariance[3 * j + i][3 * j + i].sqrt();
            worst[0] = worst[0].max((matrix[i][j] - eta[i][j]).abs());
            worst[1] = worst[1].max((stated / std[i][j] - 1.0).abs());
        }
    }
    println!("differences: matrix {:.1e}, uncertainties {:.1e} of them", worst[0], worst[1]);
    // White noise throughout: the weights are all alike. SciPy's steps end at about 1e-9.
    assert!(worst[0] < 1e-7, "{worst:?}");
    // The variance of the difference is known to 1/√n, 3.5 %, and half of that in its root.
    assert!(worst[1] < 0.05, "{worst:?}");
}

/// The truth, P_e known, is never pulled farther than the bound, wherever the noise is.
#[test]
fn no_noise_pulls_farther_than_the_bound() {
    let shares = [0.0, 0.2, 0.5, 0.9, 1.0];
    let held: Vec<(f64, f64)> = (0..campaigns())
        .into_par_iter()
        .map(|seed| {
            let share = shares[seed as usize % shares.len()];
            let part = |share: f64| {
                json!({"white_rms_nt": 0.1 * f64::sqrt(share), "flicker_nt2_per_hz_at_1hz": 5e-4 * share})
            };
            let scene = Scene::new(part(share), part(1.0 - share), None);
            let found = scene.calibrated(seed, None);
            let report = found.fit.expect("a fit").reference_noise.expect("a report");
            let mut beyond = 0.0_f64;
            let mut bounds = 0.0_f64;
            for (i, from) in Axis::ALL.into_iter().enumerate() {
                for (j, to) in Axis::ALL.into_iter().enumerate() {
                    let element = &report.elements[&format!("{from}{to}")];
                    let off = (element.pulled - ETA[i][j]).abs() - element.largest_pull;
                    beyond = beyond.max(off / element.pulled_std);
                    bounds = bounds.max(element.largest_pull_over_std);
                }
            }
            (beyond, bounds)
        })
        .collect();
    let worst = held.iter().map(|(beyond, _)| *beyond).fold(0.0, f64::max);
    let bounds = held.iter().map(|(_, bound)| *bound).sum::<f64>() / held.len() as f64;
    println!("bound: at most {worst:.2} uncertainties beyond it, the bound itself {bounds:.1} of them");
    // What is left beyond the bound is chance: the largest of nine for each pair.
    let chance = estimate::stats::coverage_factor(1.0 - 1e-3 / (9.0 * held.len() as f64), f64::INFINITY);
    assert!(worst < chance, "{worst}, {chance}");
}
