//! Every procedure gives the report's own sequence, and what it reads is what is true.

use common::{Axis, Column, Document, Noise, Recording, procedure};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use simulate::{Campaign, KnownField, OrbitProcedure, Plan, Procedure, Truth};
use std::sync::LazyLock;

use crate::build::{axes, plan, quiet};

/// A plan with nothing that is random and nothing that is left out of the first model.
fn exact(name: &str) -> Plan {
    let mut plan = quiet(name);
    plan.truth.model = None;
    plan
}

fn simulated(plan: &Plan) -> Campaign {
    simulate::campaign(plan).expect("simulated")
}

fn magsat() -> Campaign {
    static MAGSAT: LazyLock<Campaign> = LazyLock::new(|| simulated(&exact("magsat")));
    MAGSAT.clone()
}

fn of<'a>(document: &'a Document, id: &str) -> &'a Recording {
    document.recordings.iter().find(|recording| recording.id == id).unwrap_or_else(|| panic!("{id}"))
}

fn column<'a>(recording: &'a Recording, name: &str) -> &'a [f64] {
    recording.column(name).unwrap_or_else(|| panic!("{} has no {name}", recording.id))
}

/// A row of three columns.
fn row(recording: &Recording, quantity: &str, row: usize) -> Vector3<f64> {
    Vector3::from(Axis::ALL.map(|axis| column(recording, &format!("{quantity}_{axis}_nt"))[row]))
}

fn coil(truth: &Truth, axis: Axis) -> (f64, f64) {
    let coil = truth.calibration.coil(axis).expect("a coil");
    (coil.constant_nt_per_a.as_ref().expect("k").value(), coil.offset_nt.as_ref().expect("B0").value())
}

fn sensor(truth: &Truth, axis: Axis) -> (f64, f64) {
    let sensor = truth.calibration.sensor(axis).expect("a sensor");
    (sensor.sensitivity_nt_per_v.as_ref().expect("k").value(), sensor.offset_nt.as_ref().expect("O").value())
}

#[test]
fn coil_constants_in_steps_over_both_polarities_with_ten_readings() {
    let Campaign { document, truth } = magsat();
    let [_, eta] = axes(&truth);
    for (id, axis, levels) in [("coil-x", Axis::X, 6), ("coil-y", Axis::Y, 6), ("coil-z", Axis::Z, 9)] {
        let recording = of(&document, id);
        let (volts, read) = (column(recording, &format!("coil_{axis}_v")), column(recording, "reference_nt"));
        let half = levels * 10;
        assert_eq!(volts.len(), 2 * half);
        assert!(volts[..half].iter().all(|v| *v > 0.0) && volts[half..].iter().all(|v| *v < 0.0));
        let (k, b0) = coil(&truth, axis);
        let offsets = Vector3::from(Axis::ALL.map(|axis| coil(&truth, axis).1));
        for (volts, read) in volts.iter().zip(read) {
            // |η (k I + B0) + residual|: the other coils' offsets and what nulling leaves bend the line near zero.
            let mut along = offsets;
            along[axis.index()] = k * volts / 5.0 + b0;
            let field = eta * along + Vector3::from(truth.residual_field_nt);
            assert!((read - field.norm()).abs() < 1e-9, "{id}: {read} for {}", field.norm());
        }
    }
    let z = column(of(&document, "coil-z"), "coil_z_v");
    // 5 000 nT apart as the operator believes: 43 000 nT/A and 5 ohm.
    assert!((z[10] - z[0] - 5000.0 / 43_000.0 * 5.0).abs() < 1e-12);
}

#[test]
fn gradients_every_six_inches_over_three_feet() {
    let Campaign { document, truth } = magsat();
    let recording = of(&document, "gradient-z");
    let (positions, read) = (column(recording, "position_m"), column(recording, "reference_nt"));
    assert_eq!(positions.len(), 70);
    for (row, position) in [(0, -0.4572), (10, -0.3048), (69, 0.4572)] {
        assert!((positions[row] - position).abs() < 1e-12);
    }
    let profile = truth.coil_profile.as_ref().and_then(|all| all.z.clone()).expect("a profile");
    for (position, read) in positions.iter().zip(read) {
        let from_centre = read - column(recording, "reference_nt")[30];
        let expected = 60_030.0 * (profile.at(*position) - 1.0);
        assert!((from_centre - expected).abs() < 1e-3, "{position}: {from_centre}");
        // NASA: the field does not depart from the centre by more than 0.6 nT over three feet.
        assert!(from_centre.abs() < 0.6);
    }
}

