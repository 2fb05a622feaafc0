//! Every procedure gives the report's own sequence, and what it reads is what is true.

use common::{Axis, Column, Document, Recording, procedure};
use nalgebra::{Matrix3, Vector3};
use simulate::{Campaign, Plan, Truth};

fn plan(name: &str) -> Plan {
    simulate::Plan::parse(&testkit::read_fixture(&format!("plans/{name}.json"))).expect("a plan")
}

/// The same plan with nothing that is random and nothing that is left out of the first model.
fn exact(name: &str) -> Plan {
    let mut plan = plan(name);
    plan.instrument.as_mut().expect("an instrument").noise = None;
    plan.instrument.as_mut().expect("an instrument").quantisation_v = None;
    plan.instrument.as_mut().expect("an instrument").quantisation_nt = None;
    if let Some(facility) = &mut plan.facility {
        facility.voltmeter = None;
        facility.theodolite_arcsec = None;
        facility.reference_std_nt = None;
        for coil in
            facility.coils.iter_mut().flat_map(|coils| [&mut coils.x, &mut coils.y, &mut coils.z]).flatten()
        {
            coil.resistor_relative_uncertainty = None;
        }
    }
    plan.truth.model = None;
    plan.truth.site = None;
    plan.truth.offset_wander = None;
    if let Some(differential) = &mut plan.truth.differential {
        differential.reference_noise = None;
    }
    plan
}

fn magsat() -> Campaign {
    simulate::campaign(&exact("magsat")).expect("simulated")
}

fn of<'a>(document: &'a Document, id: &str) -> &'a Recording {
    document.recordings.iter().find(|recording| recording.id == id).unwrap_or_else(|| panic!("{id}"))
}

fn column<'a>(recording: &'a Recording, name: &str) -> &'a [f64] {
    recording.column(name).unwrap_or_else(|| panic!("{} has no {name}", recording.id))
}

fn coil(truth: &Truth, axis: Axis) -> (f64, f64) {
    let coil = truth.calibration.coil(axis).expect("a coil");
    (coil.constant_nt_per_a.as_ref().expect("k").value(), coil.offset_nt.as_ref().expect("B0").value())
}

fn sensor(truth: &Truth, axis: Axis) -> (f64, f64) {
    let sensor = truth.calibration.sensor(axis).expect("a sensor");
    (sensor.sensitivity_nt_per_v.as_ref().expect("k").value(), sensor.offset_nt.as_ref().expect("O").value())
}

/// Unit columns of a stated matrix.
fn directions(rows: Option<[[f64; 3]; 3]>) -> Matrix3<f64> {
    let mut matrix = Matrix3::from_fn(|r, c| rows.expect("a matrix")[r][c]);
    for c in 0..3 {
        matrix.column_mut(c).normalize_mut();
    }
    matrix
}

#[test]
fn one_document_holds_every_procedure_of_the_contract() {
    let document = magsat().document;
    let pair = simulate::campaign(&exact("observatory-pair")).expect("simulated").document;
    let cubesat = simulate::campaign(&exact("cubesat")).expect("simulated").document;
    let all: Vec<&str> = [&document, &pair, &cubesat]
        .iter()
        .flat_map(|document| document.recordings.iter().map(|recording| recording.procedure.as_str()))
        .collect();
    for name in [
        procedure::COIL_CONSTANT,
        procedure::COIL_GRADIENT,
        procedure::NULLING_RESIDUAL,
        procedure::SENSOR_SENSITIVITY,
        procedure::SENSOR_OFFSET_REVERSAL,
        procedure::SENSOR_NOISE,
        procedure::OFFSET_DRIFT,
        procedure::TEMPERATURE_RUN,
        procedure::CROSS_FIELD,
        procedure::AXES_ORIENTATION,
        procedure::DIFFERENTIAL,
        procedure::FREE_RUN,
    ] {
        assert!(all.contains(&name), "{name}");
    }
    // What the stages are to find is not stated, and what is true is not told.
    let calibration = document.calibration.as_ref().expect("reference conditions");
    assert!(calibration.coils.is_none() && calibration.sensors.is_none());
    let text = common::to_text(&document);
    for word in ["truth", "shield", "41234.5", "6401.2", "wander", "profile"] {
        assert!(!text.contains(word), "the document tells {word}");
    }
}

