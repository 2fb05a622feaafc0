//! The joint uncertainty through all stages: what one stage writes, the next uses, and nothing is counted
//! twice or dropped.
//!
//! Each source is put to the test by what it says: the values that it moves are moved by as much in a
//! document, the stages behind run again, and every parameter has to move as the source says.

use common::uncertainty::{VOLTMETER_ABSOLUTE, VOLTMETER_RELATIVE};
use common::{Document, Quantity, Uncertainty, procedure, uncertainty};
use correct::Frame;
use indexmap::IndexMap;
use serde_json::Value;

use crate::campaign::{flight, planned, read, stages};

/// Sources move by this share of a standard uncertainty, so that what is not linear stays small.
const SHARE: f64 = 0.1;
/// A move may differ from what the source says by this share of the parameter's standard uncertainty.
const APART: f64 = 0.03;

/// All values that the sources move, by path: of the document as it is.
fn values(document: &Document, paths: &[String]) -> IndexMap<String, f64> {
    let mut document = document.clone();
    let mut values = IndexMap::new();
    each(&mut document, |path, value| {
        if paths.iter().any(|one| one == path) {
            values.insert(path.to_string(), *value);
        }
    });
    values
}

/// Visits every number of the calibration, and every parameter of an effect, with its path: a quantity by its
/// value. It may be changed.
fn each(document: &mut Document, mut visit: impl FnMut(&str, &mut f64)) {
    let mut calibration = serde_json::to_value(&document.calibration).expect("JSON");
    walk("calibration", &mut calibration, &mut visit);
    document.calibration = serde_json::from_value(calibration).expect("a calibration");
    for effect in document.model.iter_mut().flat_map(|model| &mut model.effects) {
        let paths: Vec<String> =
            effect.parameters.keys().map(|name| uncertainty::effect(effect, name)).collect();
        for (quantity, path) in effect.parameters.values_mut().zip(paths) {
            if let Quantity::Stated { value, .. } = quantity {
                visit(&path, value);
            }
        }
    }
}

fn walk(path: &str, json: &mut Value, visit: &mut dyn FnMut(&str, &mut f64)) {
    match json {
        Value::Number(number) => {
            let before = number.as_f64().expect("a number");
            let mut after = before;
            visit(path, &mut after);
            if after != before {
                *json = after.into();
            }
        }
        Value::Array(list) => {
            list.iter_mut().enumerate().for_each(|(k, one)| walk(&format!("{path}[{k}]"), one, visit));
        }
        Value::Object(keys) => keys.iter_mut().for_each(|(key, one)| {
            let below = format!("{path}.{key}");
            walk(if key == "value" { path } else { &below }, one, visit);
        }),
        _ => {}
    }
}

/// The document with all that a source moves moved by a share of it: constants where they stand, a resistance
/// where it is stated, the voltmeter in what it read after the coils were calibrated.
fn moved(document: &Document, moves: &IndexMap<String, f64>, share: f64) -> Document {
    let mut document = document.clone();
    each(&mut document, |path, value| *value += share * moves.get(path).copied().unwrap_or(0.0));
    let by = |path: &str| share * moves.get(path).copied().unwrap_or(0.0);
    for axis in common::Axis::ALL {
        let coils = document.facility.as_mut().and_then(|facility| facility.coils.as_mut());
        if let Some(ohm) = coils.and_then(|coils| coils.entry(axis).as_mut()?.resistor_ohm.as_mut()) {
            *ohm += by(&uncertainty::resistor(axis));
        }
        let name = format!("coil_{axis}_v");
        for recording in &mut document.recordings {
            if recording.procedure == procedure::COIL_CONSTANT {
                continue;
            }
            if let Some(column) = recording.columns.get_mut(&name) {
                let high = |volts: &f64| volts * (1.0 + by(VOLTMETER_RELATIVE)) + by(VOLTMETER_ABSOLUTE);
                *column = column.iter().map(high).collect::<Vec<f64>>().into();
            }
        }
    }
    document
}

/// What axescal finds beside a constant that was known: its sources move the sum of both, so that the known
/// one's move belongs to it. A voltmeter that adds to every reading acts like an offset of the coil.
fn beside(document: &Document, after: &Document, moves: &IndexMap<String, f64>, path: &str) -> f64 {
    let eta = after.calibration.as_ref().and_then(|c| c.axes.as_ref()?.coils.as_ref()?.matrix);
    let by = |path: &str| moves.get(path).copied().unwrap_or(0.0);
    let calibration = document.calibration.as_ref().expect("a calibration");
    let of = |axis: common::Axis| {
        let constant = calibration.coil(axis).and_then(|coil| coil.constant_nt_per_a.as_ref());
        let k = constant.map_or(0.0, Quantity::value);
        let current: f64 =
            uncertainty::of_current(document, axis, k).iter().map(|(path, like)| like[1] * by(path)).sum();
        if path == uncertainty::added_offset(axis) {
            return by(&uncertainty::sensor_offset(axis));
        }
        let component =
            common::Axis::ALL.into_iter().find(|component| path == uncertainty::residual_field(*component));
        let along = component.zip(eta).map_or(0.0, |(component, eta)| eta[component.index()][axis.index()]);
        along * (by(&uncertainty::coil_offset(axis)) + current)
    };
    common::Axis::ALL.into_iter().map(of).sum()
}