#[test]
fn nulling_in_four_conditions_at_three_rates() {
    let Campaign { document, .. } = magsat();
    let nulling = |recording: &&Recording| recording.procedure == procedure::NULLING_RESIDUAL;
    let series = document.recordings.iter().filter(nulling);
    let rates = [(5760, 5.0), (7200, 0.5), (7680, 1.0 / 128.0)];
    let mut sites = Vec::new();
    for (recording, (rows, step)) in series.zip(rates.iter().cycle()) {
        let time = column(recording, "time_s");
        assert_eq!(time.len(), *rows);
        assert!((time[1] - time[0] - step).abs() < 1e-9);
        assert!(recording.column("outside_x_nt").is_some() && recording.column("sensor_z_v").is_some());
        let site = recording.conditions.extra["site"].as_str().expect("a site");
        let start = recording.start().expect("a date");
        for t in [time[0], time[rows - 1]] {
            assert_eq!(simulate::Site::at(start.local_s() + t).name(), site, "{}", recording.id);
        }
        sites.push(site);
    }
    let names = ["weekday-day", "weekday-night", "weekend-day", "weekend-night"];
    assert_eq!(sites, names.map(|name| [name; 3]).concat());
}

#[test]
fn sensitivity_in_101_steps_of_1000_nt() {
    let Campaign { document, truth } = magsat();
    for axis in Axis::ALL {
        let recording = of(&document, &format!("sensitivity-{axis}"));
        let volts = column(recording, "coil_z_v");
        assert_eq!(volts.len(), 101);
        let ((kc, b0), (k, o)) = (coil(&truth, Axis::Z), sensor(&truth, axis));
        assert!(((volts[1] - volts[0]) / 5.0 * 43_000.0 - 1000.0).abs() < 1e-6);
        for (volts, read) in volts.iter().zip(column(recording, &format!("sensor_{axis}_v"))) {
            // The sensor lies along the coil, so that the field along it is the coil's; the other coils'
            // offsets and the residual field add a constant of less than 1 nT.
            let missed = k * read + o - (kc * volts / 5.0 + b0);
            assert!(missed.abs() < 0.6, "{missed}");
        }
        assert_eq!((recording.conditions.sensor, recording.conditions.coil), (Some(axis), Some(Axis::Z)));
    }
}

#[test]
fn reversals_are_a_b_b_a_and_give_the_offset() {
    let Campaign { document, truth } = magsat();
    for axis in Axis::ALL {
        let recording = of(&document, &format!("reversal-{axis}"));
        assert_eq!(column(recording, "position")[..8], [1.0, -1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0]);
        let (k, o) = sensor(&truth, axis);
        let pairs = column(recording, &format!("sensor_{axis}_v")).chunks_exact(2);
        assert_eq!(pairs.len(), 10);
        for pair in pairs {
            // O = −k (V₁ + V₂)/2, with the sign that NASA's eq. 26 has wrong.
            let found = -k * (pair[0] + pair[1]) / 2.0;
            assert!((found - o).abs() < 1e-9, "{found} for {o}");
        }
    }
    // Once a week for a year, each sensor; all at their dates.
    let of_y =
        |r: &&Recording| r.procedure == procedure::OFFSET_DRIFT && r.conditions.sensor == Some(Axis::Y);
    let drift = document.recordings.iter().filter(of_y);
    let dates: Vec<f64> = drift.map(|r| r.start().expect("a date").unix_s).collect();
    assert_eq!(dates.len(), 53);
    assert!(dates.windows(2).all(|pair| pair[1] - pair[0] == 604_800.0));
}

#[test]
fn noise_in_three_series_and_offsets_that_wander() {
    let mut plan = exact("magsat");
    plan.truth.offset_wander = Some(Noise { random_walk_nt_per_sqrt_s: Some(1e-4), ..Noise::default() });
    let Campaign { document, truth } = simulated(&plan);
    let series = ["noise-1", "noise-2", "noise-3"].map(|id| {
        let time = column(of(&document, id), "time_s");
        (time.len(), ((time[1] - time[0]) * 1000.0).round() / 1000.0)
    });
    assert_eq!(series, [(1440, 60.0), (3600, 1.0), (6000, 0.01)]);
    assert_eq!(truth.offset_wander.len(), 159);
    for wander in truth.offset_wander.iter().filter(|wander| wander.recording.starts_with("drift-z")) {
        let read = column(of(&document, &wander.recording), "sensor_z_v");
        let (k, o) = sensor(&truth, Axis::Z);
        let found = -k * (read[0] + read[1]) / 2.0;
        assert!((found - o - wander.offset_nt).abs() < 1e-9, "{}", wander.recording);
    }
    let last = truth.offset_wander.iter().rfind(|w| w.recording.starts_with("drift-x")).expect("wander");
    assert!(last.offset_nt.abs() > 1e-3);
}

