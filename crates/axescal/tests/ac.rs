//! AC drive: amplitudes below one code of the converter are found with the dither of the other coils.

use axescal::Options;
use common::Document;
use nalgebra::Matrix3;
use physics::frames::{ARCSEC, angle, matrix};

fn plan() -> simulate::Plan {
    common::parse(&testkit::read_fixture("plans/magsat-axes-ac.json")).expect("a plan")
}

/// Largest angle between the found and the true directions of sensors and coils, arcsec.
fn worst_arcsec(document: &Document, truth: &simulate::Truth) -> f64 {
    let found = document.calibration.as_ref().and_then(|c| c.axes.as_ref()).expect("axes");
    let meant = truth.calibration.axes.as_ref().expect("true axes");
    let pair = |part: fn(&common::AxesCalibration) -> Option<&common::AxesDirections>| -> (Matrix3<f64>, Matrix3<f64>) {
        let of = |axes| matrix(&part(axes).and_then(|directions| directions.matrix).expect("a matrix"));
        (of(found), of(meant))
    };
    [pair(|axes| axes.sensors.as_ref()), pair(|axes| axes.coils.as_ref())]
        .iter()
        .flat_map(|(found, meant)| {
            (0..3).map(|k| angle(&found.column(k).into_owned(), &meant.column(k).into_owned()) / ARCSEC)
        })
        .fold(0.0, f64::max)
}

#[test]
fn signals_below_one_code_are_found_with_dither() {
    // 100 cycles at 0.1 Hz sampled at 100 Hz, codes of 1.92 nT, cross signals of 0.5 to 2 nT: twelve runs of
    // 100 000 rows. Exact theodolites, so that what is seen is what the sine fits lose.
    let mut plan = plan();
    plan.facility = None;
    let with_dither = simulate::campaign(&plan).expect("simulated");
    assert_eq!(with_dither.document.recordings[0].rows(), 100_000);
    let document = axescal::run(with_dither.document, &Options::default()).expect("directions");
    let dithered = worst_arcsec(&document, &with_dither.truth);
    assert!(dithered < 0.5, "{dithered} arcsec with dither");
}

#[test]
fn the_delay_of_a_channel_is_reported_as_a_phase_and_does_no_harm() {
    let mut plan = plan();
    plan.facility = None;
    if let simulate::Procedure::AxesOrientation(axes) = &mut plan.procedures[0] {
        let ac = axes.ac.as_mut().expect("an AC drive");
        (ac.cycles, ac.rate_hz) = (20.0, 20.0);
    }
    let instrument = plan.instrument.as_mut().expect("an instrument");
    instrument.quantisation_v = None;
    let simulate::Campaign { mut document, truth } = simulate::campaign(&plan).expect("simulated");
    // Sensor y answers 10 ms late: its readings are those of an earlier time. A pure sine lets that be made by its phase.
    for recording in &mut document.recordings {
        let column = recording.columns.get_mut("sensor_y_v").expect("a column");
        let phase = std::f64::consts::TAU * 0.1 * 0.010;
        let quarter = 2.5 * 20.0;
        let n = column.0.len();
        let ahead: Vec<f64> = (0..n).map(|row| column.0[(row + n - quarter as usize) % n]).collect();
        column.0 = column
            .0
            .iter()
            .zip(ahead)
            .map(|(now, before)| now * phase.cos() + before * phase.sin())
            .collect();
    }
    let document = axescal::run(document, &Options::default()).expect("directions");
    let axes = document.calibration.as_ref().and_then(|c| c.axes.as_ref()).expect("axes");
    let delays: Vec<(f64, f64)> = axes.phases.iter().map(|phase| (phase.delay_s, phase.p_value)).collect();
    assert!((delays[1].0 - 0.010).abs() < 1e-5 && delays[1].1 < 1e-6, "{delays:?}");
    assert!(delays[0].0.abs() < 1e-5 && delays[0].1 > 1e-4, "{delays:?}");
    assert!(
        axes.findings.iter().any(|finding| finding.contains("sensor y answers") && finding.contains("10.0")),
        "{:?}",
        axes.findings
    );
    assert!(worst_arcsec(&document, &truth) < 1.0);
}
