//! Coverage of η where the reference is noisy: with its noise declared, with a third instrument, from the
//! spectra alone; of the noise of each instrument; and the bound on the pull. FLUXCAL_CAMPAIGNS sets how many
//! pairs.

use common::{
    Axis, DifferentialFit, Noise, OwnNoise, PerAxis, Recording, ReferenceNoise, ReferenceNoiseSource,
};
use noise::{Stream, power_law};
use rayon::prelude::*;
use serde_json::{Value, json};
use testkit::reference::{list, number, numbers, reference};

use crate::answers::{Said, Sums, elements, fit, found, holds, outside, over};
use crate::pair_in_time::{both, document, recording};

const ROWS: usize = 4320;
const STEP_S: f64 = 60.0;
/// Columns of η and ζ: a test instrument turned by some degrees, a third turned by 30° about the vertical.
const ETA: [[f64; 3]; 3] = [[0.997, 0.062, -0.021], [-0.058, 1.004, 0.035], [0.018, -0.034, 0.996]];
const ZETA: [[f64; 3]; 3] = [[0.866, -0.5, 0.01], [0.5, 0.866, -0.02], [-0.01, 0.02, 1.003]];

fn campaigns() -> u64 {
    testkit::campaigns(1)
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

    /// The fit of one campaign, the noise of the reference declared or not.
    fn fit(&self, seed: u64, declared: Option<Noise>) -> DifferentialFit {
        let field = field(seed);
        let mut recording = recording("pair", &times(), Vec::new());
        readings(&mut recording, "reference", &field, &UNIT, &errors("reference", &self.reference, seed));
        readings(&mut recording, "test", &field, &ETA, &errors("test", &self.test, seed));
        if let Some(third) = &self.third {
            readings(&mut recording, "third", &field, &ZETA, &errors("third", third, seed));
        }
        recording.conditions.reference_noise = declared.map(common::NoiseOfSensors::Same);
        fit(&document(vec![recording]))
    }
}

/// Whether the truth is in the interval of each element of the corrected matrix, and of the pulled one.
fn of_elements(report: &ReferenceNoise, said: &mut Said) {
    for (name, i, j) in elements() {
        let element = &report.elements[&name];
        let off = (element.pulled - ETA[i][j]).abs();
        said.holds(format!("{name} pulled"), off <= 1.96 * element.pulled_std);
        if let Some(corrected) = &element.corrected {
            said.holds(format!("{name} corrected"), holds(corrected, ETA[i][j]));
        }
    }
}