#[test]
fn temperatures_up_and_back_and_down_and_back() {
    let Campaign { document, .. } = magsat();
    for (moved, still) in [("sensor", "electronics"), ("electronics", "sensor")] {
        let recording = of(&document, &format!("temperature-{moved}-y"));
        let of = |part: &str| column(recording, &format!("{part}_temperature_c"));
        let mut plateaus: Vec<f64> = of(moved).iter().map(|t| t - 23.0).collect();
        assert_eq!(plateaus.len(), 13 * 11);
        plateaus.dedup();
        assert_eq!(plateaus, [0.0, 5.0, 15.0, 30.0, 15.0, 5.0, 0.0, -5.0, -15.0, -30.0, -15.0, -5.0, 0.0]);
        assert!(of(still).iter().all(|t| *t == 23.0));
        // Half an hour to settle.
        let time = column(recording, "time_s");
        assert!(time[11] - time[10] >= 1800.0 && time[10] - time[9] < 60.0);
    }
    // With readings on the way the enclosure is seen to approach.
    let cubesat = simulated(&exact("cubesat")).document;
    let run = of(&cubesat, "temperature-sensor-x");
    assert!(column(run, "time_s").windows(2).all(|pair| pair[1] - pair[0] <= 61.0));
    assert!(column(run, "sensor_temperature_c").iter().any(|t| (22.5..36.5).contains(t)));
}

#[test]
fn cross_fields_reach_both_sides_of_the_sensor() {
    let Campaign { document, truth } = magsat();
    let [mu, eta] = axes(&truth);
    for axis in Axis::ALL {
        let side = |id: String| {
            let rotation = of(&document, &id).conditions.orientation.expect("an orientation");
            let rotation = Matrix3::from_fn(|r, c| rotation[r][c]);
            // The sensor lies along coil x exactly; coil z is across it.
            let along = (rotation * eta.column(0)).dot(&mu.column(axis.index()));
            assert!((along - 1.0).abs() < 1e-12, "{along}");
            rotation * Vector3::z()
        };
        let (first, second) = (side(format!("cross-{axis}-z")), side(format!("cross-turned-{axis}-z")));
        assert!(first.dot(&second).abs() < 0.1, "{first} {second}");
        let levels = column(of(&document, &format!("cross-{axis}-z")), "coil_z_v");
        assert_eq!(levels.len(), 33);
        assert!((levels[11] / 5.0 * 43_000.0 - 60_000.0).abs() < 1e-6);
        assert!((levels[22] + levels[11]).abs() < 1e-12);
    }
}

