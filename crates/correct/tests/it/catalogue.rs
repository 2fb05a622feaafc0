//! Every effect of the catalogue: predicted without noise, corrected, and the true field is there again, or
//! it is said why not.

use common::{AdoptedEffect, Axis, Document, Quantity};
use correct::{Error, Frame};
use physics::{Acts, Basic, Kind, Place, References, Setting, Stage};

/// Two hours with temperatures, housekeeping and a driven coil; tilted axes.
fn document() -> Document {
    let rows = 200;
    let time: Vec<f64> = (0..rows).map(|row| 30.0 * f64::from(row) + f64::from(row).sin()).collect();
    let sum = |level: f64, a: f64, p: f64| -> Vec<f64> {
        time.iter().map(|t| level + a * (t / p).sin() + 0.1 * a * (t / 77.0).cos()).collect()
    };
    let json = serde_json::json!({
        "fluxcal": 1,
        "facility": {"coils": {"x": {"gradient_nt_per_m_a": 3.0}}},
        "instrument": {"positions_m": {"x": [0.04, 0.0, 0.01], "y": [0.0, 0.05, 0.0], "z": [0.0, 0.01, -0.04]}},
        "recordings": [{"id": "run", "procedure": "free_run", "start": "2026-05-29T16:00:00+02:00",
            "conditions": {"orientation": [[0.0, 0.8, 0.6], [-1.0, 0.0, 0.0], [0.0, -0.6, 0.8]]},
            "columns": {"time_s": time, "ambient_x_nt": sum(0.0, 44_000.0, 700.0), "ambient_y_nt": sum(900.0, 30_000.0, 400.0),
                "ambient_z_nt": sum(12_000.0, 30_000.0, 900.0), "coil_x_a": sum(0.0, 0.1, 500.0),
                "sensor_x_v": vec![0.0; rows as usize], "sensor_y_v": vec![0.0; rows as usize], "sensor_z_v": vec![0.0; rows as usize],
                "sensor_temperature_c": sum(23.0, 8.0, 700.0), "electronics_temperature_c": sum(25.0, 6.0, 600.0),
                "coil_temperature_c": sum(21.0, 4.0, 900.0), "outside_x_nt": sum(20_000.0, 40.0, 900.0),
                "outside_y_nt": sum(0.0, 20.0, 700.0), "outside_z_nt": sum(40_000.0, 10.0, 500.0),
                "panel_current_a": sum(1.5, 1.0, 800.0), "sun_azimuth_rad": sum(1.0, 2.0, 900.0),
                "sun_elevation_rad": sum(0.0, 1.0, 500.0), "tilt_x_rad": sum(0.0, 2e-5, 700.0), "tilt_y_rad": sum(1e-5, -1e-5, 400.0)}}],
        "calibration": {
            "coils": {"x": {"constant_nt_per_a": 25000.0}},
            "sensors": {"x": {"sensitivity_nt_per_v": 6400.0, "offset_nt": 3.0}, "y": {"sensitivity_nt_per_v": 6390.0},
                "z": {"sensitivity_nt_per_v": 6410.0, "offset_nt": -2.0}},
            "axes": {"sensors": {"matrix": [[0.99975, 0.03, 0.05], [0.01, 0.99875, 0.06], [0.02, 0.04, 0.99695]]}},
            "reference_conditions": {"sensor_temperature_c": 20.0, "electronics_temperature_c": 22.0, "coil_temperature_c": 20.5}}
    });
    Document::parse(&json.to_string()).expect("a good document")
}

/// An effect at the geometric middle of its plausible ranges, each amplitude known to a hundredth.
fn adopted(kind: Kind) -> AdoptedEffect {
    let acts = kind.about().acts;
    let value = |info: &physics::ParameterInfo| match info.role {
        physics::Role::Epoch => Quantity::Bare(info.middle()),
        _ => Quantity::new(info.middle(), 0.01 * info.middle()),
    };
    AdoptedEffect {
        effect: kind.name().into(),
        sensor: (acts == Acts::OneSensor).then_some(Axis::X),
        coil: (acts == Acts::OneCoil).then_some(Axis::X),
        column: matches!(acts, Acts::WithColumn(_)).then(|| "panel_current_a".into()),
        parameters: kind.parameters().iter().map(|info| (info.name.into(), value(info))).collect(),
        ..AdoptedEffect::default()
    }
}

#[test]
fn what_is_predicted_is_corrected() {
    let mut worst: f64 = 0.0;
    for &kind in Kind::ALL.iter().filter(|kind| kind.place() != Place::Sites) {
        let mut document = document();
        document.model = Some(common::Model { effects: vec![adopted(kind)], ..Default::default() });
        let effects = physics::adopt(&document).expect("adopted");
        let setting =
            Setting::of(&document, &document.recordings[0], References::of(&document)).expect("a setting");
        let basic: Basic = setting.basic.clone();
        let prediction = physics::predict(&basic, &effects, &setting.context).expect("predicted");
        let truth = prediction.field_sen.clone();
        for axis in Axis::ALL {
            let readings = prediction.readings.iter().map(|reading| reading[axis.index()]);
            document.recordings[0].columns.insert(format!("sensor_{axis}_v"), readings.collect());
        }
        let corrected = correct::run(document, Frame::Sen);
        if !kind.invertible() {
            let error = corrected.expect_err("no inverse");
            assert!(matches!(&error, Error::Unanswerable(why) if why.contains(kind.name())), "{error}");
            continue;
        }
        let document = corrected.unwrap_or_else(|error| panic!("{}: {error}", kind.name()));
        let recording = &document.recordings[0];
        for (row, truth) in truth.iter().enumerate() {
            let flags = recording.column("field_flags").expect("flags")[row] as u32;
            let wrong = correct::flags::MISSING | correct::flags::NOT_INVERTIBLE;
            assert_eq!(flags & wrong, 0, "{}: row {row}", kind.name());
            for axis in Axis::ALL {
                let found = recording.axis_column("field", axis, "nt").expect("a field")[row];
                worst = worst.max((found - truth[axis.index()]).abs());
                assert!((found - truth[axis.index()]).abs() < 1e-6, "{}: row {row} {axis}", kind.name());
            }
        }
        // What is known of the effect to a hundredth is in the uncertainty, where it acts behind the field.
        let std = recording.column("field_std_x_nt").expect("an uncertainty");
        let uncertain = std.iter().any(|std| *std > 0.0);
        let behind = kind.about().stage >= Stage::Block;
        assert!(std.iter().all(|std| std.is_finite()) && uncertain == behind, "{}", kind.name());
    }
    println!("worst of all effects: {worst:.1e} nT");
}
