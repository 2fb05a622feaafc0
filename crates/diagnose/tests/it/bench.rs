//! Documents with known physics left out.

use common::{Diagnosis, Document, Quantity};
use diagnose::Options;
use physics::{Kind, Role};
use serde_json::{Map, Value, json};
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Rms of the noise of a reading that every document declares, nT.
pub const NOISE_NT: f64 = 0.3;

/// What is recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scene {
    /// Three runs in different orientations, half an hour each: sines on all coils, temperatures up and down.
    Runs,
    /// The same in six shorter runs, an axis up or down in each.
    Cube,
    /// The same as the three with half an hour between rows.
    Days,
    /// Readings 500 times a second, the coils held.
    Fast,
    /// A day from Friday noon, the field outside and the tilts beside.
    Site,
    /// Readings 20 times a second on board: wheel, arrays, Sun and eclipses.
    Craft,
    /// Two magnetometers in the natural field, two days.
    Pair,
}

impl Scene {
    /// Runs, rows of each, and the time from row to row, s.
    fn shape(self) -> (usize, usize, f64) {
        let (runs, rows, step_s) = match self {
            Scene::Runs => (3, 160, 10.0),
            Scene::Cube => (6, 80, 10.0),
            Scene::Days => (3, 160, 1800.0),
            Scene::Fast => (1, 800, 0.002),
            Scene::Site => (1, 900, 100.0),
            Scene::Craft => (1, 900, 0.05),
            Scene::Pair => (1, 900, 180.0),
        };
        (runs, rows * LONGER.load(Ordering::Relaxed), step_s)
    }
}

/// So many times the rows of a scene, whose waves go on.
static LONGER: AtomicUsize = AtomicUsize::new(1);

/// Makes all scenes longer.
pub fn longer(times: usize) {
    LONGER.store(times, Ordering::Relaxed);
}

/// A document of a scene in which `effects` act, with noise of a seed; without a word of them.
pub fn simulated(scene: Scene, effects: &[Value], noise: &Value, seed: u64) -> Document {
    again(parsed(&document(scene)), effects, noise, seed)
}

/// A document recorded again as its columns are, with `effects` acting; without a word of them.
pub fn again(mut document: Document, effects: &[Value], noise: &Value, seed: u64) -> Document {
    document.model = serde_json::from_value(json!({"effects": effects})).expect("a model");
    document.instrument.get_or_insert_default().noise = serde_json::from_value(noise.clone()).expect("noise");
    let mut replayed = simulate::replay(&document, Some(seed)).expect("predicted").document;
    replayed.model = None;
    replayed
}

/// A document from its JSON.
pub fn parsed(document: &Value) -> Document {
    Document::parse(&document.to_string()).unwrap_or_else(|error| panic!("{error}"))
}

/// A document of the fixtures.
pub fn fixture(path: &str) -> Document {
    Document::parse(&testkit::read_fixture(path)).expect("a document")
}

/// The first answer, and the document with it.
pub fn diagnosed_with(document: Document, options: &Options) -> (Diagnosis, Document) {
    let found = diagnose::run(document, options).expect("diagnosed");
    (found.diagnosis.clone().expect("a diagnosis").remove(0), found)
}

/// The same where nothing else is asked for.
pub fn diagnosed(document: Document) -> (Diagnosis, Document) {
    diagnosed_with(document, &Options::default())
}

/// The names of what explains.
pub fn named(entry: &Diagnosis) -> Vec<&str> {
    entry.effects.iter().map(|effect| effect.effect.as_str()).collect()
}

/// The effects of a document's model with what they act on, in the order of the alphabet.
pub fn adopted(document: &Document) -> Vec<String> {
    let effects = document.model.iter().flat_map(|model| &model.effects);
    let mut names: Vec<String> = effects.map(|effect| target(&json!(effect))).collect();
    names.sort();
    names
}

/// A quantity is within so many of its standard uncertainties of the truth, and these are small enough.
pub fn near(found: &Quantity, truth: f64, times: f64, most_std: f64) {
    let std = found.std().expect("an uncertainty");
    assert!((found.value() - truth).abs() < times * std && std < most_std, "{found} for {truth}");
}

