//! Loops over the catalogue: every effect has a right Jacobian, in which each parameter shows by itself,
//! and is taken out again or says that it cannot be.

use common::{Axis, Document};
use estimate::Svd;
use faer::Mat;
use nalgebra::Vector3;
use physics::{
    Acts, Basic, Context, EffectInstance, Error, Kind, Parameter, ParameterInfo, Place, References, Role,
    Stage, Unit,
};

/// Two hours at uneven steps with a gap, temperatures up and down, currents on and off, housekeeping; tilted
/// axes. On a Friday afternoon, so that working hours end in it.
fn document(procedure: &str) -> Document {
    let mut time = Vec::new();
    let mut t = 0.0;
    for row in 0..240 {
        time.push(t);
        t += if row == 60 { 900.0 } else { 20.0 + 7.0 * f64::sin(row as f64) };
    }
    let wave = |period: f64| time.iter().map(|t| (t / period).sin()).collect::<Vec<f64>>();
    let sum = |level: f64, a: f64, b: f64, p: f64, q: f64| -> Vec<f64> {
        wave(p).iter().zip(wave(q)).map(|(u, v)| level + a * u + b * v).collect()
    };
    let square = |period: f64| time.iter().map(|t| (t / period).sin().signum()).collect::<Vec<f64>>();
    let json = serde_json::json!({
        "fluxcal": 1,
        "facility": {"coils": {"x": {"gradient_nt_per_m_a": 3.0}, "y": {"gradient_nt_per_m_a": 5.0}, "z": {"gradient_nt_per_m_a": -4.0}}},
        "instrument": {"positions_m": {"x": [0.04, 0.0, 0.01], "y": [0.0, 0.05, 0.0], "z": [0.0, 0.01, -0.04]}},
        "recordings": [{"id": "run", "procedure": procedure, "start": "2026-05-29T16:00:00+02:00",
            "conditions": {"orientation": [[0.0, 0.8, 0.6], [-1.0, 0.0, 0.0], [0.0, -0.6, 0.8]], "ambient_y_nt": 12.0},
            "columns": {"time_s": time, "coil_x_a": square(500.0), "coil_y_a": wave(300.0), "coil_z_a": square(900.0),
                "reference_x_nt": sum(21_000.0, 30.0, 9.0, 500.0, 90.0), "reference_y_nt": sum(900.0, 20.0, 12.0, 800.0, 130.0),
                "reference_z_nt": sum(43_000.0, 25.0, 7.0, 300.0, 170.0),
                "sensor_temperature_c": sum(23.0, 8.0, 2.0, 700.0, 211.0),
                "electronics_temperature_c": sum(25.0, 6.0, 3.0, 600.0, 190.0),
                "coil_temperature_c": sum(21.0, 4.0, 1.0, 900.0, 250.0),
                "outside_x_nt": sum(20_000.0, 40.0, 15.0, 900.0, 110.0), "outside_y_nt": sum(0.0, 20.0, 12.0, 700.0, 140.0),
                "outside_z_nt": sum(40_000.0, 10.0, 8.0, 500.0, 170.0),
                "panel_current_a": sum(1.5, 1.0, 0.4, 800.0, 120.0), "sun_azimuth_rad": sum(1.0, 2.0, 0.3, 900.0, 100.0),
                "sun_elevation_rad": wave(500.0), "tilt_x_rad": sum(0.0, 2e-5, 1e-5, 700.0, 160.0), "tilt_y_rad": sum(1e-5, -1e-5, 3e-5, 400.0, 150.0)}}],
        "calibration": {
            "coils": {"x": {"constant_nt_per_a": 25000.0, "offset_nt": 1.5}, "y": {"constant_nt_per_a": 36000.0},
                "z": {"constant_nt_per_a": 50000.0, "offset_nt": -0.5}},
            "sensors": {"x": {"sensitivity_nt_per_v": 6400.0, "offset_nt": 3.0}, "y": {"sensitivity_nt_per_v": 6390.0},
                "z": {"sensitivity_nt_per_v": 6410.0, "offset_nt": -2.0}},
            "axes": {
                "sensors": {"matrix": [[0.99875, 0.03, 0.05], [0.01, 0.99875, 0.06], [0.0489, 0.0399, 0.9969]]},
                "coils": {"matrix": [[0.9983, -0.01, 0.02], [-0.03, 0.99815, -0.04], [0.05, 0.06, 0.999]]}},
            "differential": {"matrix": [[0.99, 0.03, 0.02], [0.01, 1.02, 0.03], [-0.02, 0.01, 0.98]], "offset_nt": {"x": 5.0}},
            "reference_conditions": {"sensor_temperature_c": 20.0, "electronics_temperature_c": 22.0, "coil_temperature_c": 20.5}}
    });
    Document::parse(&json.to_string()).expect("a good document")
}

