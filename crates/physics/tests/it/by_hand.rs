//! What each effect adds, worked out by hand: signs, units and axes, on a bench where nothing else happens.
//! Effects with memory that SciPy recomputes (fixtures/reference) are not repeated here.

use common::{AdoptedEffect, Document, Model};
use nalgebra::Vector3;
use physics::{Basic, Context, References, Unit};
use serde_json::{Value, json};

const AS: f64 = std::f64::consts::PI / 648_000.0;

/// A recording in nT with directions along the axes: the reading is the field.
fn bench(columns: Value, conditions: Value) -> Document {
    let json = json!({
        "fluxcal": 1,
        "recordings": [{"id": "run", "procedure": "free_run", "start": "2026-05-29T16:00:00Z",
            "conditions": conditions, "columns": columns}],
        "calibration": {
            "coils": {"x": {"constant_nt_per_a": 1000.0}, "y": {"constant_nt_per_a": 1000.0}, "z": {"constant_nt_per_a": 1000.0}},
            "reference_conditions": {"sensor_temperature_c": 20.0, "electronics_temperature_c": 20.0, "coil_temperature_c": 20.0}}
    });
    Document::parse(&json.to_string()).expect("a document")
}

/// What an effect adds to the readings x, y, z of each row.
fn added(mut document: Document, effect: Value) -> Vec<Vector3<f64>> {
    let readings = |document: &Document| {
        let effects = physics::adopt(document).expect("an effect");
        let context =
            Context::new(document, &document.recordings[0], References::of(document)).expect("a context");
        let basic = match &context.reference_nt {
            Some(_) => Basic::differential(document),
            None => Basic::of(document, Unit::Nanotesla),
        };
        physics::predict(&basic, &effects, &context).unwrap_or_else(|error| panic!("{error}")).readings
    };
    let without = readings(&document);
    let effect: AdoptedEffect = serde_json::from_value(effect).expect("an effect");
    document.model = Some(Model { effects: vec![effect], ..Model::default() });
    readings(&document).iter().zip(without).map(|(with, without)| with - without).collect()
}

#[track_caller]
fn assert_adds(document: Document, effect: Value, expected: &[[f64; 3]]) {
    let found = added(document, effect.clone());
    assert_eq!(found.len(), expected.len());
    for (row, (found, expected)) in found.iter().zip(expected).enumerate() {
        let missed = (found - Vector3::from(*expected)).amax();
        assert!(missed < 1e-9, "{effect} in row {row}: {:?} where {expected:?} is expected", found.data.0[0]);
    }
}

/// 50 000 nT along x, 25 000 along y, −50 000 along z; and all reversed.
fn field() -> Document {
    bench(
        json!({"time_s": [0, 10], "coil_x_a": [50, -50], "coil_y_a": [25, -25], "coil_z_a": [-50, 50]}),
        json!({}),
    )
}

