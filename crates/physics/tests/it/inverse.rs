//! The chain backwards where memory is longer than a step, where rows have no inverse, and its derivatives.

use common::{Axis, Document};
use nalgebra::{Matrix3, Vector3};
use physics::{Basic, Context, EffectInstance, Inverter, Kind, Parameter, References, Row, Solved, Unit};

/// A field that turns and varies over many rows, one second apart but for one gap and one missing reading.
fn document(rows: usize) -> Document {
    let time: Vec<f64> = (0..rows).map(|row| row as f64 + if row > rows / 2 { 30.0 } else { 0.0 }).collect();
    let wave = |size: f64, period: f64, phase: f64| -> Vec<f64> {
        time.iter().map(|t| size * (t / period + phase).sin() + 40.0 * (t / 2.9).cos()).collect()
    };
    let json = serde_json::json!({"fluxcal": 1,
        "recordings": [{"id": "run", "procedure": "free_run",
            "columns": {"time_s": time, "ambient_x_nt": wave(50_000.0, 31.0, 0.0), "ambient_y_nt": wave(30_000.0, 17.0, 1.0),
                "ambient_z_nt": wave(55_000.0, 43.0, 2.0), "sensor_temperature_c": wave(9.0, 50.0, 0.0)}}],
        "calibration": {
            "sensors": {"x": {"sensitivity_nt_per_v": 6400.0, "offset_nt": 3.0}, "y": {"sensitivity_nt_per_v": 6390.0}, "z": {"sensitivity_nt_per_v": 6410.0}},
            "axes": {"sensors": {"matrix": [[0.99975, 0.03, 0.05], [0.01, 0.99875, 0.06], [0.02, 0.04, 0.99695]]}},
            "reference_conditions": {"sensor_temperature_c": 2.0}}});
    Document::parse(&json.to_string()).expect("a document")
}

fn setting(document: &Document) -> (Basic, Context<'_>) {
    let context = Context::new(document, &document.recordings[0], References::of(document));
    (Basic::of(document, Unit::Volt), context.expect("a context"))
}

fn effect(kind: Kind, axis: Option<Axis>, parameters: &[f64]) -> EffectInstance {
    EffectInstance::new(kind, axis, parameters.to_vec())
}

fn solved<'a>(
    basic: &'a Basic,
    effects: &'a [EffectInstance],
    context: &'a Context<'a>,
    readings: &[Vector3<f64>],
) -> Solved<'a> {
    Inverter::new(basic, effects, context).and_then(|inverter| inverter.field(readings)).expect("solved")
}

/// The rows that are found, and by how much the worst of them misses the true field, nT.
fn round_trip(document: &Document, effects: &[EffectInstance]) -> (Vec<Row>, f64) {
    let (basic, context) = setting(document);
    let prediction = physics::predict(&basic, effects, &context).expect("predicted");
    let solved = solved(&basic, effects, &context, &prediction.readings);
    let off = solved.field_sen.iter().zip(&prediction.field_sen).map(|(found, true_)| (found - true_).amax());
    (solved.rows.clone(), off.filter(|off| off.is_finite()).fold(0.0, f64::max))
}

#[test]
fn lags_longer_than_a_step_are_taken_out() {
    let document = document(400);
    for lag_s in [0.01, 0.3, 1.0, 3.0, 10.0] {
        let (rows, off) = round_trip(&document, &[effect(Kind::LoopBandwidth, Some(Axis::Y), &[lag_s, 0.0])]);
        let lost = rows.iter().filter(|row| **row != Row::Found).count();
        assert!(off < 1e-6 && lost == 0, "{lag_s}: {off} {lost}");
    }
    // Two lags, the second 0.4 times the first: all rows up to a third of a step; of longer ones some rows are not found,
    // and none is claimed wrongly.
    for lag_s in [0.01, 0.3, 1.0, 3.0] {
        let (rows, off) = round_trip(&document, &[effect(Kind::LoopBandwidth, Some(Axis::Y), &[lag_s, 0.4])]);
        let lost = rows.iter().filter(|row| **row != Row::Found).count();
        assert!(off < 1e-6 && (lost == 0) == (lag_s < 0.5) && lost < 100, "{lag_s}: {off} {lost}");
    }
    // What a lag of very many steps leaves of a change from row to row cannot be told from rounding; no row
    // is claimed wrongly.
    let (rows, off) = round_trip(&document, &[effect(Kind::LoopBandwidth, Some(Axis::Y), &[100.0, 0.0])]);
    assert!(rows.contains(&Row::NotInvertible) && off < 1e-6, "{off}");
}

#[test]
fn delays_longer_than_a_step_are_taken_out_but_for_the_rows_that_were_read_too_late() {
    let document = document(400);
    for delay_s in [0.2, 0.7, 1.0, 2.3, 5.0, 12.4] {
        for kind in [Kind::Delay, Kind::ClockOffset] {
            let axis = (kind == Kind::Delay).then_some(Axis::X);
            let (rows, off) = round_trip(&document, &[effect(kind, axis, &[delay_s])]);
            let lost = rows.iter().filter(|row| **row != Row::Found).count();
            // Those after the last moment that was read, and beside a gap those that no reading is near.
            assert!(off < 1e-6 && (lost as f64) < 5.0 * delay_s + 60.0, "{delay_s}: {off} {lost}");
        }
    }
}