/// The document on which an effect shows: two sites, or a coil.
fn document_for(kind: Kind) -> Document {
    document(if kind.place() == Place::Sites { "differential" } else { "free_run" })
}

fn setting(document: &Document) -> (Basic, Context<'_>) {
    let context =
        Context::new(document, &document.recordings[0], References::of(document)).expect("a context");
    if context.reference_nt.is_some() {
        return (Basic::differential(document), context);
    }
    let mut basic = Basic::of(document, Unit::Volt);
    for axis in 0..3 {
        basic.mu.column_mut(axis).normalize_mut();
        basic.eta.column_mut(axis).normalize_mut();
    }
    (basic, context)
}

/// An effect at the geometric middle of its plausible ranges.
fn typical(kind: Kind) -> EffectInstance {
    // Two alike may hide a third: a coil as warm at the first row as its current makes it shows no time
    // constant.
    let share = |info: &ParameterInfo| if info.absent.is_some() { 0.5 } else { 1.0 };
    let parameters = kind.parameters().iter().map(|info| share(info) * info.middle()).collect();
    let acts = kind.about().acts;
    let axis = matches!(acts, Acts::OneSensor | Acts::OneCoil).then_some(Axis::X);
    let column = matches!(acts, Acts::WithColumn(_)).then(|| "panel_current_a".into());
    EffectInstance { column, ..EffectInstance::new(kind, axis, parameters) }
}

/// Share of a parameter over which the prediction is smooth: a frequency of many cycles moves less than a
/// time constant.
fn smooth(kind: Kind, name: &str) -> f64 {
    match (kind, name) {
        (_, "frequency_hz") => 1e-8,
        (_, "end_ratio") => 1e-7,
        (_, "inflection_k") => 1e-4,
        (Kind::DifferentialNonlinearity, "period_nt") => 1e-5,
        (Kind::Quantisation, _) => 1e-8,
        (Kind::Clipping | Kind::Perming, _) => 1e-3,
        (Kind::SensitivityAgeing, _) => 1.0,
        // In proportion, and small beside the slow ones.
        (Kind::NullingLeakage | Kind::NullingLeakageAcross, name) if name.starts_with("fast_") => 0.5,
        (_, "second_lag_ratio" | "fast_ratio") => 0.3,
        (Kind::NullingLeakage | Kind::NullingLeakageAcross, _) => 0.05,
        _ => 1e-2,
    }
}

/// The parameters that a derivative says something about.
fn smooth_parameters(kind: Kind) -> Vec<usize> {
    (0..kind.parameters().len()).filter(|k| kind.parameters()[*k].role != Role::Epoch).collect()
}

fn flat(readings: &[Vector3<f64>]) -> Vec<f64> {
    readings.iter().flat_map(|reading| reading.iter().copied()).collect()
}

