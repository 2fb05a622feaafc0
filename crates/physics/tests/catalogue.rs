//! Loops over the catalogue: every effect has a right Jacobian, is recovered from what it simulated,
//! and is taken out again.

use common::{Axis, Document};
use faer::MatMut;
use nalgebra::Vector3;
use physics::{Basic, Context, EffectInstance, Kind, Parameter, Place, References, Unit};

/// Two hours at uneven steps with a gap, temperature up and down, current on and off; tilted axes.
fn document() -> Document {
    let mut time = Vec::new();
    let mut t = 0.0;
    for row in 0..240 {
        time.push(t);
        t += if row == 120 { 900.0 } else { 20.0 + 7.0 * f64::sin(row as f64) };
    }
    let wave = |period: f64| time.iter().map(|t| (t / period).sin()).collect::<Vec<f64>>();
    let temperature: Vec<f64> =
        wave(700.0).iter().zip(wave(211.0)).map(|(a, b)| 23.0 + 8.0 * a + 2.0 * b).collect();
    let square = |period: f64| time.iter().map(|t| (t / period).sin().signum()).collect::<Vec<f64>>();
    let json = serde_json::json!({
        "fluxcal": 1,
        "recordings": [{"id": "run", "procedure": "free_run",
            "conditions": {"orientation": [[0.0, 0.8, 0.6], [-1.0, 0.0, 0.0], [0.0, -0.6, 0.8]], "ambient_y_nt": 12.0},
            "columns": {"time_s": time, "coil_x_a": square(500.0), "coil_y_a": wave(300.0), "coil_z_a": square(900.0),
                "sensor_temperature_c": temperature}}],
        "calibration": {
            "coils": {"x": {"constant_nt_per_a": 25000.0, "offset_nt": 1.5}, "y": {"constant_nt_per_a": 6000.0},
                "z": {"constant_nt_per_a": 50000.0, "offset_nt": -0.5}},
            "sensors": {"x": {"sensitivity_nt_per_v": 6400.0, "offset_nt": 3.0}, "y": {"sensitivity_nt_per_v": 6390.0},
                "z": {"sensitivity_nt_per_v": 6410.0, "offset_nt": -2.0}},
            "axes": {
                "sensors": {"matrix": [[0.99875, 0.03, 0.05], [0.01, 0.99875, 0.06], [0.0489, 0.0399, 0.9969]]},
                "coils": {"matrix": [[0.9983, -0.01, 0.02], [-0.03, 0.99815, -0.04], [0.05, 0.06, 0.999]]}},
            "reference_conditions": {"sensor_temperature_c": 20.0}}
    });
    Document::parse(&json.to_string()).expect("a good document")
}

fn setting(document: &Document) -> (Basic, Context<'_>) {
    let mut basic = Basic::of(document, Unit::Volt);
    for axis in 0..3 {
        basic.mu.column_mut(axis).normalize_mut();
        basic.eta.column_mut(axis).normalize_mut();
    }
    let context =
        Context::new(document, &document.recordings[0], References::of(document)).expect("a context");
    (basic, context)
}

/// An effect at the geometric middle of its plausible ranges.
fn typical(kind: Kind) -> EffectInstance {
    let parameters = kind.parameters().iter().map(|info| (info.low * info.high).sqrt()).collect();
    EffectInstance { kind, axis: Axis::X, parameters }
}

fn flat(readings: &[Vector3<f64>]) -> Vec<f64> {
    readings.iter().flat_map(|reading| reading.iter().copied()).collect()
}

#[test]
fn jacobians_agree_with_finite_differences() {
    let document = document();
    let (basic, context) = setting(&document);
    for &kind in Kind::ALL {
        let effect = typical(kind);
        let parameters: Vec<Parameter> =
            (0..effect.parameters.len()).map(|k| Parameter::Effect(0, k)).collect();
        let (_, jacobian) =
            physics::predict_with_jacobian(&basic, std::slice::from_ref(&effect), &context, &parameters)
                .expect("predicted");
        let predict = |values: &[f64]| {
            let moved = EffectInstance { parameters: values.to_vec(), ..effect.clone() };
            flat(&physics::predict(&basic, &[moved], &context).expect("predicted").readings)
        };
        let scales: Vec<f64> = effect.parameters.iter().map(|value| value.abs() * 1e-2).collect();
        let columns: Vec<Vec<f64>> = jacobian.iter().map(|column| flat(column)).collect();
        testkit::check_jacobian(predict, &effect.parameters, &scales, &columns, 1e-6);
    }
}