#[test]
fn curvature_is_even_and_odd() {
    let one = |effect: &str| json!({"effect": effect, "sensor": "y", "parameters": {"departure_nt": 8}});
    assert_adds(field(), one("quadratic_nonlinearity"), &[[0.0, 2.0, 0.0], [0.0, 2.0, 0.0]]);
    assert_adds(field(), one("cubic_nonlinearity"), &[[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]);
}

#[test]
fn cross_fields_in_cyclic_order() {
    // Sensor y: u along z (−50 000 nT), v along x (50 000 nT).
    let effect = json!({"effect": "cross_field", "sensor": "y", "parameters": {"first_nt": 1, "second_nt": 10, "mixed_nt": 100}});
    assert_adds(field(), effect, &[[0.0, 1.0 + 10.0 - 100.0, 0.0]; 2]);
    let effect = json!({"effect": "cross_field_sensitivity", "sensor": "y", "parameters": {"first_nt": 4, "second_nt": 10}});
    // B = 25 000 nT: half of (4 · −1 + 10 · 1); with all fields reversed the same.
    assert_adds(field(), effect, &[[0.0, 3.0, 0.0]; 2]);
}

#[test]
fn temperatures_of_three_thermometers() {
    let warm = || {
        bench(
            json!({"time_s": [0, 10], "coil_x_a": [50, -50], "sensor_temperature_c": [30, 20], "electronics_temperature_c": [20, 25],
                "coil_temperature_c": [22, 20]}),
            json!({}),
        )
    };
    let offset = |name: &str| json!({"effect": name, "sensor": "x", "parameters": {"coefficient_nt_per_k": 0.5, "curvature_nt_per_k2": 0.01}});
    assert_adds(warm(), offset("offset_temperature"), &[[6.0, 0.0, 0.0], [0.0; 3]]);
    assert_adds(warm(), offset("offset_electronics_temperature"), &[[0.0; 3], [2.75, 0.0, 0.0]]);
    // The inflection at the reference: 10 K · 0.5 nT/K, and 0.2 nT/K · 2 K ln cosh 5.
    let inflection = json!({"effect": "offset_temperature_inflection", "sensor": "x",
        "parameters": {"coefficient_nt_per_k": 0.5, "half_change_nt_per_k": 0.2, "inflection_k": 293.15, "width_k": 2}});
    assert_adds(warm(), inflection, &[[5.0 + 0.4 * 5f64.cosh().ln(), 0.0, 0.0], [0.0; 3]]);
    let scale = |name: &str| json!({"effect": name, "sensor": "x", "parameters": {"coefficient_ppm_per_k": 20, "curvature_ppm_per_k2": 1}});
    // 50 000 nT · (200 + 100) ppm; −50 000 nT · (100 + 25) ppm.
    assert_adds(warm(), scale("sensitivity_temperature"), &[[15.0, 0.0, 0.0], [0.0; 3]]);
    assert_adds(warm(), scale("sensitivity_electronics_temperature"), &[[0.0; 3], [-6.25, 0.0, 0.0]]);
    let late = json!({"effect": "sensitivity_electronics_temperature_lag", "sensor": "x",
        "parameters": {"coefficient_ppm_per_k": 20, "lag_s": 5}});
    // 0.5 K/s for 10 s: T_lag = 5 − 0.5 · 5 (1 − e⁻²) K; −50 000 nT · 20 ppm/K.
    let warmer = 5.0 - 2.5 * (1.0 - (-2f64).exp());
    assert_adds(warm(), late, &[[0.0; 3], [-warmer, 0.0, 0.0]]);
    let coil =
        json!({"effect": "coil_temperature", "coil": "x", "parameters": {"coefficient_ppm_per_k": 10}});
    assert_adds(warm(), coil, &[[1.0, 0.0, 0.0], [0.0; 3]]);
    let constant = bench(json!({"coil_x_a": [50]}), json!({"sensor_temperature_c": 30}));
    assert_adds(constant, offset("offset_temperature"), &[[6.0, 0.0, 0.0]]);
    let axis = json!({"effect": "axis_temperature", "sensor": "z", "parameters": {"first_arcsec_per_k": 2, "second_arcsec_per_k": 5}});
    // Sensor z: u along x; 50 000 nT through 20 arcsec.
    assert_adds(warm(), axis, &[[0.0, 0.0, 50_000.0 * 20.0 * AS], [0.0; 3]]);
}

#[test]
fn drifts_on_the_campaign_clock() {
    let day = || bench(json!({"time_s": [0, 86_400], "coil_x_a": [50, -50]}), json!({}));
    let age = json!({"effect": "ageing", "sensor": "z", "parameters": {"rate_nt_per_day": 0.5}});
    assert_adds(day(), age.clone(), &[[0.0; 3], [0.0, 0.0, 0.5]]);
    let scale = json!({"effect": "sensitivity_ageing", "sensor": "x", "parameters": {"rate_ppm_per_day": 2}});
    assert_adds(day(), scale, &[[0.0; 3], [-0.1, 0.0, 0.0]]);
    let warm = json!({"effect": "warm_up", "sensor": "x", "parameters": {"amplitude_nt": 3, "time_constant_s": 86_400}});
    assert_adds(day(), warm, &[[3.0, 0.0, 0.0], [3.0 * (-1f64).exp(), 0.0, 0.0]]);
    // A recording that began a day after the campaign.
    let mut later = day();
    let mut first = later.recordings[0].clone();
    first.id = "first".into();
    first.start = Some("2026-05-28T16:00:00Z".into());
    later.recordings.push(first);
    assert_adds(later.clone(), age.clone(), &[[0.0, 0.0, 0.5], [0.0, 0.0, 1.0]]);
    // An effect that names the other recording does nothing in this one.
    let mut elsewhere = age;
    elsewhere["recording"] = json!("first");
    assert_adds(later, elsewhere, &[[0.0; 3]; 2]);
}

#[test]
fn hysteresis_lags_and_perming_stays() {
    let loops = || bench(json!({"coil_x_a": [0, 40, 0, -40, 0]}), json!({}));
    let lag = json!({"effect": "hysteresis", "sensor": "x", "parameters": {"amplitude_nt": 2, "coercivity_nt": 10}});
    // Far beyond the coercive field z is the sign of the last change: going up the reading is too small.
    assert_adds(
        loops(),
        lag,
        &[[0.0; 3], [-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.0, 0.0], [-2.0, 0.0, 0.0]],
    );
    let perm = json!({"effect": "perming", "sensor": "x", "parameters": {"remanence_ppm": 100, "threshold_nt": 30_000}});
    // 10 000 nT beyond the threshold leave 1 nT, until the opposite field takes it to −1.
    assert_adds(
        loops(),
        perm,
        &[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]],
    );
    // In a first field of 10 000 nT, demagnetised or at rest.
    for (start, first) in [(0.0, 0.0), (1.0, 1.0)] {
        let once = bench(json!({"coil_x_a": [10, 40, 10]}), json!({}));
        let perm = json!({"effect": "perming", "sensor": "x", "parameters": {"remanence_ppm": 100, "threshold_nt": 30_000, "start_share": start}});
        assert_adds(once, perm, &[[first, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    }
}

#[test]
fn the_converter_gets_the_field_less_the_offset() {
    let mut document = bench(json!({"coil_x_a": [0.0273, -60.0]}), json!({}));
    document.calibration.as_mut().expect("a calibration").sensors =
        serde_json::from_value(json!({"x": {"offset_nt": 4.0}})).expect("sensors");
    // M = 27.3 − 4 = 23.3 nT and −60 004 nT.
    let codes = json!({"effect": "quantisation", "sensor": "x", "parameters": {"width_nt": 10}});
    assert_adds(document.clone(), codes, &[[-3.3, 0.0, 0.0], [4.0, 0.0, 0.0]]);
    let clip = json!({"effect": "clipping", "sensor": "x", "parameters": {"level_nt": 60_000}});
    assert_adds(document.clone(), clip, &[[0.0; 3], [4.0, 0.0, 0.0]]);
    let bit = json!({"effect": "differential_nonlinearity", "sensor": "x", "parameters": {"sine_nt": 0.3, "cosine_nt": 0.1, "period_nt": 93.2}});
    let phase = std::f64::consts::TAU * -60_004.0 / 93.2;
    // A quarter of the period: the sine alone.
    assert_adds(document.clone(), bit, &[[0.3, 0.0, 0.0], [0.3 * phase.sin() + 0.1 * phase.cos(), 0.0, 0.0]]);
    let end = json!({"effect": "saturation", "sensor": "x", "parameters": {"level_nt": 60_004}});
    let half = 60_004.0 * (1.0 - 0.5f64.powf(0.125));
    assert_adds(document.clone(), end, &[[0.0; 3], [half, 0.0, 0.0]]);
    let soft =
        json!({"effect": "saturation", "sensor": "x", "parameters": {"level_nt": 60_004, "sharpness": 4}});
    // The first reading is by 23.3 (23.3/60 004)⁴/4 nT too small.
    assert_adds(document, soft, &[[0.0; 3], [60_004.0 * (1.0 - 0.5f64.powf(0.25)), 0.0, 0.0]]);
}

#[test]
fn clocks_and_delays_read_the_past() {
    // A ramp of 100 nT/s on x, 50 on y: 0.5 s late is 50 and 25 nT too small while it rises.
    let ramp =
        || bench(json!({"time_s": [0, 10, 20], "coil_x_a": [0, 1, 2], "coil_y_a": [0, 0.5, 1]}), json!({}));
    let clock = json!({"effect": "clock_offset", "parameters": {"offset_s": 0.5}});
    assert_adds(ramp(), clock, &[[-50.0, -25.0, 0.0]; 3]);
    let rate = json!({"effect": "clock_rate", "parameters": {"rate_ppm": 1000}});
    assert_adds(ramp(), rate, &[[0.0; 3], [-1.0, -0.5, 0.0], [-2.0, -1.0, 0.0]]);
    let late = json!({"effect": "delay", "sensor": "y", "parameters": {"delay_s": 0.5}});
    assert_adds(ramp(), late, &[[0.0, -25.0, 0.0]; 3]);
    let slow = json!({"effect": "loop_bandwidth", "sensor": "x", "parameters": {"lag_s": 0.5}});
    assert_adds(
        ramp(),
        slow,
        &[[-50.0 * (1.0 - (-20f64).exp()), 0.0, 0.0], [-50.0, 0.0, 0.0], [-50.0, 0.0, 0.0]],
    );
}

#[test]
fn steps_spikes_and_frozen_readings() {
    let still = || bench(json!({"time_s": [0, 1, 2, 3, 4], "coil_x_a": [0, 1, 2, 3, 4]}), json!({}));
    let step =
        json!({"effect": "reading_step", "sensor": "y", "parameters": {"height_nt": 5, "time_s": 2.5}});
    assert_adds(still(), step, &[[0.0; 3], [0.0; 3], [0.0; 3], [0.0, 5.0, 0.0], [0.0, 5.0, 0.0]]);
    let spike =
        |t: f64| json!({"effect": "spike", "sensor": "y", "parameters": {"height_nt": 7, "time_s": t}});
    assert_adds(still(), spike(1.2), &[[0.0; 3], [0.0, 7.0, 0.0], [0.0; 3], [0.0; 3], [0.0; 3]]);
    assert_adds(still(), spike(60.0), &[[0.0; 3]; 5]);
    let frozen = json!({"effect": "dropout", "sensor": "x", "parameters": {"time_s": 2, "duration_s": 1.5}});
    assert_adds(still(), frozen, &[[0.0; 3], [0.0; 3], [-1000.0, 0.0, 0.0], [-2000.0, 0.0, 0.0], [0.0; 3]]);
}

#[test]
fn iron_is_fixed_in_geo() {
    // The block turned by 90° about down: SEN x looks east, SEN y south.
    let turned = || {
        bench(
            json!({"coil_x_a": [50], "coil_z_a": [20]}),
            json!({"orientation": [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]}),
        )
    };
    let hard = json!({"effect": "hard_iron", "parameters": {"north_nt": 3, "east_nt": 4, "down_nt": 5}});
    assert_adds(turned(), hard, &[[4.0, -3.0, 5.0]]);
    let soft = |elements: Value| json!({"effect": "soft_iron", "parameters": elements});
    let mut elements = json!({});
    for (number, key) in ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"].iter().enumerate() {
        elements[format!("{key}_ppm")] = json!(10 * (number + 1));
    }
    // North: 50 000 · 10 + 20 000 · 30 ppm = 1.1 nT; east: 40 and 60 → 3.2; down: 70 and 90 → 5.3.
    assert_adds(turned(), soft(elements), &[[3.2, -1.1, 5.3]]);
}

#[test]
fn a_gradient_along_the_axis_is_minus_twice_that_across() {
    let with = |positions: Value, facility: Value| {
        let mut document = bench(json!({"coil_z_a": [50]}), json!({}));
        document.instrument =
            serde_json::from_value(json!({"positions_m": positions})).expect("an instrument");
        document.facility = serde_json::from_value(facility).expect("a facility");
        document
    };
    let positions = json!({"x": [0.1, 0, 0], "y": [0, 0, 0.3], "z": [0, 0, 0.2]});
    let gradient = json!({"effect": "coil_gradient", "coil": "z", "parameters": {"gradient_ppm_per_m": 100}});
    // 50 000 nT · 100 ppm/m = 5 nT/m along z: +1 nT at 0.2 m; −2.5 nT/m across: −0.25 nT at 0.1 m; y sees
    // nothing of its own axis.
    assert_adds(with(positions.clone(), json!({})), gradient, &[[-0.25, 0.0, 1.0]]);
    // u is north and v east: along u as u, 0.5 nT at 0.1 m; along v as n, 1.5 nT at 0.3 m.
    let further = json!({"effect": "coil_gradient", "coil": "z", "parameters": {"gradient_ppm_per_m": 0,
        "gradient_nv_ppm_per_m": 100, "gradient_uu_ppm_per_m": 100}});
    assert_adds(with(positions.clone(), json!({})), further, &[[0.5, 1.5, 0.0]]);
    // The block 0.2 m too low in a coil of 0.1 nT/(m A).
    let known = json!({"coils": {"z": {"gradient_nt_per_m_a": 0.1}}});
    let off = json!({"effect": "off_centre", "parameters": {"x_m": 0, "y_m": 0, "z_m": 0.2}});
    assert_adds(with(json!({}), known.clone()), off, &[[0.0, 0.0, 1.0]]);
    // What is known of both is in the basic chain.
    let document = with(positions, known);
    let context =
        Context::new(&document, &document.recordings[0], References::of(&document)).expect("a context");
    let readings =
        physics::predict(&Basic::of(&document, Unit::Nanotesla), &[], &context).expect("predicted").readings;
    assert!((readings[0] - Vector3::new(-0.25, 0.0, 50_001.0)).amax() < 1e-9, "{}", readings[0]);
}

#[test]
fn lines_at_their_phase_and_their_mean() {
    let quarter = |conditions: Value| bench(json!({"time_s": [0, 0.005], "coil_x_a": [0, 0]}), conditions);
    let parameters = |hz: f64| {
        json!({"north_sine_nt": 1, "north_cosine_nt": 2, "east_sine_nt": 3, "east_cosine_nt": 4,
        "down_sine_nt": 5, "down_cosine_nt": 6, "frequency_hz": hz})
    };
    let mains = json!({"effect": "mains", "parameters": parameters(50.0)});
    assert_adds(quarter(json!({})), mains.clone(), &[[2.0, 4.0, 6.0], [1.0, 3.0, 5.0]]);
    let any = json!({"effect": "periodic_field", "parameters": parameters(50.0)});
    assert_adds(quarter(json!({})), any, &[[2.0, 4.0, 6.0], [1.0, 3.0, 5.0]]);
    // The mean over half a period is 2/π of it.
    let left = 2.0 / std::f64::consts::PI;
    assert_adds(
        quarter(json!({"integration_s": 0.01})),
        mains,
        &[[2.0, 4.0, 6.0].map(|b| b * left), [1.0, 3.0, 5.0].map(|b| b * left)],
    );
    let train = json!({"effect": "traction_power", "parameters": parameters(50.0 / 3.0)});
    assert_adds(
        quarter(json!({})),
        train,
        &[
            [2.0, 4.0, 6.0],
            [1.5f64, 3.5, 5.5].map(|mean| {
                // sin 30° = 1/2, cos 30° = √3/2.
                (mean - 0.5) * 0.5 + (mean + 0.5) * 0.75f64.sqrt()
            }),
        ],
    );
}

#[test]
fn a_dipole_goes_by_north_to_south() {
    // A moment m down at (−v t, 0, h): B ∝ (3 (m·r) r − m r²)/r⁵ with r = (v t, 0, −h); down: (2 h² − (v
    // t)²), north: −3 h v t.
    let time = [-20.0, -10.0, 0.0, 10.0, 20.0];
    let pass = bench(json!({"time_s": time, "coil_x_a": [0, 0, 0, 0, 0]}), json!({}));
    let mut parameters = json!({"time_s": 0, "duration_s": 10});
    for axis in ["north", "east", "down"] {
        for part in ["first", "second", "third"] {
            parameters[format!("{axis}_{part}_nt")] = json!(0);
        }
    }
    parameters["down_first_nt"] = json!(20);
    parameters["down_third_nt"] = json!(-10);
    parameters["north_second_nt"] = json!(-30);
    let dipole = |t: f64| {
        let (m, r): (Vector3<f64>, Vector3<f64>) = (Vector3::z(), Vector3::new(t / 10.0, 0.0, -1.0));
        (r * (3.0 * m.dot(&r)) - m * r.norm_squared()) / r.norm().powi(5) * 10.0
    };
    let expected = time.map(|t| dipole(t).into());
    assert_adds(pass, json!({"effect": "vehicle_pass", "parameters": parameters}), &expected);
}

#[test]
fn working_hours_end_at_five() {
    // Friday 16:00: the second row is 17:00, the third Saturday noon, the fourth Monday 8 h.
    let friday = bench(json!({"time_s": [0, 3600, 72_000, 230_400], "coil_x_a": [0, 0, 0, 0]}), json!({}));
    let effect =
        json!({"effect": "working_hours", "parameters": {"north_nt": 1, "east_nt": 2, "down_nt": 3}});
    assert_adds(friday.clone(), effect.clone(), &[[1.0, 2.0, 3.0], [0.0; 3], [0.0; 3], [1.0, 2.0, 3.0]]);
    let mut late = effect;
    late["parameters"]["slack_s"] = json!(3601.0);
    assert_adds(friday, late, &[[0.0; 3]; 4]);
}

#[test]
fn a_tilt_about_north_takes_down_into_east() {
    let tilted = bench(
        json!({"coil_z_a": [40, 40], "coil_y_a": [10, 10], "tilt_x_rad": [1e-5, 0], "tilt_y_rad": [0, 1e-5]}),
        json!({}),
    );
    // ω × B = ω (0, −B_z, B_y) for ω about x, ω (B_z, 0, −B_x) about y.
    let effect = json!({"effect": "measured_tilt", "parameters": {"gain_ppm": 1_000_000}});
    assert_adds(tilted, effect, &[[0.0, 0.4, -0.1], [-0.4, 0.0, 0.0]]);
}

#[test]
fn a_spacecraft_follows_its_housekeeping() {
    let board = || {
        bench(
            json!({"time_s": [0, 1, 2], "ambient_x_nt": [0, 0, 0], "panel_current_a": [0, 2, -1], "wheel_1_hz": [0.25, 0.25, 0.25],
                "sun_azimuth_deg": [0, 90, 90], "sun_elevation_rad": [0, 0, std::f64::consts::FRAC_PI_2], "sunlit": [1, 1, 1]}),
            json!({}),
        )
    };
    let current = json!({"effect": "stray_current", "column": "panel_current_a", "parameters": {"x_nt_per_a": 3, "y_nt_per_a": 0, "z_nt_per_a": -1}});
    assert_adds(board(), current, &[[0.0; 3], [6.0, 0.0, -2.0], [-3.0, 0.0, 1.0]]);
    let wheel = |name: &str| {
        json!({"effect": name, "column": "wheel_1_hz", "parameters":
        {"x_sine_nt": 1, "x_cosine_nt": 2, "y_sine_nt": 0, "y_cosine_nt": 0, "z_sine_nt": 5, "z_cosine_nt": 0}})
    };
    // A quarter turn a second; half a turn of the second harmonic.
    assert_adds(board(), wheel("reaction_wheel"), &[[2.0, 0.0, 0.0], [1.0, 0.0, 5.0], [-2.0, 0.0, 0.0]]);
    assert_adds(
        board(),
        wheel("reaction_wheel_harmonic"),
        &[[2.0, 0.0, 0.0], [-2.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
    );
    let sun = json!({"effect": "sun_thermoelectric", "parameters": {
        "x_lit_nt": 1, "x_cosine_nt": 10, "x_sine_nt": 100, "x_up_nt": 1000, "y_lit_nt": 0, "y_cosine_nt": 0, "y_sine_nt": 0,
        "y_up_nt": 0, "z_lit_nt": 0, "z_cosine_nt": 0, "z_sine_nt": 7, "z_up_nt": 0}});
    assert_adds(board(), sun.clone(), &[[11.0, 0.0, 0.0], [101.0, 0.0, 7.0], [1001.0, 0.0, 0.0]]);
    let mut dark = board();
    dark.recordings[0].columns["sunlit"] = vec![0.0; 3].into();
    assert_adds(dark, sun, &[[0.0; 3]; 3]);
}

#[test]
fn two_sites_differ_in_what_the_test_instrument_sees() {
    let sites = |east: [f64; 2]| {
        let mut document = bench(
            json!({"time_s": [0, 86_400], "reference_x_nt": [20_000, 20_000], "reference_y_nt": east, "reference_z_nt": [40_000, 40_000],
                "sensor_temperature_c": [30, 30]}),
            json!({}),
        );
        document.recordings[0].procedure = "differential".into();
        document
    };
    let mut elements = json!({});
    for key in ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"] {
        elements[format!("{key}_ppm")] = json!(if key == "xz" {
            50
        } else if key == "zy" {
            1_000
        } else {
            0
        });
    }
    let gradient = json!({"effect": "pillar_gradient", "parameters": elements.clone()});
    assert_adds(sites([100.0, 100.0]), gradient, &[[2.0, 0.0, 0.1]; 2]);
    // East rises by 100 nT in a day; with τ of a second the lag is 100/86 400 nT behind: times 1 000 ppm.
    let mut fast = elements;
    fast["time_constant_s"] = json!(1);
    let behind = 100.0 / 86_400.0 * 1e-3;
    let induction = json!({"effect": "induction_difference", "parameters": fast});
    assert_adds(sites([100.0, 200.0]), induction, &[[0.0, 0.0, behind]; 2]);
    // 10 K · 2 arcsec/K about x: −ω × B = ω (0, B_z, −B_y).
    let tilt = json!({"effect": "pillar_tilt", "parameters": {"about_x_arcsec_per_k": 2, "about_y_arcsec_per_k": 0, "lag_s": 100}});
    let angle = 20.0 * AS;
    assert_adds(sites([100.0, 100.0]), tilt, &[[0.0, angle * 40_000.0, -angle * 100.0]; 2]);
    let settles = json!({"effect": "pillar_settling", "parameters": {"about_x_arcsec_per_day": 0, "about_y_arcsec_per_day": 3}});
    // About y: −ω × B = ω (−B_z, 0, B_x).
    let angle = 3.0 * AS;
    assert_adds(sites([0.0, 0.0]), settles, &[[0.0; 3], [-angle * 40_000.0, 0.0, angle * 20_000.0]]);
    // The surroundings of the test instrument act on it, the facility's do not.
    let hard = json!({"effect": "hard_iron", "parameters": {"north_nt": 3, "east_nt": 4, "down_nt": 5}});
    assert_adds(sites([0.0, 0.0]), hard, &[[0.0; 3]; 2]);
}

#[test]
fn a_missing_sample_leaves_its_neighbours_alone() {
    let rows: Vec<f64> = (0..200).map(f64::from).collect();
    let wave = |null: Option<usize>| -> Vec<Value> {
        rows.iter()
            .map(|t| if null == Some(*t as usize) { Value::Null } else { json!(20.0 * (t / 15.0).sin()) })
            .collect()
    };
    let document = |null| {
        let mut document = bench(
            json!({"time_s": rows, "coil_x_a": wave(null), "sensor_temperature_c": wave(null), "sensor_x_nt": rows}),
            json!({}),
        );
        document.model = serde_json::from_value(json!({"effects": [
            {"effect": "eddy_currents", "coil": "x", "parameters": {"share_ppm": 900, "time_constant_s": 3}},
            {"effect": "offset_temperature", "sensor": "x", "parameters": {"coefficient_nt_per_k": 0.3, "curvature_nt_per_k2": 0.01}},
            {"effect": "loop_bandwidth", "sensor": "x", "parameters": {"lag_s": 0.03}}]}))
        .expect("a model");
        document
    };
    let predict = |document: &Document| {
        let effects = physics::adopt(document).expect("effects");
        let context =
            Context::new(document, &document.recordings[0], References::of(document)).expect("a context");
        let basic = Basic::of(document, Unit::Nanotesla);
        let prediction = physics::predict(&basic, &effects, &context).expect("predicted");
        let mut readings = prediction.readings.clone();
        // One reading more is lost.
        readings[50] = Vector3::repeat(f64::NAN);
        let field = physics::field_in_sen(&basic, &effects, &context, &readings).expect("an inverse");
        (prediction, field)
    };
    let (whole, field) = predict(&document(None));
    let (holed, back) = predict(&document(Some(100)));
    for row in 0..200usize {
        // What the bridge missed fades with the memory of 3 s.
        let fading = 2.0 * (-(row.abs_diff(100) as f64) / 3.0).exp() + 1e-6;
        assert_eq!(holed.readings[row].x.is_nan(), row == 100);
        if row != 100 {
            let missed = (whole.readings[row].x - holed.readings[row].x).abs();
            assert!(missed < if row > 95 { fading } else { 1e-6 }, "row {row}: {missed}");
        }
        for (back, truth, lost) in [(&field, &whole, vec![50]), (&back, &holed, vec![50, 100])] {
            assert_eq!(back[row].x.is_nan(), lost.contains(&row), "row {row}");
            let near = lost.iter().any(|lost| row.abs_diff(*lost) <= 8);
            if !lost.contains(&row) {
                let missed = (back[row] - truth.field_sen[row]).amax();
                assert!(missed < if near { 0.2 } else { 1e-6 }, "row {row}: {missed}");
            }
        }
    }
}

/// Where as much leaks of fast variations as of slow ones, the lag is nothing.
#[test]
fn slow_and_fast_variations_leak() {
    let outside = bench(json!({"time_s": [0, 10], "coil_x_a": [0, 0], "outside_x_nt": [0, 10]}), json!({}));
    let leaks = json!({"effect": "nulling_leakage", "parameters": {"north_ppm": 1e5, "east_ppm": 0, "down_ppm": 0,
        "lag_s": 7, "fast_north_ppm": 1e5}});
    assert_adds(outside.clone(), leaks.clone(), &[[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]]);
    // From the field that is nulled, where that is stated.
    let mut nulled = outside.clone();
    let stated = nulled.calibration.get_or_insert_default().reference_conditions.get_or_insert_default();
    stated.outside_x_nt = Some(0.0);
    assert_adds(nulled, leaks, &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    // Into other axes: of 2, 20 and 200 nT along x, y and z above the mean.
    let outside = bench(
        json!({"time_s": [0, 10], "coil_x_a": [0, 0], "outside_x_nt": [0, 4], "outside_y_nt": [0, 40],
            "outside_z_nt": [0, 400]}),
        json!({}),
    );
    let across = json!({"effect": "nulling_leakage_across", "parameters": {"north_ppm": 1e5, "east_ppm": 2e5,
        "down_ppm": 3e5, "lag_s": 1e-12, "north_from_east_ppm": 4e5, "north_from_down_ppm": 5e5,
        "east_from_north_ppm": 6e5, "east_from_down_ppm": 7e5, "down_from_north_ppm": 8e5, "down_from_east_ppm": 9e5}});
    let above = [0.2 + 8.0 + 100.0, 1.2 + 4.0 + 140.0, 1.6 + 18.0 + 60.0];
    assert_adds(outside, across, &[above.map(|nt| -nt), above]);
}

#[test]
fn short_recordings_are_no_trouble() {
    for rows in [0, 1, 2] {
        let zeros = vec![0.5; rows];
        let time: Vec<f64> = (0..rows).map(|row| row as f64).collect();
        let document = bench(
            json!({"time_s": time, "coil_x_a": zeros, "sensor_temperature_c": zeros, "outside_x_nt": zeros}),
            json!({}),
        );
        for effect in [
            json!({"effect": "delay", "sensor": "x", "parameters": {"delay_s": 0.2}}),
            json!({"effect": "loop_bandwidth", "sensor": "x", "parameters": {"lag_s": 0.2}}),
            json!({"effect": "coil_heating", "coil": "x", "parameters": {"fall_ppm_per_a2": 1, "lag_s": 10}}),
            json!({"effect": "spike", "sensor": "x", "parameters": {"height_nt": 1, "time_s": 0}}),
            json!({"effect": "dropout", "sensor": "x", "parameters": {"time_s": 0, "duration_s": 1}}),
            json!({"effect": "nulling_leakage", "parameters": {"north_ppm": 1, "east_ppm": 1, "down_ppm": 1, "lag_s": 1}}),
            json!({"effect": "offset_temperature_lag", "sensor": "x", "parameters": {"coefficient_nt_per_k": 1, "lag_s": 1}}),
        ] {
            let found = added(document.clone(), effect.clone());
            assert!(
                found.len() == rows && found.iter().all(|value| value.iter().all(|v| v.is_finite())),
                "{effect}"
            );
        }
    }
}

/// Each of two clocks reads the field as it was before either: at 20 s the field of 19.5 s, at 30 s that of
/// 26 s.
#[test]
fn effects_that_act_at_times_of_their_own() {
    let ramp = || bench(json!({"time_s": [0, 10, 20, 30, 40], "coil_x_a": [0, 1, 2, 3, 4]}), json!({}));
    let until = json!({"effect": "clock_offset", "to_s": 30.0, "parameters": {"offset_s": 0.5}});
    assert_adds(
        ramp(),
        until,
        &[[-50.0, 0.0, 0.0], [-50.0, 0.0, 0.0], [-50.0, 0.0, 0.0], [0.0; 3], [0.0; 3]],
    );
    let mut document = ramp();
    let model = json!({"effects": [
        {"effect": "clock_offset", "to_s": 30.0, "parameters": {"offset_s": 0.5}},
        {"effect": "clock_offset", "from_s": 30.0, "parameters": {"offset_s": 12.0}}]});
    document.model = Some(serde_json::from_value(model).expect("a model"));
    let effects = physics::adopt(&document).expect("known");
    let references = References::of(&document);
    let context = Context::new(&document, &document.recordings[0], references).expect("a context");
    let found = physics::predict(&Basic::of(&document, Unit::Nanotesla), &effects, &context)
        .expect("predicted")
        .readings;
    for (row, known) in [-50.0, 950.0, 1950.0, 1800.0, 2800.0].into_iter().enumerate() {
        assert!((found[row].x - known).abs() < 1e-9, "{row}: {}", found[row].x);
    }
}

#[test]
fn structure_without_a_name_by_polynomials() {
    // Places −1, 0 and, beyond the end, 1: T_1 = −1, 0, 1; T_2 = 1, −1, 1; T_3 = −1, 0, 1.
    let document =
        || bench(json!({"time_s": [0, 10, 20], "coil_y_a": [-20, 0, 90], "load_w": [30, 50, 90]}), json!({}));
    let of = |column: &str, from: f64, to: f64| {
        json!({"effect": "empirical", "column": column,
            "parameters": {"from": from, "to": to, "x_1_nt": 2, "z_2_nt": 3, "z_3_nt": 10}})
    };
    let added = [[-2.0, 0.0, 3.0 - 10.0], [0.0, 0.0, -3.0], [2.0, 0.0, 3.0 + 10.0]];
    assert_adds(document(), of("load_w", 30.0, 70.0), &added);
    assert_adds(document(), of("field_y", -20_000.0, 20_000.0), &added);
}