#[test]
fn jacobians_agree_with_finite_differences() {
    for &kind in Kind::ALL {
        let document = document_for(kind);
        let (basic, context) = setting(&document);
        let effect = typical(kind);
        let chosen = smooth_parameters(kind);
        if chosen.is_empty() {
            continue;
        }
        let parameters: Vec<Parameter> = chosen.iter().map(|k| Parameter::Effect(0, *k)).collect();
        let (_, jacobian) =
            physics::predict_with_jacobian(&basic, std::slice::from_ref(&effect), &context, &parameters)
                .unwrap_or_else(|error| panic!("{error}"));
        let with = |values: &[f64]| {
            let mut moved = effect.clone();
            chosen.iter().zip(values).for_each(|(k, value)| moved.parameters[*k] = *value);
            moved
        };
        let predict = |values: &[f64]| {
            flat(&physics::predict(&basic, &[with(values)], &context).expect("predicted").readings)
        };
        let at: Vec<f64> = chosen.iter().map(|k| effect.parameters[*k]).collect();
        let scales: Vec<f64> = chosen
            .iter()
            .zip(&at)
            .map(|(k, value)| value * smooth(kind, kind.parameters()[*k].name))
            .collect();
        let columns: Vec<Vec<f64>> = jacobian.iter().map(|column| flat(&column.readings)).collect();
        println!("{}", kind.name());
        testkit::check_jacobian(predict, &at, &scales, &columns, 1e-6);
        // One orientation shows one component of a gradient, and a column of a small range no polynomial; of
        // currents that are over within a step their sum alone is seen.
        let one = matches!(kind, Kind::CoilGradient | Kind::Empirical);
        let apart = |j: &usize| kind.parameters()[chosen[*j]].name != "fast_ratio" && !(one && *j > 0);
        let apart: Vec<usize> = (0..chosen.len()).filter(apart).collect();
        let matrix = Mat::from_fn(columns[0].len(), apart.len(), |i, j| columns[apart[j]][i]);
        let rank = Svd::of(matrix.as_ref(), 1e-9).expect("finite").rank();
        assert_eq!(rank, apart.len(), "{} has parameters that cannot be told apart", kind.name());
    }
}

#[test]
fn basic_chain_jacobian_agrees_with_finite_differences() {
    let document = document("free_run");
    let (basic, context) = setting(&document);
    let constants =
        [Parameter::CoilConstant, Parameter::CoilOffset, Parameter::Sensitivity, Parameter::SensorOffset];
    let constants = Axis::ALL.into_iter().flat_map(|axis| constants.map(|constant| constant(axis)));
    let turns = Axis::ALL.into_iter().flat_map(|axis| {
        [0, 1].into_iter().flat_map(move |k| [Parameter::CoilTurn(axis, k), Parameter::SensorTurn(axis, k)])
    });
    let parameters: Vec<Parameter> = constants.chain(turns).collect();
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
                Parameter::CoilTurn(axis, which) => turned(&mut moved.eta, axis.index(), which, *step),
                Parameter::SensorTurn(axis, which) => turned(&mut moved.mu, axis.index(), which, *step),
                constant => *moved.constant_mut(constant).expect("a constant") += step,
            }
        }
        flat(&physics::predict(&moved, &[], &context).expect("predicted").readings)
    };
    let scales: Vec<f64> = parameters
        .iter()
        .map(|of| if matches!(of, Parameter::CoilTurn(..) | Parameter::SensorTurn(..)) { 1e-3 } else { 1.0 })
        .collect();
    let columns: Vec<Vec<f64>> = jacobian.iter().map(|column| flat(&column.readings)).collect();
    testkit::check_jacobian(predict, &vec![0.0; parameters.len()], &scales, &columns, 1e-6);
}

#[test]
fn the_chain_runs_backwards_or_says_that_it_cannot() {
    for &kind in Kind::ALL {
        let document = document_for(kind);
        let (basic, context) = setting(&document);
        let effect = typical(kind);
        let prediction =
            physics::predict(&basic, std::slice::from_ref(&effect), &context).expect("predicted");
        let field =
            physics::field_in_sen(&basic, std::slice::from_ref(&effect), &context, &prediction.readings);
        if !kind.invertible() {
            let error = field.expect_err("no inverse");
            assert!(matches!(&error, Error::Hidden { effect, .. } if effect == kind.name()), "{error}");
            continue;
        }
        let worst = worst_difference(&field.unwrap_or_else(|error| panic!("{error}")), &prediction.field_sen);
        assert!(worst < 1e-6, "{}: {worst} nT", kind.name());
        // Without the effect the field is missed by what the effect does; a facility's effect is in the field
        // itself.
        let without = physics::field_in_sen(&basic, &[], &context, &prediction.readings).expect("an inverse");
        let missed = worst_difference(&without, &prediction.field_sen);
        assert_eq!(missed > 1e-4, kind.about().stage >= Stage::Block, "{}: {missed} nT", kind.name());
    }
}