#[test]
fn basic_chain_jacobian_agrees_with_finite_differences() {
    let document = document();
    let (basic, context) = setting(&document);
    let parameters: Vec<Parameter> = Axis::ALL
        .into_iter()
        .flat_map(|axis| {
            [
                Parameter::CoilConstant(axis),
                Parameter::CoilOffset(axis),
                Parameter::CoilTurn(axis, 0),
                Parameter::CoilTurn(axis, 1),
                Parameter::SensorTurn(axis, 0),
                Parameter::SensorTurn(axis, 1),
                Parameter::Sensitivity(axis),
                Parameter::SensorOffset(axis),
            ]
        })
        .collect();
    let (_, jacobian) =
        physics::predict_with_jacobian(&basic, &[], &context, &parameters).expect("predicted");
    let predict = |steps: &[f64]| {
        let mut moved = basic.clone();
        let turned = |matrix: &mut nalgebra::Matrix3<f64>, column: usize, which: usize, step: f64| {
            let direction = matrix.column(column).into_owned();
            let turn = if which == 0 { [step, 0.0] } else { [0.0, step] };
            matrix.set_column(column, &physics::frames::turned(&direction, turn));
        };
        for (parameter, step) in parameters.iter().zip(steps).filter(|(_, step)| **step != 0.0) {
            match *parameter {
                Parameter::CoilConstant(axis) => moved.coils[axis.index()].constant_nt_per_a += step,
                Parameter::CoilOffset(axis) => moved.coils[axis.index()].offset_nt += step,
                Parameter::CoilTurn(axis, which) => turned(&mut moved.eta, axis.index(), which, *step),
                Parameter::SensorTurn(axis, which) => turned(&mut moved.mu, axis.index(), which, *step),
                Parameter::Sensitivity(axis) => moved.sensors[axis.index()].sensitivity += step,
                Parameter::SensorOffset(axis) => moved.sensors[axis.index()].offset_nt += step,
                Parameter::Effect(..) => unreachable!("none here"),
            }
        }
        flat(&physics::predict(&moved, &[], &context).expect("predicted").readings)
    };
    let scales: Vec<f64> = parameters
        .iter()
        .map(|parameter| match parameter {
            Parameter::CoilTurn(..) | Parameter::SensorTurn(..) => 1e-3,
            _ => 1.0,
        })
        .collect();
    let columns: Vec<Vec<f64>> = jacobian.iter().map(|column| flat(column)).collect();
    testkit::check_jacobian(predict, &vec![0.0; parameters.len()], &scales, &columns, 1e-6);
}

/// Fits the parameters of one effect to simulated readings, in nT.
struct OneEffect<'a> {
    basic: &'a Basic,
    context: &'a Context<'a>,
    kind: Kind,
    observed: &'a [f64],
}

impl estimate::Problem for OneEffect<'_> {
    type State = Vec<f64>;

    fn unknowns(&self) -> usize {
        self.kind.parameters().len()
    }

    fn rows(&self) -> usize {
        self.observed.len()
    }

    fn linearise(&self, state: &Vec<f64>, residual: &mut [f64], mut jacobian: MatMut<'_, f64>) {
        let effect = EffectInstance { kind: self.kind, axis: Axis::X, parameters: state.clone() };
        let parameters: Vec<Parameter> = (0..state.len()).map(|k| Parameter::Effect(0, k)).collect();
        let (prediction, derivatives) =
            physics::predict_with_jacobian(self.basic, &[effect], self.context, &parameters)
                .expect("predicted");
        for (i, predicted) in flat(&prediction.readings).into_iter().enumerate() {
            residual[i] = (self.observed[i] - predicted) * 6400.0;
        }
        for (j, column) in derivatives.iter().enumerate() {
            for (i, derivative) in flat(column).into_iter().enumerate() {
                jacobian[(i, j)] = derivative * 6400.0;
            }
        }
    }

    fn advance(&self, state: &Vec<f64>, step: &[f64]) -> Vec<f64> {
        state.iter().zip(step).map(|(value, step)| value + step).collect()
    }
}