fn document(scene: Scene) -> Value {
    let recordings: Vec<Value> = (0..scene.shape().0).map(|run| recording(scene, run)).collect();
    let mut calibration = json!({
        "coils": {"x": {"constant_nt_per_a": 30000.0, "offset_nt": 0.0}, "y": {"constant_nt_per_a": 30000.0, "offset_nt": 0.0},
            "z": {"constant_nt_per_a": 30000.0, "offset_nt": 0.0}},
        "sensors": {"x": {"sensitivity_nt_per_nt": 1.0, "offset_nt": 3.0}, "y": {"sensitivity_nt_per_nt": 1.001, "offset_nt": -2.0},
            "z": {"sensitivity_nt_per_nt": 0.999, "offset_nt": 1.0}},
        "axes": {"sensors": {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}, "coils": {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}},
        "reference_conditions": {"sensor_temperature_c": 23.0, "electronics_temperature_c": 26.0, "coil_temperature_c": 21.0}});
    if scene == Scene::Pair {
        calibration = json!({"differential": {"matrix": [[0.999, 0.02, 0.01], [-0.02, 1.001, 0.005], [-0.01, -0.005, 1.0]],
            "offset_nt": {"x": 5.0, "y": -3.0, "z": 2.0}},
            "reference_conditions": {"sensor_temperature_c": 23.0, "electronics_temperature_c": 26.0}});
    }
    json!({"fluxcal": 1, "title": "diagnose",
        "facility": {"coils": {"x": {"max_nt": 60000, "gradient_nt_per_m_a": 900.0}, "y": {"max_nt": 60000, "gradient_nt_per_m_a": -700.0},
            "z": {"max_nt": 60000, "gradient_nt_per_m_a": 800.0}}},
        "instrument": {"range_nt": 80000,
            "positions_m": {"x": [0.04, 0.0, 0.01], "y": [0.0, 0.05, 0.0], "z": [0.0, 0.01, -0.04]}},
        "calibration": calibration, "recordings": recordings})
}