#[test]
fn a_reading_beyond_saturation_is_said_to_have_no_field() {
    let document = document(100);
    let (basic, context) = setting(&document);
    let effects = [effect(Kind::Saturation, Some(Axis::X), &[52_000.0, 8.0])];
    let predicted = physics::predict(&basic, &effects, &context).expect("predicted");
    let (mut readings, truth) = (predicted.readings, predicted.field_sen);
    readings[7].x = 52_010.0 / 6400.0;
    readings[9].y = f64::NAN;
    let solved = solved(&basic, &effects, &context, &readings);
    assert_eq!((solved.rows[7], solved.rows[9]), (Row::NotInvertible, Row::Missing));
    for row in (0..100).filter(|row| ![7, 9].contains(row)) {
        assert_eq!(solved.rows[row], Row::Found, "row {row}");
        assert!((solved.field_sen[row] - truth[row]).amax() < 1e-6);
    }
    let error = physics::field_in_sen(&basic, &effects, &context, &readings).expect_err("one row");
    assert!(error.to_string().contains("in 1 row, the first of them row 7"), "{error}");
}

#[test]
fn derivatives_agree_with_differences() {
    let document = document(60);
    let (basic, context) = setting(&document);
    let effects = [
        effect(Kind::SensitivityTemperature, Some(Axis::X), &[28.0, 0.5]),
        effect(Kind::CrossField, Some(Axis::Y), &[5.0, 3.0, 2.0]),
        effect(Kind::LoopBandwidth, Some(Axis::Z), &[1.5, 0.0]),
    ];
    let readings = physics::predict(&basic, &effects, &context).expect("predicted").readings;
    let solve =
        |basic: &Basic, effects: &[EffectInstance]| solved(basic, effects, &context, &readings).field_sen;
    let solved = solved(&basic, &effects, &context, &readings);
    assert!(solved.rows.iter().all(|row| *row == Row::Found));
    let along =
        |parameter: Parameter| solved.along(&[vec![(parameter, 1.0)]]).expect("a derivative").remove(0);
    let check = |parameter: Parameter, step: f64, moved: &dyn Fn(f64) -> Vec<Vector3<f64>>| {
        let found = along(parameter);
        let largest = found.iter().map(|row| row.amax()).fold(0.0, f64::max);
        assert!(largest > 0.0, "{parameter:?}");
        for ((found, ahead), behind) in found.iter().zip(moved(step)).zip(moved(-step)) {
            let numeric = (ahead - behind) / (2.0 * step);
            assert!((numeric - found).amax() < 1e-5 * largest, "{parameter:?}: {found} {numeric}");
        }
    };
    for (parameter, step) in [(Parameter::Sensitivity(Axis::X), 0.1), (Parameter::SensorOffset(Axis::Z), 1.0)]
    {
        let moved = |by: f64| {
            let mut basic = basic.clone();
            *basic.constant_mut(parameter).expect("a constant") += by;
            solve(&basic, &effects)
        };
        check(parameter, step, &moved);
    }
    for (which, number, step) in [(0, 0, 0.1), (1, 2, 0.1), (2, 0, 1e-4)] {
        let moved = |by: f64| {
            let mut effects = effects.clone();
            effects[which].parameters[number] += by;
            solve(&basic, &effects)
        };
        check(Parameter::Effect(which, number), step, &moved);
    }
    let turned = along(Parameter::SensorTurn(Axis::X, 0));
    assert!(turned.iter().all(|row| row.amax() < 70_000.0) && turned.iter().any(|row| row.amax() > 10_000.0));
    // Errors of the readings: with the lag the reading of z is worth less, and the errors of neighbours come
    // in.
    let covariance = solved.covariance_of_readings(Vector3::new(0.01, 0.01, 0.01)).expect("a covariance");
    let plain = basic.mu.transpose().try_inverse().expect("three directions");
    let plain: Matrix3<f64> = plain * plain.transpose() * 0.01;
    for covariance in &covariance[5..25] {
        assert!((covariance[(0, 0)] / plain[(0, 0)] - 1.0).abs() < 0.1, "{covariance}");
        assert!(covariance[(2, 2)] > 2.0 * plain[(2, 2)], "{covariance}");
    }
}

#[test]
fn errors_of_readings_spread_as_drawn_ones_do() {
    // The covariance of a chain that remembers against the spread of fields from readings with drawn errors.
    let document = document(40);
    let (basic, context) = setting(&document);
    let effects = [effect(Kind::LoopBandwidth, Some(Axis::Z), &[0.8, 0.0])];
    let readings = physics::predict(&basic, &effects, &context).expect("predicted").readings;
    let inverter = Inverter::new(&basic, &effects, &context).expect("an inverter");
    let solved = inverter.field(&readings).expect("solved");
    let stated = solved.covariance_of_readings(Vector3::repeat(1.0)).expect("a covariance");
    let mut state = 1_u64;
    let mut sign = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        if state >> 63 == 0 { 1.0 } else { -1.0 }
    };
    let drawn = 400;
    let mut squares = vec![0.0; 40];
    for _ in 0..drawn {
        let noisy: Vec<Vector3<f64>> =
            readings.iter().map(|reading| reading + Vector3::from_fn(|_, _| sign() / 6400.0)).collect();
        let field = inverter.field(&noisy).expect("solved").field_sen;
        let off = field.iter().zip(&solved.field_sen).map(|(a, b)| (a - b).z.powi(2));
        squares.iter_mut().zip(off).for_each(|(sum, square)| *sum += square);
    }
    for row in 2..38 {
        let ratio = squares[row] / f64::from(drawn) / stated[row][(2, 2)];
        assert!((ratio - 1.0).abs() < 0.35, "row {row}: {ratio}");
    }
}
