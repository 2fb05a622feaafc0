//! What each effect adds, worked out by hand: signs, units and axes, on a bench where nothing else happens.
//! Effects with memory that SciPy recomputes (fixtures/reference) are not repeated here.

use common::{AdoptedEffect, Document, Model};
use nalgebra::Vector3;
use physics::{Acts, Basic, Context, Kind, Prediction, References, Unit};
use serde_json::{Value, json};

const AS: f64 = std::f64::consts::PI / 648_000.0;

/// A recording in nT with directions along the axes: the reading is the field.
fn bench(columns: Value) -> Document {
    under(json!({}), columns)
}

/// The same under some conditions.
fn under(conditions: Value, columns: Value) -> Document {
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

/// An effect in words: its name, its sensor or coil, then keys and numbers.
fn effect(text: &str) -> AdoptedEffect {
    let mut words = text.split_whitespace();
    let name = words.next().expect("a name");
    let acts = Kind::named(name).expect("an effect").about().acts;
    let mut effect = json!({"effect": name, "parameters": {}});
    for word in words {
        let (key, value) = word.split_once('=').unwrap_or(("", word));
        match (key, value.parse::<f64>()) {
            ("", _) => effect[if acts == Acts::OneCoil { "coil" } else { "sensor" }] = json!(value),
            ("from_s" | "to_s", Ok(number)) => effect[key] = json!(number),
            (_, Ok(number)) => effect["parameters"][key] = json!(number),
            (_, Err(_)) => effect[key] = json!(value),
        }
    }
    serde_json::from_value(effect).expect("an effect")
}

/// What a document's model predicts for its first recording.
fn predict(document: &Document) -> Prediction {
    let effects = physics::adopt(document).expect("an effect");
    let context =
        Context::new(document, &document.recordings[0], References::of(document)).expect("a context");
    let basic = match &context.reference_nt {
        Some(_) => Basic::differential(document),
        None => Basic::of(document, Unit::Nanotesla),
    };
    physics::predict(&basic, &effects, &context).unwrap_or_else(|error| panic!("{error}"))
}

/// A document whose model has some effects.
fn with(mut document: Document, effects: &[&str]) -> Document {
    let effects = effects.iter().map(|text| effect(text)).collect();
    document.model = Some(Model { effects, ..Model::default() });
    document
}

/// What an effect adds to the readings x, y, z of each row.
fn added(document: &Document, text: &str) -> Vec<Vector3<f64>> {
    let [without, with] = [predict(document), predict(&with(document.clone(), &[text]))];
    with.readings.iter().zip(without.readings).map(|(with, without)| with - without).collect()
}

#[track_caller]
fn assert_adds(document: &Document, text: &str, expected: &[[f64; 3]]) {
    let found = added(document, text);
    assert_eq!(found.len(), expected.len());
    for (row, (found, expected)) in found.iter().zip(expected).enumerate() {
        let missed = (found - Vector3::from(*expected)).amax();
        assert!(missed < 1e-9, "{text} in row {row}: {:?} where {expected:?} is expected", found.data.0[0]);
    }
}

/// Additions to sensor x alone.
fn x<const N: usize>(added: [f64; N]) -> [[f64; 3]; N] {
    added.map(|added| [added, 0.0, 0.0])
}

/// Additions to sensor y alone.
fn y<const N: usize>(added: [f64; N]) -> [[f64; 3]; N] {
    added.map(|added| [0.0, added, 0.0])
}

/// 50 000 nT along x, 25 000 along y, −50 000 along z; and all reversed.
fn field() -> Document {
    bench(json!({"time_s": [0, 10], "coil_x_a": [50, -50], "coil_y_a": [25, -25], "coil_z_a": [-50, 50]}))
}

#[test]
fn curvature_is_even_and_odd() {
    assert_adds(&field(), "quadratic_nonlinearity y departure_nt=8", &y([2.0, 2.0]));
    assert_adds(&field(), "cubic_nonlinearity y departure_nt=8", &y([1.0, -1.0]));
}

#[test]
fn cross_fields_in_cyclic_order() {
    // Sensor y: u along z (−50 000 nT), v along x (50 000 nT).
    let quadratic = "cross_field y first_nt=1 second_nt=10 mixed_nt=100";
    assert_adds(&field(), quadratic, &y([1.0 + 10.0 - 100.0; 2]));
    // B = 25 000 nT: half of (4 · −1 + 10 · 1); with all fields reversed the same.
    assert_adds(&field(), "cross_field_sensitivity y first_nt=4 second_nt=10", &y([3.0; 2]));
}

#[test]
fn temperatures_of_three_thermometers() {
    let warm = bench(json!({"time_s": [0, 10], "coil_x_a": [50, -50], "sensor_temperature_c": [30, 20],
        "electronics_temperature_c": [20, 25], "coil_temperature_c": [22, 20]}));
    let offset = "offset_temperature x coefficient_nt_per_k=0.5 curvature_nt_per_k2=0.01";
    assert_adds(&warm, offset, &x([6.0, 0.0]));
    assert_adds(&warm, &offset.replace("offset_", "offset_electronics_"), &x([0.0, 2.75]));
    // The inflection at the reference: 10 K · 0.5 nT/K, and 0.2 nT/K · 2 K ln cosh 5.
    let inflection = "offset_temperature_inflection x coefficient_nt_per_k=0.5 half_change_nt_per_k=0.2 \
        inflection_k=293.15 width_k=2";
    assert_adds(&warm, inflection, &x([5.0 + 0.4 * 5f64.cosh().ln(), 0.0]));
    // 50 000 nT · (200 + 100) ppm; −50 000 nT · (100 + 25) ppm.
    let scale = "sensitivity_temperature x coefficient_ppm_per_k=20 curvature_ppm_per_k2=1";
    assert_adds(&warm, scale, &x([15.0, 0.0]));
    assert_adds(&warm, &scale.replace("sensitivity_", "sensitivity_electronics_"), &x([0.0, -6.25]));
    // 0.5 K/s for 10 s: T_lag = 5 − 0.5 · 5 (1 − e⁻²) K; −50 000 nT · 20 ppm/K.
    let late = "sensitivity_electronics_temperature_lag x coefficient_ppm_per_k=20 lag_s=5";
    assert_adds(&warm, late, &x([0.0, 2.5 * (1.0 - (-2f64).exp()) - 5.0]));
    assert_adds(&warm, "coil_temperature x coefficient_ppm_per_k=10", &x([1.0, 0.0]));
    let constant = under(json!({"sensor_temperature_c": 30}), json!({"coil_x_a": [50]}));
    assert_adds(&constant, offset, &x([6.0]));
    // Sensor z: u along x; 50 000 nT through 20 arcsec.
    let axis = "axis_temperature z first_arcsec_per_k=2 second_arcsec_per_k=5";
    assert_adds(&warm, axis, &[[0.0, 0.0, 50_000.0 * 20.0 * AS], [0.0; 3]]);
}

/// What the current warms grows as 1 − e^(−t/τ), what was warm before falls as e^(−t/τ): of 2500 A².
#[test]
fn a_coil_warms_and_what_was_warm_cools() {
    let steady = bench(json!({"time_s": [0, 5, 10], "coil_x_a": [50, 50, 50]}));
    let fall = [0.0, -1.0, -2.0].map(|t: f64| 2500.0 * (60.0 * (1.0 - t.exp()) + 20.0 * t.exp()) * 1e-6);
    let heating = "coil_heating x fall_ppm_per_a2=60 fall_at_start_ppm_per_a2=20 lag_s=5";
    assert_adds(&steady, heating, &x(fall.map(|fall| -50_000.0 * fall)));
}

#[test]
fn drifts_on_the_campaign_clock() {
    let day = bench(json!({"time_s": [0, 86_400], "coil_x_a": [50, -50]}));
    assert_adds(&day, "ageing x rate_nt_per_day=0.5", &x([0.0, 0.5]));
    assert_adds(&day, "sensitivity_ageing x rate_ppm_per_day=2", &x([0.0, -0.1]));
    let warm = "warm_up x amplitude_nt=3 time_constant_s=86400";
    assert_adds(&day, warm, &x([3.0, 3.0 * (-1f64).exp()]));
    // A recording that began a day after the campaign.
    let mut later = day.clone();
    let mut first = later.recordings[0].clone();
    first.id = "first".into();
    first.start = Some("2026-05-28T16:00:00Z".into());
    later.recordings.push(first);
    assert_adds(&later, "ageing x rate_nt_per_day=0.5", &x([0.5, 1.0]));
    // An effect that names the other recording does nothing in this one.
    assert_adds(&later, "ageing x rate_nt_per_day=0.5 recording=first", &x([0.0; 2]));
}

#[test]
fn hysteresis_lags_and_perming_stays() {
    let loops = bench(json!({"coil_x_a": [0, 40, 0, -40, 0]}));
    // Far beyond the coercive field z is the sign of the last change: going up the reading is too small.
    let lag = "hysteresis x amplitude_nt=2 coercivity_nt=10";
    assert_adds(&loops, lag, &x([0.0, -2.0, 2.0, 2.0, -2.0]));
    // 10 000 nT beyond the threshold leave 1 nT, until the opposite field takes it to −1.
    let perm = "perming x remanence_ppm=100 threshold_nt=30000";
    assert_adds(&loops, perm, &x([0.0, 1.0, 1.0, -1.0, -1.0]));
    // In a first field of 10 000 nT, demagnetised or at rest.
    for (start, first) in [(0.0, 0.0), (1.0, 1.0)] {
        let once = bench(json!({"coil_x_a": [10, 40, 10]}));
        assert_adds(&once, &format!("{perm} start_share={start}"), &x([first, 1.0, 1.0]));
    }
}

#[test]
fn the_converter_gets_the_field_less_the_offset() {
    let mut with_offset = bench(json!({"coil_x_a": [0.0273, -60.0]}));
    with_offset.calibration.as_mut().expect("a calibration").sensors =
        serde_json::from_value(json!({"x": {"offset_nt": 4.0}})).expect("sensors");
    // M = 27.3 − 4 = 23.3 nT and −60 004 nT.
    assert_adds(&with_offset, "quantisation x width_nt=10", &x([-3.3, 4.0]));
    assert_adds(&with_offset, "clipping x level_nt=60000", &x([0.0, 4.0]));
    // A quarter of the period: the sine alone.
    let phase = std::f64::consts::TAU * -60_004.0 / 93.2;
    let bit = "differential_nonlinearity x sine_nt=0.3 cosine_nt=0.1 period_nt=93.2";
    assert_adds(&with_offset, bit, &x([0.3, 0.3 * phase.sin() + 0.1 * phase.cos()]));
    let half = |power: f64| x([0.0, 60_004.0 * (1.0 - 0.5f64.powf(power))]);
    assert_adds(&with_offset, "saturation x level_nt=60004", &half(0.125));
    // The first reading is by 23.3 (23.3/60 004)⁴/4 nT too small.
    assert_adds(&with_offset, "saturation x level_nt=60004 sharpness=4", &half(0.25));
}

#[test]
fn clocks_and_delays_read_the_past() {
    // A ramp of 100 nT/s on x, 50 on y: 0.5 s late is 50 and 25 nT too small while it rises.
    let ramp = bench(json!({"time_s": [0, 10, 20], "coil_x_a": [0, 1, 2], "coil_y_a": [0, 0.5, 1]}));
    assert_adds(&ramp, "clock_offset offset_s=0.5", &[[-50.0, -25.0, 0.0]; 3]);
    assert_adds(&ramp, "clock_rate rate_ppm=1000", &[[0.0; 3], [-1.0, -0.5, 0.0], [-2.0, -1.0, 0.0]]);
    assert_adds(&ramp, "delay y delay_s=0.5", &y([-25.0; 3]));
    let slow = "loop_bandwidth x lag_s=0.5";
    assert_adds(&ramp, slow, &x([-50.0 * (1.0 - (-20f64).exp()), -50.0, -50.0]));
}

#[test]
fn steps_spikes_and_frozen_readings() {
    let still = bench(json!({"time_s": [0, 1, 2, 3, 4], "coil_x_a": [0, 1, 2, 3, 4]}));
    assert_adds(&still, "reading_step y height_nt=5 time_s=2.5", &y([0.0, 0.0, 0.0, 5.0, 5.0]));
    assert_adds(&still, "spike y height_nt=7 time_s=1.2", &y([0.0, 7.0, 0.0, 0.0, 0.0]));
    assert_adds(&still, "spike y height_nt=7 time_s=60", &y([0.0; 5]));
    assert_adds(&still, "dropout x time_s=2 duration_s=1.5", &x([0.0, 0.0, -1000.0, -2000.0, 0.0]));
}

#[test]
fn iron_is_fixed_in_geo() {
    // The block turned by 90° about down: SEN x looks east, SEN y south.
    let orientation = json!({"orientation": [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]});
    let turned = under(orientation, json!({"coil_x_a": [50], "coil_z_a": [20]}));
    assert_adds(&turned, "hard_iron north_nt=3 east_nt=4 down_nt=5", &[[4.0, -3.0, 5.0]]);
    // North: 50 000 · 10 + 20 000 · 30 ppm = 1.1 nT; east: 40 and 60 → 3.2; down: 70 and 90 → 5.3.
    let soft =
        "soft_iron xx_ppm=10 xy_ppm=20 xz_ppm=30 yx_ppm=40 yy_ppm=50 yz_ppm=60 zx_ppm=70 zy_ppm=80 zz_ppm=90";
    assert_adds(&turned, soft, &[[3.2, -1.1, 5.3]]);
}

#[test]
fn a_gradient_along_the_axis_is_minus_twice_that_across() {
    let with = |positions: Value, facility: Value| {
        let mut document = bench(json!({"coil_z_a": [50]}));
        document.instrument =
            serde_json::from_value(json!({"positions_m": positions})).expect("an instrument");
        document.facility = serde_json::from_value(facility).expect("a facility");
        document
    };
    let positions = json!({"x": [0.1, 0, 0], "y": [0, 0, 0.3], "z": [0, 0, 0.2]});
    // 50 000 nT · 100 ppm/m = 5 nT/m along z: +1 nT at 0.2 m; −2.5 nT/m across: −0.25 nT at 0.1 m; y sees
    // nothing of its own axis.
    let gradient = "coil_gradient z gradient_ppm_per_m=100";
    assert_adds(&with(positions.clone(), json!({})), gradient, &[[-0.25, 0.0, 1.0]]);
    // u is north and v east: along u as u, 0.5 nT at 0.1 m; along v as n, 1.5 nT at 0.3 m.
    let further = "coil_gradient z gradient_ppm_per_m=0 gradient_nv_ppm_per_m=100 gradient_uu_ppm_per_m=100";
    assert_adds(&with(positions.clone(), json!({})), further, &[[0.5, 1.5, 0.0]]);
    // The block 0.2 m too low in a coil of 0.1 nT/(m A).
    let known = json!({"coils": {"z": {"gradient_nt_per_m_a": 0.1}}});
    assert_adds(&with(json!({}), known.clone()), "off_centre x_m=0 y_m=0 z_m=0.2", &[[0.0, 0.0, 1.0]]);
    // What is known of both is in the basic chain.
    let readings = predict(&with(positions, known)).readings;
    assert!((readings[0] - Vector3::new(-0.25, 0.0, 50_001.0)).amax() < 1e-9, "{}", readings[0]);
}

#[test]
fn lines_at_their_phase_and_their_mean() {
    let quarter = |conditions: Value| under(conditions, json!({"time_s": [0, 0.005], "coil_x_a": [0, 0]}));
    let line = |name: &str, hz: f64| {
        format!(
            "{name} north_sine_nt=1 north_cosine_nt=2 east_sine_nt=3 east_cosine_nt=4 down_sine_nt=5 \
             down_cosine_nt=6 frequency_hz={hz}"
        )
    };
    let (whole, mains) = ([[2.0, 4.0, 6.0], [1.0, 3.0, 5.0]], line("mains", 50.0));
    assert_adds(&quarter(json!({})), &mains, &whole);
    assert_adds(&quarter(json!({})), &line("periodic_field", 50.0), &whole);
    // The mean over half a period is 2/π of it.
    let left = whole.map(|row| row.map(|b| b * 2.0 / std::f64::consts::PI));
    assert_adds(&quarter(json!({"integration_s": 0.01})), &mains, &left);
    // sin 30° = 1/2, cos 30° = √3/2.
    let later = [1.0, 3.0, 5.0].map(|sine: f64| sine * 0.5 + (sine + 1.0) * 0.75f64.sqrt());
    assert_adds(&quarter(json!({})), &line("traction_power", 50.0 / 3.0), &[whole[0], later]);
}

#[test]
fn a_dipole_goes_by_north_to_south() {
    // A moment m down at (−v t, 0, h): B ∝ (3 (m·r) r − m r²)/r⁵ with r = (v t, 0, −h); down: (2 h² − (v
    // t)²), north: −3 h v t.
    let time = [-20.0, -10.0, 0.0, 10.0, 20.0];
    let pass = "vehicle_pass north_first_nt=0 north_second_nt=-30 north_third_nt=0 east_first_nt=0 \
        east_second_nt=0 east_third_nt=0 down_first_nt=20 down_second_nt=0 down_third_nt=-10 time_s=0 duration_s=10";
    let dipole = |t: f64| {
        let (m, r): (Vector3<f64>, Vector3<f64>) = (Vector3::z(), Vector3::new(t / 10.0, 0.0, -1.0));
        (r * (3.0 * m.dot(&r)) - m * r.norm_squared()) / r.norm().powi(5) * 10.0
    };
    let expected = time.map(|t| dipole(t).into());
    assert_adds(&bench(json!({"time_s": time, "coil_x_a": [0, 0, 0, 0, 0]})), pass, &expected);
}

#[test]
fn working_hours_end_at_five() {
    // Friday 16:00: the second row is 17:00, the third Saturday noon, the fourth Monday 8 h.
    let friday = bench(json!({"time_s": [0, 3600, 72_000, 230_400], "coil_x_a": [0, 0, 0, 0]}));
    let machines = "working_hours north_nt=1 east_nt=2 down_nt=3";
    assert_adds(&friday, machines, &[[1.0, 2.0, 3.0], [0.0; 3], [0.0; 3], [1.0, 2.0, 3.0]]);
    assert_adds(&friday, &format!("{machines} slack_s=3601"), &[[0.0; 3]; 4]);
}

#[test]
fn a_tilt_about_north_takes_down_into_east() {
    let tilted = bench(json!({"coil_z_a": [40, 40], "coil_y_a": [10, 10],
        "tilt_x_rad": [1e-5, 0], "tilt_y_rad": [0, 1e-5]}));
    // ω × B = ω (0, −B_z, B_y) for ω about x, ω (B_z, 0, −B_x) about y.
    assert_adds(&tilted, "measured_tilt gain_ppm=1000000", &[[0.0, 0.4, -0.1], [-0.4, 0.0, 0.0]]);
}

#[test]
fn a_spacecraft_follows_its_housekeeping() {
    let board = bench(json!({"time_s": [0, 1, 2], "ambient_x_nt": [0, 0, 0], "panel_current_a": [0, 2, -1],
        "wheel_1_hz": [0.25, 0.25, 0.25], "sun_azimuth_deg": [0, 90, 90],
        "sun_elevation_rad": [0, 0, std::f64::consts::FRAC_PI_2], "sunlit": [1, 1, 1]}));
    let current = "stray_current column=panel_current_a x_nt_per_a=3 y_nt_per_a=0 z_nt_per_a=-1";
    assert_adds(&board, current, &[[0.0; 3], [6.0, 0.0, -2.0], [-3.0, 0.0, 1.0]]);
    // A quarter turn a second; half a turn of the second harmonic.
    let wheel = "reaction_wheel column=wheel_1_hz x_sine_nt=1 x_cosine_nt=2 y_sine_nt=0 y_cosine_nt=0 \
        z_sine_nt=5 z_cosine_nt=0";
    assert_adds(&board, wheel, &[[2.0, 0.0, 0.0], [1.0, 0.0, 5.0], [-2.0, 0.0, 0.0]]);
    assert_adds(&board, &wheel.replace("wheel ", "wheel_harmonic "), &x([2.0, -2.0, 2.0]));
    let sun = "sun_thermoelectric x_lit_nt=1 x_cosine_nt=10 x_sine_nt=100 x_up_nt=1000 y_lit_nt=0 y_cosine_nt=0 \
        y_sine_nt=0 y_up_nt=0 z_lit_nt=0 z_cosine_nt=0 z_sine_nt=7 z_up_nt=0";
    assert_adds(&board, sun, &[[11.0, 0.0, 0.0], [101.0, 0.0, 7.0], [1001.0, 0.0, 0.0]]);
    let mut dark = board.clone();
    dark.recordings[0].columns["sunlit"] = vec![0.0; 3].into();
    assert_adds(&dark, sun, &[[0.0; 3]; 3]);
}

#[test]
fn two_sites_differ_in_what_the_test_instrument_sees() {
    let sites = |east: [f64; 2]| {
        let mut document = bench(json!({"time_s": [0, 86_400], "reference_x_nt": [20_000, 20_000],
            "reference_y_nt": east, "reference_z_nt": [40_000, 40_000], "sensor_temperature_c": [30, 30]}));
        document.recordings[0].procedure = "differential".into();
        document
    };
    let gradient = "pillar_gradient xx_ppm=0 xy_ppm=0 xz_ppm=50 yx_ppm=0 yy_ppm=0 yz_ppm=0 zx_ppm=0 zy_ppm=1000 zz_ppm=0";
    assert_adds(&sites([100.0, 100.0]), gradient, &[[2.0, 0.0, 0.1]; 2]);
    // East rises by 100 nT in a day; with τ of a second the lag is 100/86 400 nT behind: times 1 000 ppm.
    let induction =
        format!("{} time_constant_s=1", gradient.replace("pillar_gradient", "induction_difference"));
    assert_adds(&sites([100.0, 200.0]), &induction, &[[0.0, 0.0, 100.0 / 86_400.0 * 1e-3]; 2]);
    // 10 K · 2 arcsec/K about x: −ω × B = ω (0, B_z, −B_y).
    let tilt = "pillar_tilt about_x_arcsec_per_k=2 about_y_arcsec_per_k=0 lag_s=100";
    let angle = 20.0 * AS;
    assert_adds(&sites([100.0, 100.0]), tilt, &[[0.0, angle * 40_000.0, -angle * 100.0]; 2]);
    // About y: −ω × B = ω (−B_z, 0, B_x).
    let settles = "pillar_settling about_x_arcsec_per_day=0 about_y_arcsec_per_day=3";
    let angle = 3.0 * AS;
    assert_adds(&sites([0.0, 0.0]), settles, &[[0.0; 3], [-angle * 40_000.0, 0.0, angle * 20_000.0]]);
    // The surroundings of the test instrument act on it, the facility's do not.
    assert_adds(&sites([0.0, 0.0]), "hard_iron north_nt=3 east_nt=4 down_nt=5", &[[0.0; 3]; 2]);
}

#[test]
fn a_missing_sample_leaves_its_neighbours_alone() {
    let rows: Vec<f64> = (0..200).map(f64::from).collect();
    let wave = |null: Option<usize>| -> Vec<Value> {
        rows.iter()
            .map(|t| if null == Some(*t as usize) { Value::Null } else { json!(20.0 * (t / 15.0).sin()) })
            .collect()
    };
    let both = |null: Option<usize>| {
        let columns = json!({"time_s": rows, "coil_x_a": wave(null), "sensor_temperature_c": wave(null), "sensor_x_nt": rows});
        let effects = [
            "eddy_currents x share_ppm=900 time_constant_s=3",
            "offset_temperature x coefficient_nt_per_k=0.3 curvature_nt_per_k2=0.01",
            "loop_bandwidth x lag_s=0.03",
        ];
        let document = with(bench(columns), &effects);
        let prediction = predict(&document);
        let mut readings = prediction.readings.clone();
        // One reading more is lost.
        readings[50] = Vector3::repeat(f64::NAN);
        let effects = physics::adopt(&document).expect("effects");
        let context =
            Context::new(&document, &document.recordings[0], References::of(&document)).expect("a context");
        let basic = Basic::of(&document, Unit::Nanotesla);
        let field = physics::field_in_sen(&basic, &effects, &context, &readings).expect("an inverse");
        (prediction, field)
    };
    let ((whole, field), (holed, back)) = (both(None), both(Some(100)));
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
    let outside = bench(json!({"time_s": [0, 10], "coil_x_a": [0, 0], "outside_x_nt": [0, 10]}));
    let leaks = "nulling_leakage north_ppm=1e5 east_ppm=0 down_ppm=0 lag_s=7 fast_north_ppm=1e5";
    assert_adds(&outside, leaks, &x([-0.5, 0.5]));
    // From the field that is nulled, where that is stated.
    let mut nulled = outside.clone();
    let stated = nulled.calibration.get_or_insert_default().reference_conditions.get_or_insert_default();
    stated.outside_x_nt = Some(0.0);
    assert_adds(&nulled, leaks, &x([0.0, 1.0]));
    // Into other axes: of 2, 20 and 200 nT along x, y and z above the mean.
    let outside = bench(json!({"time_s": [0, 10], "coil_x_a": [0, 0], "outside_x_nt": [0, 4],
        "outside_y_nt": [0, 40], "outside_z_nt": [0, 400]}));
    let across = "nulling_leakage_across north_ppm=1e5 east_ppm=2e5 down_ppm=3e5 lag_s=1e-12 north_from_east_ppm=4e5 \
        north_from_down_ppm=5e5 east_from_north_ppm=6e5 east_from_down_ppm=7e5 down_from_north_ppm=8e5 \
        down_from_east_ppm=9e5";
    let above = [0.2 + 8.0 + 100.0, 1.2 + 4.0 + 140.0, 1.6 + 18.0 + 60.0];
    assert_adds(&outside, across, &[above.map(|nt| -nt), above]);
}

#[test]
fn short_recordings_are_no_trouble() {
    for rows in [0, 1, 2] {
        let zeros = vec![0.5; rows];
        let time: Vec<f64> = (0..rows).map(|row| row as f64).collect();
        for text in [
            "delay x delay_s=0.2",
            "loop_bandwidth x lag_s=0.2",
            "coil_heating x fall_ppm_per_a2=1 lag_s=10",
            "spike x height_nt=1 time_s=0",
            "dropout x time_s=0 duration_s=1",
            "nulling_leakage north_ppm=1 east_ppm=1 down_ppm=1 lag_s=1",
            "offset_temperature_lag x coefficient_nt_per_k=1 lag_s=1",
        ] {
            let columns = json!({"time_s": time, "coil_x_a": zeros, "sensor_temperature_c": zeros, "outside_x_nt": zeros});
            let found = added(&bench(columns), text);
            let finite = found.iter().all(|value| value.iter().all(|v| v.is_finite()));
            assert!(found.len() == rows && finite, "{text}");
        }
    }
}

/// Each of two clocks reads the field as it was before either: at 20 s the field of 19.5 s, at 30 s that of
/// 26 s.
#[test]
fn effects_that_act_at_times_of_their_own() {
    let ramp = bench(json!({"time_s": [0, 10, 20, 30, 40], "coil_x_a": [0, 1, 2, 3, 4]}));
    let until = "clock_offset to_s=30 offset_s=0.5";
    assert_adds(&ramp, until, &x([-50.0, -50.0, -50.0, 0.0, 0.0]));
    let found = predict(&with(ramp, &[until, "clock_offset from_s=30 offset_s=12"])).readings;
    for (row, known) in [-50.0, 950.0, 1950.0, 1800.0, 2800.0].into_iter().enumerate() {
        assert!((found[row].x - known).abs() < 1e-9, "{row}: {}", found[row].x);
    }
}

#[test]
fn structure_without_a_name_by_polynomials() {
    // Places −1, 0 and, beyond the end, 1: T_1 = −1, 0, 1; T_2 = 1, −1, 1; T_3 = −1, 0, 1.
    let document = bench(json!({"time_s": [0, 10, 20], "coil_y_a": [-20, 0, 90], "load_w": [30, 50, 90]}));
    let added = [[-2.0, 0.0, 3.0 - 10.0], [0.0, 0.0, -3.0], [2.0, 0.0, 3.0 + 10.0]];
    for range in ["load_w from=30 to=70", "field_y from=-20000 to=20000"] {
        let text = format!("empirical column={range} x_1_nt=2 z_2_nt=3 z_3_nt=10");
        assert_adds(&document, &text, &added);
    }
}