fn recording(scene: Scene, run: usize) -> Value {
    let (runs, rows, step_s) = scene.shape();
    // Waves keep their number of rows: slower scenes have slower waves.
    let stretch = step_s / 10.0;
    let beginning = step_s * (run * (rows + 30)) as f64;
    let time: Vec<f64> = (0..rows).map(|row| beginning + step_s * row as f64).collect();
    let wave = |period: f64, phase: f64, size: f64| -> Vec<f64> {
        time.iter().map(|t| size * (TAU * t / (period * stretch) + phase).sin()).collect()
    };
    let warm = |level: f64, a: f64, p: f64, b: f64, q: f64| -> Vec<f64> {
        wave(p, 0.3, a).iter().zip(wave(q, 1.1, b)).map(|(u, v)| level + u + v).collect()
    };
    let mut columns = Map::new();
    let mut put = |name: &str, values: Vec<f64>| columns.insert(name.into(), json!(values));
    put("time_s", time.clone());
    put("sensor_temperature_c", warm(23.0, 8.0, 3100.0, 2.0, 900.0));
    put("electronics_temperature_c", warm(26.0, 5.0, 1900.0, 2.0, 700.0));
    if scene == Scene::Pair {
        put("reference_x_nt", warm(21_000.0, 60.0, 4300.0, 150.0, 130.0));
        put("reference_y_nt", warm(900.0, 45.0, 2900.0, 120.0, 210.0));
        put("reference_z_nt", warm(43_000.0, 35.0, 3700.0, 90.0, 170.0));
        for axis in ["x", "y", "z"] {
            put(&format!("test_{axis}_nt"), vec![0.0; rows]);
        }
        return json!({"id": "pair", "procedure": "differential", "start": "2026-05-29T12:00:00+00:00", "columns": columns});
    }
    for (axis, period, phase) in [("x", 610.0, 0.4), ("y", 430.0, 1.3), ("z", 790.0, 2.2)] {
        let held = || vec![f64::sin(phase); rows];
        put(&format!("coil_{axis}_a"), if scene == Scene::Fast { held() } else { wave(period, phase, 1.0) });
        put(&format!("sensor_{axis}_nt"), vec![0.0; rows]);
    }
    put("coil_temperature_c", warm(21.0, 4.0, 2300.0, 1.0, 1100.0));
    if matches!(scene, Scene::Runs | Scene::Craft) {
        put("panel_current_a", warm(1.5, 1.0, 333.0, 0.6, 1250.0));
    }
    if scene == Scene::Site {
        for (axis, level, period) in [("x", 20_000.0, 1700.0), ("y", 300.0, 2600.0), ("z", 43_000.0, 2100.0)]
        {
            put(&format!("outside_{axis}_nt"), warm(level, 40.0, period, 15.0, period / 7.0));
        }
        put("tilt_x_rad", warm(0.0, 2e-5, 4100.0, 1e-5, 520.0));
        put("tilt_y_rad", warm(0.0, -1e-5, 3300.0, 3e-5, 470.0));
    }
    if scene == Scene::Craft {
        put("wheel_hz", warm(4.0, 1.0, 5300.0, 0.4, 1500.0));
        let lit = |t: &f64| f64::from(u8::from((t / (3000.0 * stretch)).rem_euclid(1.0) < 0.63));
        put("sunlit", time.iter().map(lit).collect());
        put("sun_azimuth_rad", wave(2600.0, 0.2, 2.5));
        put("sun_elevation_rad", wave(3900.0, 1.9, 0.9));
    }
    let orientations = [
        json!([[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        json!([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
        json!([[0, 0, -1], [0, 1, 0], [1, 0, 0]]),
        json!([[1, 0, 0], [0, 0, -1], [0, 1, 0]]),
        json!([[-1, 0, 0], [0, -1, 0], [0, 0, 1]]),
        json!([[0, -1, 0], [0, 0, -1], [1, 0, 0]]),
    ];
    let id = if runs > 1 { format!("run-{}", run + 1) } else { "run".into() };
    json!({"id": id, "procedure": "free_run", "start": "2026-05-29T12:00:00+00:00",
        "conditions": {"orientation": orientations[run]}, "columns": columns})
}

/// Declared noise: white and a little flicker, together about [`NOISE_NT`] of a reading. Flicker noise of n
/// readings has the variance A ln(n/2), whatever the step.
pub fn noise() -> Value {
    json!({"white_rms_nt": 0.27, "flicker_nt2_per_hz_at_1hz": 0.003, "flicker_exponent": 1.0})
}

fn readings(document: &Document) -> [Vec<f64>; 3] {
    ["x", "y", "z"].map(|axis| {
        let of = |recording: &common::Recording| {
            let names = [format!("sensor_{axis}_nt"), format!("test_{axis}_nt")];
            names.iter().find_map(|name| recording.column(name)).expect("readings").to_vec()
        };
        document.recordings.iter().flat_map(of).collect()
    })
}

/// An effect scaled so that it makes `times` the noise in the channel that it touches most.
pub fn scaled(scene: Scene, effect: &Value, times: f64) -> Value {
    let none = json!({});
    let without = readings(&simulated(scene, &[], &none, 1));
    if kind(effect).parameters().iter().all(|info| info.role == Role::Epoch) {
        return effect.clone();
    }
    let size = |factor: f64| {
        let with = readings(&simulated(scene, &[times_parameters(effect, factor)], &none, 1));
        let rms = |axis: usize| {
            let part: Vec<f64> =
                with[axis].iter().zip(&without[axis]).map(|(a, b)| a - b).filter(|d| d.is_finite()).collect();
            let mean = part.iter().sum::<f64>() / part.len() as f64;
            (part.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / part.len() as f64).sqrt()
        };
        (0..3).map(rms).fold(0.0, f64::max)
    };
    // Secant steps between the logarithms of factor and size: a level acts the less the higher it is.
    let (mut before, mut factor) = (1.0_f64, 1.0001_f64);
    let mut was = size(before);
    for _ in 0..60 {
        let now = size(factor);
        if now == 0.0 {
            factor = (factor * before).sqrt();
            continue;
        }
        assert!(was > 0.0, "{effect} does nothing");
        let slope = if now == was { 1.0 } else { (now / was).ln() / (factor / before).ln() };
        let wanted = (times * NOISE_NT / now).ln() / slope;
        (before, was) = (factor, now);
        if wanted.abs() < 1e-3 {
            break;
        }
        factor *= wanted.clamp(-1.0, 1.0).exp();
    }
    times_parameters(effect, factor)
}

/// Amplitudes times a factor; the shape where there are none.
fn times_parameters(effect: &Value, factor: f64) -> Value {
    let mut scaled = effect.clone();
    let infos = kind(effect).parameters();
    let sized = infos.iter().any(|info| info.role == Role::Amplitude);
    for info in infos.iter().filter(|info| info.role == if sized { Role::Amplitude } else { Role::Shape }) {
        let value = effect["parameters"][info.name].as_f64().unwrap_or(0.0);
        scaled["parameters"][info.name] = json!(value * factor);
    }
    scaled
}

fn kind(effect: &Value) -> Kind {
    Kind::named(effect["effect"].as_str().expect("a name")).expect("an effect")
}

/// The name of an effect with what it acts on, as plans have it.
pub fn target(effect: &Value) -> String {
    let target = ["sensor", "coil", "column"].iter().find_map(|key| effect[key].as_str());
    let name = effect["effect"].as_str().expect("a name");
    target.map_or_else(|| name.to_string(), |target| format!("{name} {target}"))
}

/// By how many standard deviations parameters differ from what is true, at most.
pub fn worst_sigma(found: &indexmap::IndexMap<String, Quantity>, truth: &Value) -> f64 {
    let off = |(name, value): (&String, &Quantity)| {
        let off = (value.value() - truth["parameters"][name].as_f64()?).abs();
        match value.std().filter(|std| *std > 0.0) {
            Some(std) => Some(off / std),
            // What is told without an uncertainty is exact.
            None => Some(if off <= 1e-6 * value.value().abs() { 0.0 } else { f64::INFINITY }),
        }
    };
    found.iter().filter_map(off).fold(0.0, f64::max)
}
