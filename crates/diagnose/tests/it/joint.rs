//! The joint uncertainty that is written: each source is moved in a document, diagnose runs again, and every
//! parameter that it writes has to move as the source says, so that nothing counts twice and nothing is
//! dropped.

use common::{Axis, Document, Quantity, Uncertainty, uncertainty};
use indexmap::IndexMap;
use serde_json::json;

use crate::bench::{Scene, diagnosed, named, noise, simulated};

/// A move may differ from what the source says by this share of the parameter's standard uncertainty.
const APART: f64 = 0.03;

/// The path by which a source is known again.
fn marker(number: usize) -> String {
    format!("test.sources[{number}]")
}

/// Three runs with a sensor that warms, of an instrument whose constants are all uncertain.
fn document() -> Document {
    let warm = json!({"effect": "offset_temperature", "sensor": "x", "parameters": {"coefficient_nt_per_k": 0.4, "curvature_nt_per_k2": 0.02}});
    let mut document = simulated(Scene::Runs, &[warm], &noise(), 5);
    let calibration = document.calibration.as_mut().expect("a calibration");
    let stated = |quantity: &mut Option<Quantity>, std: f64| {
        let value = quantity.as_ref().map_or(0.0, Quantity::value);
        *quantity = Some(Quantity::new(value, std));
    };
    for axis in Axis::ALL {
        let sensor = calibration.sensors.as_mut().and_then(|sensors| sensors.entry(axis).as_mut());
        let sensor = sensor.expect("a sensor");
        stated(&mut sensor.sensitivity_nt_per_nt, 1e-4);
        stated(&mut sensor.offset_nt, 0.5);
        let coil = calibration.coils.as_mut().and_then(|coils| coils.entry(axis).as_mut()).expect("a coil");
        stated(&mut coil.constant_nt_per_a, 2.0);
        stated(&mut coil.offset_nt, 0.3);
    }
    let axes = calibration.axes.as_mut().expect("axes");
    axes.sensors.as_mut().expect("sensors").std_arcsec = Some(common::OneOrEach::One(15.0));
    axes.coils.as_mut().expect("coils").std_arcsec = Some(common::OneOrEach::One(10.0));
    let field = axes.residual_field_nt.get_or_insert_default();
    Axis::ALL.into_iter().for_each(|axis| stated(field.entry(axis), 0.4));
    let mut joint = Uncertainty::of(&document).expect("an uncertainty");
    joint.sources.iter_mut().enumerate().for_each(|(number, source)| {
        source.moves.insert(marker(number), 1.0);
    });
    document.calibration.as_mut().expect("a calibration").uncertainty = Some(joint);
    document
}

/// Visits every parameter with its path; its value may be changed.
fn each(document: &mut Document, mut visit: impl FnMut(&str, &mut f64)) {
    let mut quantity = |path: String, of: &mut Option<Quantity>| {
        if let Some(Quantity::Stated { value, .. }) = of {
            visit(&path, value);
        }
    };
    let calibration = document.calibration.as_mut().expect("a calibration");
    for axis in Axis::ALL {
        let coil = calibration.coils.as_mut().and_then(|coils| coils.entry(axis).as_mut()).expect("a coil");
        quantity(uncertainty::coil_constant(axis), &mut coil.constant_nt_per_a);
        quantity(uncertainty::coil_offset(axis), &mut coil.offset_nt);
        let sensor = calibration.sensors.as_mut().and_then(|sensors| sensors.entry(axis).as_mut());
        let sensor = sensor.expect("a sensor");
        quantity(uncertainty::sensitivity(axis, "nt"), &mut sensor.sensitivity_nt_per_nt);
        quantity(uncertainty::sensor_offset(axis), &mut sensor.offset_nt);
        let axes = calibration.axes.as_mut().expect("axes");
        let field = axes.residual_field_nt.as_mut().expect("a field").entry(axis);
        quantity(uncertainty::residual_field(axis), field);
    }
    for effect in document.model.iter_mut().flat_map(|model| &mut model.effects) {
        let names: Vec<String> = effect.parameters.keys().cloned().collect();
        for name in names {
            let path = uncertainty::effect(effect, &name);
            let mut own = effect.parameters.get(&name).cloned();
            quantity(path, &mut own);
            effect.parameters.extend(own.map(|own| (name, own)));
        }
    }
    let axes = document.calibration.as_mut().and_then(|calibration| calibration.axes.as_mut()).expect("axes");
    for (name, of) in [("sensors", &mut axes.sensors), ("coils", &mut axes.coils)] {
        let matrix = of.as_mut().and_then(|of| of.matrix.as_mut()).expect("a matrix");
        for (at, path) in uncertainty::directions(name).into_iter().enumerate() {
            visit(&path, &mut matrix[at % 3][at / 3]);
        }
    }
}

/// Sources move the sum of the field without drive and the coils' offsets, whose axes are GEO's here.
fn summed(path: &str, of: &dyn Fn(&str) -> f64, sign: f64) -> f64 {
    let component = Axis::ALL.into_iter().find(|axis| path == uncertainty::residual_field(*axis));
    of(path) + component.map_or(0.0, |axis| sign * of(&uncertainty::coil_offset(axis)))
}

/// The document with all that a source moves moved by a share of it.
fn moved(document: &Document, moves: &IndexMap<String, f64>, share: f64) -> Document {
    let mut document = document.clone();
    let by = |path: &str| moves.get(path).copied().unwrap_or(0.0);
    each(&mut document, |path, value| *value += share * summed(path, &by, -1.0));
    document
}

fn run(document: Document) -> Document {
    let (entry, found) = diagnosed(document);
    assert_eq!(named(&entry), ["offset_temperature"]);
    found
}

#[test]
fn sources_move_what_they_say() {
    let before = document();
    let after = run(before.clone());
    let known = Uncertainty::of(&before).expect("an uncertainty");
    let found = Uncertainty::of(&after).expect("an uncertainty");
    let written = after.calibration.as_ref().and_then(|calibration| calibration.uncertainty.as_ref());
    assert_eq!(written, Some(&found), "no value states another");
    let values = |document: &Document| {
        let mut values = IndexMap::new();
        each(&mut document.clone(), |path, value| {
            values.insert(path.to_string(), *value);
        });
        values
    };
    let (mut tested, mut kept) = (0, 0);
    for (number, source) in testkit::some(known.sources.iter().enumerate().collect(), 9) {
        let said =
            found.sources.iter().find(|of| of.moves.contains_key(&marker(number))).expect("the source");
        let [up, down] = [1.0, -1.0].map(|share| values(&run(moved(&before, &source.moves, share))));
        let by = |path: &str| (up[path] - down[path]) / 2.0;
        for path in up.keys() {
            let (by, said) = (summed(path, &by, 1.0), said.moves.get(path).copied().unwrap_or(0.0));
            let std = found.std(path);
            let words = format!("{}: {path} moves by {by:e}, {said:e} is said, with {std:e}", source.name);
            println!("{words}");
            assert!((by - said).abs() <= APART * std, "{words}");
            tested += 1;
            kept += usize::from(said.abs() > 0.1 * std);
        }
    }
    // What the recordings do not show, such as the offset of a coil beside the field, is as uncertain as it
    // was.
    assert!(tested > 60 && kept > 0, "{tested} {kept}");
}