/// Whether the noise of an instrument is in the intervals that are stated.
fn own(name: &str, truth: &Noise, found: &PerAxis<OwnNoise>, said: &mut Said) {
    let inside = |interval: [f64; 2], truth: f64| (interval[0]..=interval[1]).contains(&truth);
    for (axis, own) in found.iter() {
        let white = truth.white_rms_nt.unwrap_or(0.0);
        said.holds(format!("{name} {axis} white"), inside(own.white_interval_nt, white));
        let density = truth.flicker_nt2_per_hz_at_1hz.unwrap_or(0.0).sqrt();
        let inside = inside(own.density_interval_nt_per_sqrt_hz, density);
        said.holds(format!("{name} {axis} density at 1 Hz"), inside);
    }
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

fn average(shares: &Sums, ending: &str) -> f64 {
    let of = shares.iter().filter(|(key, _)| key.ends_with(ending));
    let (held, tried) = of.fold((0.0, 0), |all, (_, of)| (all.0 + of.0, all.1 + of.1));
    held / tried as f64
}

#[test]
fn declared_noise_puts_back_what_it_pulled() {
    for (name, scene) in [("declared, white", noisy()), ("declared, flicker", noisy_with_memory())] {
        let shares = over(name, campaigns(), |seed| {
            // Declared with an error of 5 % in the noise.
            let factor = 1.0 + 0.05 * Stream::new(seed, "declaration").normal();
            let Noise { white_rms_nt, flicker_nt2_per_hz_at_1hz: flicker, .. } = scene.reference;
            let declared = Noise {
                white_rms_nt: white_rms_nt.map(|white| white * factor),
                flicker_nt2_per_hz_at_1hz: flicker.map(|a| a * factor * factor),
                relative_std: Some(0.05),
                ..Noise::default()
            };
            let fit = scene.fit(seed, Some(declared));
            let report = fit.reference_noise.as_ref().expect("a report");
            assert_eq!(report.known_from, ReferenceNoiseSource::Declared);
            let mut said = Said::default();
            of_elements(report, &mut said);
            for (name, i, j) in elements() {
                let element = &fit.elements[&name];
                let off = (element.least_squares - ETA[i][j]).abs();
                said.holds(format!("{name} least squares"), off <= 1.96 * element.std_noise);
            }
            own("test", &scene.test, report.test.as_ref().expect("its noise"), &mut said);
            said
        });
        // What is not put right: white noise pulls least squares, flicker noise the weighted fit too, which
        // leaves out short periods.
        let [pulled, plain] = ["pulled", "least squares"].map(|of| average(&shares, of));
        assert!(pulled.min(plain) < 0.8, "{name}: nothing was to be put back: {pulled}, {plain}");
        let outside = outside(&shares, HOLD, |key| key.ends_with("corrected") || key.ends_with("white"));
        assert!(outside.is_empty(), "{name}: {}", outside.join(", "));
    }
}

#[test]
fn spectra_show_the_noise_of_the_reference() {
    for (name, scene) in [("spectrum, white", noisy()), ("spectrum, flicker", noisy_with_memory())] {
        let shares = over(name, campaigns(), |seed| {
            let report = scene.fit(seed, None).reference_noise.expect("a report");
            let spectrum = report.in_spectrum.as_ref().expect("bands");
            let mut said = Said::default();
            of_elements(&report, &mut said);
            said.holds("used", spectrum.used);
            said.holds("consistent at 5 %", spectrum.consistency_p > 0.05);
            if let Some(test) = &report.test {
                own("test", &scene.test, test, &mut said);
            }
            said
        });
        let mut outside_band =
            outside(&shares, HOLD, |key| key.ends_with("corrected") || key.starts_with("consistent"));
        outside_band.extend(outside(&shares, [0.9, 1.0], |key| key == "used"));
        assert!(outside_band.is_empty(), "{name}: {}", outside_band.join(", "));
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
        let shares = over(name, campaigns(), |seed| {
            let fit = scene.fit(seed, None);
            let report = fit.reference_noise.expect("a report");
            assert_eq!(report.known_from, ReferenceNoiseSource::ThirdInstrument);
            let split = fit.three_cornered.expect("three instruments");
            let mut said = Said::default();
            of_elements(&report, &mut said);
            own("reference", &scene.reference, &split.reference, &mut said);
            own("test", &scene.test, &split.test, &mut said);
            own("third", scene.third.as_ref().expect("a third"), &split.third, &mut said);
            said.holds("goodness at 5 %", split.goodness_p > 0.05);
            said
        });
        let has_flicker = name.ends_with("flicker");
        let judged = |key: &str| {
            let of_good = name.ends_with("test instrument") && key.starts_with("test");
            !key.ends_with("pulled") && !of_good && (has_flicker || !key.ends_with("Hz"))
        };
        let mut outside_band = outside(&shares, HOLD, judged);
        outside_band.extend(outside(&shares, AT_LEAST, |key| !judged(key) && !key.ends_with("pulled")));
        assert!(outside_band.is_empty(), "{name}: {}", outside_band.join(", "));
    }
}

fn rows(value: &Value) -> Vec<Vec<f64>> {
    list(value).iter().map(numbers).collect()
}

/// White noise, the reference's known: what SciPy's orthogonal distance regression finds.
#[test]
fn orthogonal_distance_regression_of_scipy() {
    let expected = reference("diffmag_reference_noise");
    let read = |of: &str| -> [Vec<f64>; 3] { rows(&expected[of]).try_into().expect("three axes") };
    let (reference, test) = (read("reference"), read("test"));
    let step_s = number(&expected["step_s"]);
    let time: Vec<f64> = (0..test[0].len()).map(|row| row as f64 * step_s).collect();
    let mut recording = both("pair", &time, [&reference, &test], &(0..time.len()));
    let noise = numbers(&expected["reference_white_rms_nt"]);
    let of = |axis: Axis| Noise { white_rms_nt: Some(noise[axis.index()]), ..Noise::default() };
    let declared = Axis::ALL.map(|axis| (axis, of(axis))).into_iter().collect();
    recording.conditions.reference_noise = Some(common::NoiseOfSensors::Each(Box::new(declared)));
    let found = found(&document(vec![recording]), false);
    let (matrix, covariance) = (found.matrix.expect("a matrix"), found.covariance.expect("a covariance"));
    let [eta, std] = ["matrix", "std"].map(|key| rows(&expected[key]));
    let mut worst = [0.0_f64; 2];
    for (_, i, j) in elements() {
        let stated = covariance[3 * j + i][3 * j + i].sqrt();
        worst[0] = worst[0].max((matrix[i][j] - eta[i][j]).abs());
        worst[1] = worst[1].max((stated / std[i][j] - 1.0).abs());
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
    let held: Vec<(f64, f64)> = (0..testkit::campaigns(2))
        .into_par_iter()
        .map(|seed| {
            let share = shares[seed as usize % shares.len()];
            let part = |share: f64| {
                json!({"white_rms_nt": 0.1 * f64::sqrt(share), "flicker_nt2_per_hz_at_1hz": 5e-4 * share})
            };
            let scene = Scene::new(part(share), part(1.0 - share), None);
            let report = scene.fit(seed, None).reference_noise.expect("a report");
            let (mut beyond, mut bounds) = (0.0_f64, 0.0_f64);
            for (name, i, j) in elements() {
                let element = &report.elements[&name];
                let off = (element.pulled - ETA[i][j]).abs() - element.largest_pull;
                beyond = beyond.max(off / element.pulled_std);
                bounds = bounds.max(element.largest_pull_over_std);
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