#[test]
fn coil_constants_in_steps_over_both_polarities_with_ten_readings() {
    let Campaign { document, truth } = magsat();
    for (id, axis, levels) in [("coil-x", Axis::X, 6), ("coil-y", Axis::Y, 6), ("coil-z", Axis::Z, 9)] {
        let recording = of(&document, id);
        let (volts, read) = (column(recording, &format!("coil_{axis}_v")), column(recording, "reference_nt"));
        assert_eq!(volts.len(), 2 * levels * 10);
        assert!(
            volts[..levels * 10].iter().all(|v| *v > 0.0) && volts[levels * 10..].iter().all(|v| *v < 0.0)
        );
        let (k, b0) = coil(&truth, axis);
        let eta =
            directions(truth.calibration.axes.as_ref().expect("axes").coils.as_ref().expect("coils").matrix);
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
    assert!((positions[0] + 0.4572).abs() < 1e-12 && (positions[69] - 0.4572).abs() < 1e-12);
    assert!((positions[10] - positions[0] - 0.1524).abs() < 1e-12);
    let centre = read[30];
    let profile = truth.coil_profile.as_ref().and_then(|all| all.z.clone()).expect("a profile");
    for (position, read) in positions.iter().zip(read) {
        let expected = 60_030.0 * (profile.at(*position) - 1.0);
        assert!((read - centre - expected).abs() < 1e-3, "{position}: {}", read - centre);
        // NASA: the field does not depart from the centre by more than 0.6 nT over three feet.
        assert!((read - centre).abs() < 0.6);
    }
}

#[test]
fn nulling_in_four_conditions_at_three_rates() {
    let Campaign { document, .. } = magsat();
    let series: Vec<&Recording> =
        document.recordings.iter().filter(|r| r.procedure == procedure::NULLING_RESIDUAL).collect();
    assert_eq!(series.len(), 12);
    for (recording, (rows, step)) in
        series.iter().zip([(5760, 5.0), (7200, 0.5), (7680, 1.0 / 128.0)].iter().cycle())
    {
        let time = column(recording, "time_s");
        assert_eq!(time.len(), *rows);
        assert!((time[1] - time[0] - step).abs() < 1e-9);
        assert!(recording.column("outside_x_nt").is_some() && recording.column("sensor_z_v").is_some());
        let site = recording.conditions.extra["site"].as_str().expect("a site");
        let start = recording.start().expect("a date");
        for t in [time[0], time[rows - 1]] {
            assert_eq!(simulate::Site::at(start.local_s() + t).name(), site, "{}", recording.id);
        }
    }
    let sites: Vec<&str> =
        series.iter().step_by(3).map(|r| r.conditions.extra["site"].as_str().expect("a site")).collect();
    assert_eq!(sites, ["weekday-day", "weekday-night", "weekend-day", "weekend-night"]);
}

#[test]
fn sensitivity_in_101_steps_of_1000_nt() {
    let Campaign { document, truth } = magsat();
    for axis in Axis::ALL {
        let recording = of(&document, &format!("sensitivity-{axis}"));
        let volts = column(recording, "coil_z_v");
        assert_eq!(volts.len(), 101);
        let (kc, b0) = coil(&truth, Axis::Z);
        let (k, o) = sensor(&truth, axis);
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
        let positions = column(recording, "position");
        assert_eq!(positions[..8], [1.0, -1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0]);
        let read = column(recording, &format!("sensor_{axis}_v"));
        let (k, o) = sensor(&truth, axis);
        // O = −k (V₁ + V₂)/2, with the sign that NASA's eq. 26 has wrong.
        for pair in 0..10 {
            let found = -k * (read[2 * pair] + read[2 * pair + 1]) / 2.0;
            assert!((found - o).abs() < 1e-9, "{found} for {o}");
        }
    }
    // Once a week for a year, each sensor; all at their dates.
    let dates: Vec<f64> = document
        .recordings
        .iter()
        .filter(|r| r.procedure == procedure::OFFSET_DRIFT && r.conditions.sensor == Some(Axis::Y))
        .map(|r| r.start().expect("a date").unix_s)
        .collect();
    assert_eq!(dates.len(), 53);
    assert!(dates.windows(2).all(|pair| pair[1] - pair[0] == 604_800.0));
}

#[test]
fn noise_in_three_series_and_offsets_that_wander() {
    let mut plan = exact("magsat");
    plan.truth.offset_wander =
        Some(common::Noise { random_walk_nt_per_sqrt_s: Some(1e-4), ..common::Noise::default() });
    let Campaign { document, truth } = simulate::campaign(&plan).expect("simulated");
    let step = |id: &str| {
        let time = column(of(&document, id), "time_s");
        (time.len(), ((time[1] - time[0]) * 1000.0).round() / 1000.0)
    };
    assert_eq!(
        [step("noise-1"), step("noise-2"), step("noise-3")],
        [(1440, 60.0), (3600, 1.0), (6000, 0.01)]
    );
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
    for (id, moved, still) in [
        ("temperature-sensor-y", "sensor_temperature_c", "electronics_temperature_c"),
        ("temperature-electronics-y", "electronics_temperature_c", "sensor_temperature_c"),
    ] {
        let recording = of(&document, id);
        let mut plateaus: Vec<f64> = column(recording, moved).iter().map(|t| t - 23.0).collect();
        assert_eq!(plateaus.len(), 13 * 11);
        plateaus.dedup();
        assert_eq!(plateaus, [0.0, 5.0, 15.0, 30.0, 15.0, 5.0, 0.0, -5.0, -15.0, -30.0, -15.0, -5.0, 0.0]);
        assert!(column(recording, still).iter().all(|t| *t == 23.0));
        // Half an hour to settle.
        let time = column(recording, "time_s");
        assert!(time[11] - time[10] >= 1800.0 && time[10] - time[9] < 60.0);
    }
    // With readings on the way the enclosure is seen to approach.
    let cubesat = simulate::campaign(&exact("cubesat")).expect("simulated").document;
    let run = of(&cubesat, "temperature-sensor-x");
    let (time, temperature) = (column(run, "time_s"), column(run, "sensor_temperature_c"));
    assert!(time.windows(2).all(|pair| pair[1] - pair[0] <= 61.0));
    assert!(temperature.iter().any(|t| (22.5..36.5).contains(t)));
}

#[test]
fn cross_fields_reach_both_sides_of_the_sensor() {
    let Campaign { document, truth } = magsat();
    let mu =
        directions(truth.calibration.axes.as_ref().expect("axes").sensors.as_ref().expect("sensors").matrix);
    let eta =
        directions(truth.calibration.axes.as_ref().expect("axes").coils.as_ref().expect("coils").matrix);
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
        assert!(
            (levels[11] / 5.0 * 43_000.0 - 60_000.0).abs() < 1e-6 && (levels[22] + levels[11]).abs() < 1e-12
        );
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
    let orientation = |id: &str| {
        let found =
            truth.orientations.iter().find(|o| o.recording == id).expect("an orientation").orientation;
        found.map(|row| row.map(|value| value.round() as i32))
    };
    // Two quarter turns about the azimuth axis, then one about the elevation axis.
    assert_eq!(orientation("axes-2"), [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]);
    assert_eq!(orientation("axes-3"), [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]);
    assert_eq!(orientation("axes-4"), [[1, 0, 0], [0, 0, 1], [0, -1, 0]]);
}

#[test]
fn two_magnetometers_for_a_month_obey_t_is_r_eta_plus_d() {
    let Campaign { document, truth } = simulate::campaign(&exact("observatory-pair")).expect("simulated");
    let recording = of(&document, "month");
    assert_eq!(recording.rows(), 43_200);
    let differential = truth.calibration.differential.as_ref().expect("η and d");
    let eta = Matrix3::from_fn(|r, c| differential.matrix.expect("η")[r][c]);
    let offset = [12.0, -7.5, 21.0];
    let row = |prefix: &str, row: usize| {
        Vector3::from(Axis::ALL.map(|axis| column(recording, &format!("{prefix}_{axis}_nt"))[row]))
    };
    for at in [0, 10_000, 20_000, 43_199] {
        let predicted = eta.transpose() * row("reference", at) + Vector3::from(offset);
        assert!((predicted - row("test", at)).amax() < 1e-8);
    }
    // M_r by hand: x_r = (cos β, sin β, 0), y_r = y, z_r = (sin γ sin α, sin γ cos α, cos γ), times their
    // scales.
    let (a, b, g) = (25f64.to_radians(), 0.31f64.to_radians(), 0.22f64.to_radians());
    let field = Matrix3::new(
        1.0012 * b.cos(),
        1.0012 * b.sin(),
        0.0,
        0.0,
        0.9985,
        0.0,
        1.0007 * g.sin() * a.sin(),
        1.0007 * g.sin() * a.cos(),
        1.0007 * g.cos(),
    )
    .try_inverse()
    .expect("an inverse")
        * row("reference", 0);
    // At midnight the daily variation and the background are small.
    assert!((field - Vector3::new(20_800.0, 700.0, 47_500.0)).amax() < 40.0, "{field}");
    let x = column(recording, "reference_x_nt");
    let storm = x[18_000..24_000].iter().copied().fold(f64::INFINITY, f64::min);
    assert!((-190.0..-120.0).contains(&(storm - x[17_000])), "{}", storm - x[17_000]);
}

#[test]
fn the_errors_of_resistors_and_voltmeter_are_common_to_the_campaign() {
    let mut plan = exact("magsat");
    plan.facility = self::plan("magsat").facility;
    let Campaign { document, truth } = simulate::campaign(&plan).expect("simulated");
    let electrical = truth.electrical.expect("drawn");
    let ohm = electrical.resistor_ohm.z.expect("a resistor");
    assert!(ohm != 5.0 && (ohm / 5.0 - 1.0).abs() < 5e-6 && electrical.voltmeter_offset_v != 0.0);
    let expected =
        |current: f64| current * ohm * (1.0 + electrical.voltmeter_relative) + electrical.voltmeter_offset_v;
    let first = column(of(&document, "coil-z"), "coil_z_v")[0];
    assert!((first - expected(20_000.0 / 43_000.0)).abs() < 1e-12);
    let sweep = column(of(&document, "sensitivity-x"), "coil_z_v")[50];
    assert!((sweep - electrical.voltmeter_offset_v).abs() < 1e-12);
}

#[test]
fn a_missing_column_is_told_from_a_zero() {
    let mut plan = exact("cubesat");
    if let simulate::Procedure::FreeRun(run) = plan.procedures.last_mut().expect("a procedure") {
        run.columns.insert("coil_x_a".into(), Column::from(vec![f64::NAN; 180]));
    }
    let document = simulate::campaign(&plan).expect("simulated").document;
    assert!(column(of(&document, "on-board"), "sensor_x_nt").iter().all(|value| value.is_nan()));
}

#[test]
fn aboard_the_readings_follow_field_and_attitude() {
    let mut plan = exact("orbit");
    let Some(simulate::Procedure::Orbit(orbit)) = plan.procedures.first_mut() else { panic!("an orbit") };
    orbit.length_s = 12_000.0;
    orbit.known_field = Some(simulate::KnownField::default());
    let Campaign { document, truth } = simulate::campaign(&plan).expect("simulated");
    let run = of(&document, "month");
    let mu =
        directions(truth.calibration.axes.as_ref().expect("axes").sensors.as_ref().expect("sensors").matrix);
    let mut reached = [false; 3];
    for row in 0..run.rows() {
        let field = Vector3::from(Axis::ALL.map(|axis| column(run, &format!("ambient_{axis}_nt"))[row]));
        assert!((column(run, "reference_nt")[row] - field.norm()).abs() < 1e-9);
        let part = |name: &str| column(run, &format!("attitude_{name}"))[row];
        let attitude = nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(
            part("w"),
            part("x"),
            part("y"),
            part("z"),
        ));
        let sen = attitude * field;
        for axis in Axis::ALL {
            let (k, offset) = sensor(&truth, axis);
            let read = k * column(run, &format!("sensor_{axis}_v"))[row] + offset;
            assert!((read - mu.column(axis.index()).dot(&sen)).abs() < 1e-8, "{axis} {row}");
            reached[axis.index()] |= sen[axis.index()].abs() > 0.5 * field.norm();
        }
    }
    assert!(reached[0] && reached[2], "{reached:?}");
    // Errors of model and star sensor are of what is written, not of what is read.
    let Some(simulate::Procedure::Orbit(orbit)) = plan.procedures.first_mut() else { panic!("an orbit") };
    let noise = common::Noise { white_rms_nt: Some(5.0), ..common::Noise::default() };
    orbit.known_field = Some(simulate::KnownField { noise, attitude_std_arcsec: 30.0 });
    let written = simulate::campaign(&plan).expect("simulated").document;
    let other = of(&written, "month");
    for name in ["sensor_x_v", "reference_nt", "sensor_temperature_c"] {
        assert_eq!(column(other, name), column(run, name));
    }
    let off = |name: &str| {
        let squares = column(other, name).iter().zip(column(run, name)).map(|(a, b)| (a - b).powi(2));
        (squares.sum::<f64>() / run.rows() as f64).sqrt()
    };
    assert!((3.0..7.0).contains(&off("ambient_y_nt")), "{}", off("ambient_y_nt"));
    assert!((1e-5..3e-4).contains(&off("attitude_y")), "{}", off("attitude_y"));
    // Neither is written where neither is known.
    let plain = simulate::campaign(&exact("orbit")).expect("simulated").document;
    let names: Vec<&String> = of(&plain, "month").columns.keys().collect();
    assert!(
        names.iter().all(|name| !name.starts_with("ambient") && !name.starts_with("attitude")),
        "{names:?}"
    );
}