/// Runs `stages` on the document with each source moved up and down, and holds what comes out against what
/// the sources say.
fn check(before: &Document, stages: &dyn Fn(&Document) -> Document, after: &Document) {
    let joint = |document: &Document| Uncertainty::of(document).expect("an uncertainty");
    let (known, found) = (joint(before), joint(after));
    let mut all: Vec<String> = found.sources.iter().flat_map(|source| source.moves.keys().cloned()).collect();
    all.sort();
    all.dedup();
    let mut tested = 0;
    // Each source runs the stages twice: three of them in the small version.
    for (number, source) in testkit::some(known.sources.iter().enumerate().collect(), 31) {
        let said = &found.sources[number];
        assert_eq!(said.name, source.name);
        let [up, down] =
            [SHARE, -SHARE].map(|share| values(&stages(&moved(before, &source.moves, share)), &all));
        for (path, up) in &up {
            let by = (up - down[path]) / (2.0 * SHARE) + beside(before, after, &source.moves, path);
            let due = said.moves.get(path).copied().unwrap_or(0.0);
            let apart = (by - due).abs();
            let (name, std) = (&source.name, found.std(path));
            assert!(apart <= APART * std, "{name}: {path} moves by {by:e} where {due:e} is said, ± {std:e}");
            tested += 1;
        }
    }
    assert!(tested > 40, "{tested}");
}

#[test]
fn sources_move_what_they_say_through_every_stage() {
    let (document, truth) = planned("plans/magsat.json", 1);
    let coils = stages(&["coilcal"], &document);
    let sensors = stages(&["sensorcal"], &coils);
    let axes = stages(&["axescal"], &sensors);
    check(&coils, &|document| stages(&["sensorcal"], document), &sensors);
    check(&sensors, &|document| stages(&["axescal"], document), &axes);
    corrected(&axes, &truth);
}

/// The uncertainty of a corrected field is the sum of what every source moves it by, and the noise of a
/// reading.
fn corrected(document: &Document, truth: &Value) {
    let mut document = document.clone();
    document.recordings = vec![read(truth, flight(1))];
    let column = |document: &Document, name: &str| -> Vec<f64> {
        document.recordings[0].column(name).expect("a column").to_vec()
    };
    let run = |document: &Document| correct::run(document.clone(), Frame::Sen).expect("corrected");
    let quiet = |document: &mut Document| {
        document.instrument.as_mut().expect("an instrument").noise = None;
        document.instrument.as_mut().expect("an instrument").quantisation_v = None;
        let sensors = document.calibration.as_mut().and_then(|c| c.sensors.as_mut()).expect("sensors");
        for axis in common::Axis::ALL {
            sensors.entry(axis).as_mut().expect("a sensor").noise = None;
        }
    };
    quiet(&mut document);
    let stated = run(&document);
    let joint = Uncertainty::of(&document).expect("an uncertainty");
    let names = ["x", "y", "z"].map(|axis| (format!("field_{axis}_nt"), format!("field_std_{axis}_nt")));
    let mut sums = names.clone().map(|(name, _)| vec![0.0; column(&stated, &name).len()]);
    for source in &joint.sources {
        // What axescal adds to an offset has the uncertainty of the sum: the offset itself stays.
        let mut moves = source.moves.clone();
        moves.retain(|path, _| !(path.starts_with("calibration.sensors.") && path.ends_with(".offset_nt")));
        let [up, down] = [SHARE, -SHARE].map(|share| run(&moved(&document, &moves, share)));
        for ((name, _), sums) in names.iter().zip(&mut sums) {
            let (up, down) = (column(&up, name), column(&down, name));
            for (sum, (up, down)) in sums.iter_mut().zip(up.iter().zip(&down)) {
                *sum += ((up - down) / (2.0 * SHARE)).powi(2);
            }
        }
    }
    for ((_, name), sums) in names.iter().zip(&sums) {
        for (row, (std, sum)) in column(&stated, name).iter().zip(sums).enumerate() {
            let due = sum.sqrt();
            assert!((std / due - 1.0).abs() < 2e-3, "row {row}: {name} {std} where {due} is found");
        }
    }
}