#[test]
fn orientations_of_figure_9_and_ac_drive() {
    let Campaign { document, truth } = magsat();
    let axes = document.recordings.iter().filter(|r| r.procedure == procedure::AXES_ORIENTATION);
    let (dc, ac): (Vec<_>, Vec<_>) = axes.partition(|r| r.conditions.drive_hz.is_none());
    assert_eq!((dc.len(), ac.len()), (4, 12));
    assert!(ac.iter().all(|r| r.conditions.drive_hz == Some(0.1) && r.rows() == 2000));
    assert!(dc.iter().all(|r| r.conditions.theodolite.is_some() && r.rows() == 8));
    // Two quarter turns about the azimuth axis, then one about the elevation axis.
    for (id, turned) in [
        ("axes-2", [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
        ("axes-3", [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]),
        ("axes-4", [[1, 0, 0], [0, 0, 1], [0, -1, 0]]),
    ] {
        let found = truth.orientations.iter().find(|o| o.recording == id).expect("an orientation");
        assert_eq!(found.orientation.map(|row| row.map(|value| value.round() as i32)), turned, "{id}");
    }
}

#[test]
fn two_magnetometers_for_a_month_obey_t_is_r_eta_plus_d() {
    let Campaign { document, truth } = simulated(&exact("observatory-pair"));
    let recording = of(&document, "month");
    assert_eq!(recording.rows(), 43_200);
    let differential = truth.calibration.differential.as_ref().expect("η and d");
    let eta = Matrix3::from_fn(|r, c| differential.matrix.expect("η")[r][c]);
    for at in [0, 10_000, 20_000, 43_199] {
        let predicted = eta.transpose() * row(recording, "reference", at) + Vector3::new(12.0, -7.5, 21.0);
        assert!((predicted - row(recording, "test", at)).amax() < 1e-8);
    }
    // M_r by hand: x_r = (cos β, sin β, 0), y_r = y, z_r = (sin γ sin α, sin γ cos α, cos γ), times their
    // scales.
    let (a, b, g) = (25f64.to_radians(), 0.31f64.to_radians(), 0.22f64.to_radians());
    let axes = Matrix3::from_rows(&[
        1.0012 * Vector3::new(b.cos(), b.sin(), 0.0).transpose(),
        0.9985 * Vector3::y().transpose(),
        1.0007 * Vector3::new(g.sin() * a.sin(), g.sin() * a.cos(), g.cos()).transpose(),
    ]);
    let field = axes.try_inverse().expect("an inverse") * row(recording, "reference", 0);
    // At midnight the daily variation and the background are small.
    assert!((field - Vector3::new(20_800.0, 700.0, 47_500.0)).amax() < 40.0, "{field}");
    let x = column(recording, "reference_x_nt");
    let storm = x[18_000..24_000].iter().copied().fold(f64::INFINITY, f64::min);
    assert!((-190.0..-120.0).contains(&(storm - x[17_000])), "{}", storm - x[17_000]);
}

#[test]
fn the_errors_of_resistors_and_voltmeter_are_common_to_the_campaign() {
    let mut exact = exact("magsat");
    exact.facility = plan("magsat").facility;
    let Campaign { document, truth } = simulated(&exact);
    let electrical = truth.electrical.expect("drawn");
    let ohm = electrical.resistor_ohm.z.expect("a resistor");
    assert!(ohm != 5.0 && (ohm / 5.0 - 1.0).abs() < 5e-6 && electrical.voltmeter_offset_v != 0.0);
    for (id, row, current) in [("coil-z", 0, 20_000.0 / 43_000.0), ("sensitivity-x", 50, 0.0)] {
        let volts = current * ohm * (1.0 + electrical.voltmeter_relative) + electrical.voltmeter_offset_v;
        assert!((column(of(&document, id), "coil_z_v")[row] - volts).abs() < 1e-12);
    }
}

#[test]
fn a_missing_column_is_told_from_a_zero() {
    let mut plan = exact("cubesat");
    if let Procedure::FreeRun(run) = plan.procedures.last_mut().expect("a procedure") {
        run.columns.insert("coil_x_a".into(), Column::from(vec![f64::NAN; 180]));
    }
    let document = simulated(&plan).document;
    assert!(column(of(&document, "on-board"), "sensor_x_nt").iter().all(|value| value.is_nan()));
}

fn orbit(plan: &mut Plan) -> &mut OrbitProcedure {
    let Some(Procedure::Orbit(orbit)) = plan.procedures.first_mut() else { panic!("an orbit") };
    orbit
}

#[test]
fn aboard_the_readings_follow_field_and_attitude() {
    let mut plan = exact("orbit");
    orbit(&mut plan).length_s = 12_000.0;
    orbit(&mut plan).known_field = Some(KnownField::default());
    let Campaign { document, truth } = simulated(&plan);
    let run = of(&document, "month");
    let [mu, _] = axes(&truth);
    let mut reached = [false; 3];
    for at in 0..run.rows() {
        let field = row(run, "ambient", at);
        assert!((column(run, "reference_nt")[at] - field.norm()).abs() < 1e-9);
        let [w, x, y, z] = ["w", "x", "y", "z"].map(|part| column(run, &format!("attitude_{part}"))[at]);
        let sen = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)) * field;
        for axis in Axis::ALL {
            let (k, offset) = sensor(&truth, axis);
            let read = k * column(run, &format!("sensor_{axis}_v"))[at] + offset;
            assert!((read - mu.column(axis.index()).dot(&sen)).abs() < 1e-8, "{axis} {at}");
            reached[axis.index()] |= sen[axis.index()].abs() > 0.5 * field.norm();
        }
    }
    assert!(reached[0] && reached[2], "{reached:?}");
    // Errors of model and star sensor are of what is written, not of what is read.
    let noise = Noise { white_rms_nt: Some(5.0), ..Noise::default() };
    orbit(&mut plan).known_field = Some(KnownField { noise, attitude_std_arcsec: 30.0 });
    let written = simulated(&plan).document;
    let other = of(&written, "month");
    for name in ["sensor_x_v", "reference_nt", "sensor_temperature_c"] {
        assert_eq!(column(other, name), column(run, name));
    }
    for (name, range) in [("ambient_y_nt", 3.0..7.0), ("attitude_y", 1e-5..3e-4)] {
        let squares = column(other, name).iter().zip(column(run, name)).map(|(a, b)| (a - b).powi(2));
        let rms = (squares.sum::<f64>() / run.rows() as f64).sqrt();
        assert!(range.contains(&rms), "{name}: {rms}");
    }
    // Neither is written where neither is known.
    let plain = simulated(&exact("orbit")).document;
    let known = |name: &String| name.starts_with("ambient") || name.starts_with("attitude");
    assert!(!of(&plain, "month").columns.keys().any(known));
}