#[test]
fn parameters_are_recovered_from_simulated_readings() {
    let document = document();
    let (basic, context) = setting(&document);
    for &kind in Kind::ALL {
        let truth = typical(kind);
        let readings =
            physics::predict(&basic, std::slice::from_ref(&truth), &context).expect("simulated").readings;
        let observed = flat(&readings);
        let problem = OneEffect { basic: &basic, context: &context, kind, observed: &observed };
        let start = truth.parameters.iter().map(|value| value * 0.7).collect();
        let fit = estimate::solve(&problem, start, None, &estimate::Options::default()).expect("a fit");
        for (found, expected) in fit.state.iter().zip(&truth.parameters) {
            assert!((found / expected - 1.0).abs() < 1e-8, "{}: {found} for {expected}", kind.name());
        }
    }
}

#[test]
fn the_chain_runs_backwards() {
    let document = document();
    let (basic, context) = setting(&document);
    for &kind in Kind::ALL {
        let effect = typical(kind);
        let prediction =
            physics::predict(&basic, std::slice::from_ref(&effect), &context).expect("predicted");
        let with = std::slice::from_ref(&effect);
        let field = physics::field_in_sen(&basic, with, &context, &prediction.readings).expect("an inverse");
        let worst = worst_difference(&field, &prediction.field_sen);
        assert!(worst < 1e-6, "{}: {worst} nT", kind.name());
        // Without the effect the field is missed by what the effect does; a facility effect is in the field itself.
        let without = physics::field_in_sen(&basic, &[], &context, &prediction.readings).expect("an inverse");
        let missed = worst_difference(&without, &prediction.field_sen);
        assert_eq!(missed > 1e-3, kind.place() >= Place::SensorBlock, "{}: {missed} nT", kind.name());
    }
}

#[test]
fn a_facility_effect_is_corrected_in_the_field_that_is_predicted() {
    let document = document();
    let (basic, context) = setting(&document);
    let effect = typical(Kind::CoilHeating);
    let heated =
        physics::predict(&basic, std::slice::from_ref(&effect), &context).expect("predicted").field_sen;
    let cold = physics::predict(&basic, &[], &context).expect("predicted").field_sen;
    let by_hand: Vec<f64> = {
        // k falls by a P, τ dP/dt = I² − P; explicit small steps instead of the exact formula.
        let (time, a, tau) =
            (context.times("test").expect("times"), effect.parameters[0] * 1e-6, effect.parameters[1]);
        let mut p = 0.0;
        let mut fall = vec![0.0];
        for row in 1..time.len() {
            let (from, to) = (context.current_a[row - 1].x.powi(2), context.current_a[row].x.powi(2));
            let steps = 20_000;
            let dt = (time[row] - time[row - 1]) / steps as f64;
            for step in 0..steps {
                let squared = from + (to - from) * (step as f64 + 0.5) / steps as f64;
                p += dt / tau * (squared - p);
            }
            fall.push(a * p);
        }
        fall
    };
    for (row, fall) in by_hand.iter().enumerate() {
        let expected = -fall * basic.coils[0].constant_nt_per_a * context.current_a[row].x;
        let found = (heated[row] - cold[row]).dot(&(context.orientation.rotation * basic.eta.column(0)));
        assert!((found - expected).abs() < 1e-3 * expected.abs().max(1e-3), "row {row}: {found} {expected}");
    }
}

#[test]
fn every_effect_says_what_it_is() {
    for &kind in Kind::ALL {
        let shown = typical(kind).to_string();
        assert!(shown.contains(kind.title()) && shown.contains(kind.parameters()[0].name), "{shown}");
        for text in [kind.name(), kind.physics(), kind.equation(), kind.source()] {
            assert!(!text.is_empty());
        }
        let units = ["_s", "_k", "_a2", "_nt", "_ppm", "_hz", "_rad", "_arcsec", "_m", "_v"];
        for info in kind.parameters() {
            assert!(info.low > 0.0 && info.low < info.high);
            assert!(units.iter().any(|unit| info.name.ends_with(unit)), "{} has no unit", info.name);
        }
    }
    let names: std::collections::HashSet<_> = Kind::ALL.iter().map(|kind| kind.name()).collect();
    assert_eq!(names.len(), Kind::ALL.len());
}

#[test]
fn what_an_effect_needs_and_does_not_find_is_named() {
    let mut document = document();
    document.recordings[0].columns.shift_remove("sensor_temperature_c");
    let (basic, context) = setting(&document);
    let effect = typical(Kind::OffsetTemperatureLag);
    let error = physics::predict(&basic, &[effect], &context).expect_err("no temperature");
    assert_eq!(
        error.to_string(),
        "recording \"run\": offset_temperature_lag needs the column `sensor_temperature_c`"
    );
}

fn worst_difference(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max)
}