#[test]
fn what_goes_row_by_row_may_be_cut() {
    for &kind in Kind::ALL.iter().filter(|kind| kind.row_by_row()) {
        let whole = document_for(kind);
        let mut late = whole.clone();
        for column in late.recordings[0].columns.values_mut() {
            column.drain(..100);
        }
        let [whole, late] = [&whole, &late].map(|document| {
            let (basic, context) = setting(document);
            physics::predict(&basic, &[typical(kind)], &context).expect("predicted").readings
        });
        let worst = worst_difference(&whole[100..], &late);
        assert!(worst < 1e-12, "{}: {worst}", kind.name());
    }
}

#[test]
fn every_effect_says_what_it_is() {
    for &kind in Kind::ALL {
        let about = kind.about();
        let shown = typical(kind).to_string();
        assert!(shown.contains(about.title) && shown.contains(kind.parameters()[0].name), "{shown}");
        for text in [about.name, about.title, about.physics, about.equation, about.source] {
            assert!(!text.is_empty() && !text.contains("  "), "{text}");
        }
        for info in kind.parameters() {
            assert!(info.low > 0.0 && info.low < info.high);
            // Sharpness, a share and a ratio are numbers; what refers to a column of any unit is in that unit.
            let units =
                ["_s", "_k", "_k2", "_a2", "_a", "_nt", "_ppm", "_hz", "_arcsec", "_m", "_day", "_unit"];
            let others = ["sharpness", "start_share", "from", "to", "reference"];
            let units = units.iter().chain(&["_ratio"]);
            let known =
                units.into_iter().any(|unit| info.name.ends_with(unit)) || others.contains(&info.name);
            assert!(known, "{} has no unit", info.name);
        }
    }
    let names: std::collections::HashSet<_> = Kind::ALL.iter().map(|kind| kind.name()).collect();
    let titles: std::collections::HashSet<_> = Kind::ALL.iter().map(|kind| kind.about().title).collect();
    assert_eq!([names.len(), titles.len()], [Kind::ALL.len(); 2]);
    assert!(Kind::ALL.is_sorted_by_key(|kind| kind.place()), "the catalogue goes by place");
    assert!(Place::ALL.iter().all(|place| Kind::ALL.iter().any(|kind| kind.place() == *place)));
}

#[test]
fn what_an_effect_needs_and_does_not_find_is_named() {
    // With nothing but readings, every effect that needs a column refuses in words.
    let bare = |procedure: &str| {
        let mut document = document(procedure);
        document.recordings[0].columns.retain(|name, _| name.starts_with("reference_"));
        document.recordings[0].columns.insert("sensor_x_v".into(), vec![1.0; 240].into());
        document.recordings[0].start = None;
        document.facility = None;
        document.instrument = None;
        document
    };
    for &kind in Kind::ALL {
        let document = bare(if kind.place() == Place::Sites { "differential" } else { "free_run" });
        let (basic, context) = setting(&document);
        let needs = kind.about().needs;
        match physics::predict(&basic, &[typical(kind)], &context) {
            Ok(_) => assert!(
                needs
                    .iter()
                    .all(|need| ["rows in the order taken", "a differential recording"].contains(need)),
                "{} needs {needs:?} and did not ask",
                kind.name()
            ),
            Err(error) => {
                assert!(matches!(&error, Error::Missing { who, .. } if who == kind.name()), "{error}");
                assert!(!needs.is_empty(), "{error}");
            }
        }
    }
    let document = bare("free_run");
    let (basic, context) = setting(&document);
    let error =
        physics::predict(&basic, &[typical(Kind::OffsetTemperature)], &context).expect_err("no temperature");
    assert_eq!(
        error.to_string(),
        "recording \"run\": offset_temperature needs the column `sensor_temperature_c`"
    );
}

fn worst_difference(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    assert!(a.iter().chain(b).all(|value| value.iter().all(|value| value.is_finite())), "a value is missing");
    a.iter().zip(b).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max)
}
