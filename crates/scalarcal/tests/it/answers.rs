//! What is found and said of sensors that are turned in a field.

use common::{Axis, Document};
use scalarcal::{Error, Options};

use crate::build::{Campaign, Turns, constants, found};

fn run(document: Document, options: &Options) -> Document {
    scalarcal::run(document, options).unwrap_or_else(|error| panic!("{error}"))
}

fn findings(document: &Document) -> String {
    let scalar = document.calibration.as_ref().and_then(|c| c.scalar.as_ref()).expect("a calibration");
    scalar.findings.join("\n")
}

#[test]
fn a_clean_recording_has_no_findings() {
    let campaign = Campaign::default();
    let document = run(campaign.document(1), &Options::default());
    assert_eq!(findings(&document), "");
    for ((value, std), truth) in found(&document).iter().zip(campaign.truth()) {
        assert!((value - truth).abs() < 4.0 * std, "{value} {std} {truth}");
    }
}

#[test]
fn a_biased_reference_is_said_and_fitted() {
    let campaign = Campaign { bias_nt: 20.0, ..Campaign::default() };
    let document = run(campaign.document(1), &Options::default());
    assert!(findings(&document).contains("the reference reads +"), "{}", findings(&document));
    let fitted = run(campaign.document(1), &Options { reference_offset: true, ..Options::default() });
    let all = found(&fitted);
    for ((value, std), truth) in all.iter().zip(campaign.truth().iter().chain(&[20.0])) {
        assert!((value - truth).abs() < 4.0 * std, "{value} {std} {truth}");
    }
    assert_eq!(findings(&fitted), "");
}

#[test]
fn offsets_that_follow_a_temperature() {
    let campaign = Campaign { per_k: [0.3, -0.3, 0.15], rows: 2000, ..Campaign::default() };
    let plain = run(campaign.document(1), &Options::default());
    assert!(findings(&plain).contains("is not constant in time"), "{}", findings(&plain));
    let options = Options { with: vec![physics::Kind::OffsetTemperature], ..Options::default() };
    let document = run(campaign.document(1), &options);
    assert_eq!(findings(&document), "");
    let all = found(&document);
    for (number, truth) in campaign.per_k.iter().enumerate() {
        let (value, std) = all[9 + 2 * number];
        assert!((value - truth).abs() < 4.0 * std && std < 0.01, "{value} {std} {truth}");
    }
    let effects = &document.model.as_ref().expect("a model").effects;
    assert_eq!(effects.len(), 3);
    // A second run takes what was found off the readings, finds the same sensors, and keeps the effects; one
    // that fits them again finds them again.
    for options in [Options::default(), options] {
        let again = run(document.clone(), &options);
        for (a, b) in constants(&document).iter().zip(constants(&again)) {
            assert!((a - b).abs() < 1e-3, "{a} {b}");
        }
        let effects_again = &again.model.as_ref().expect("a model").effects;
        assert_eq!(effects_again.len(), 3);
        for (a, b) in effects.iter().zip(effects_again) {
            let [a, b] = [a, b].map(|effect| effect.parameters["coefficient_nt_per_k"].value());
            assert!((a - b).abs() < 1e-4, "{a} {b}");
        }
    }
}

#[test]
fn rotations_about_one_axis_are_told_and_a_known_calibration_helps() {
    let campaign = Campaign { turns: Turns::AboutZ, ..Campaign::default() };
    let message = match scalarcal::run(campaign.document(1), &Options::default()) {
        Err(Error::Unanswerable(message)) => message,
        other => panic!("{:?}", other.map(|document| findings(&document))),
    };
    assert!(
        message.contains("rotated only about z") && message.contains("with the block turned by"),
        "{message}"
    );
    let good = run(Campaign::default().document(2), &Options::default());
    let mut document = campaign.document(1);
    document.calibration.clone_from(&good.calibration);
    if let Some(calibration) = &mut document.calibration {
        calibration.scalar = None;
    }
    let document = run(document, &Options { known: true, ..Options::default() });
    for ((value, std), truth) in found(&document).iter().zip(campaign.truth()) {
        assert!((value - truth).abs() < 4.0 * std, "{value} {std} {truth}");
    }
    // A third run would count the same readings twice.
    let message = scalarcal::run(document, &Options { known: true, ..Options::default() })
        .expect_err("refused")
        .to_string();
    assert!(message.contains("would count twice"), "{message}");
}

#[test]
fn disturbed_rows_are_told_and_weighed_down() {
    let campaign = Campaign::default();
    let mut document = campaign.document(3);
    let column = document.recordings[0].columns.get_mut("sensor_x_v").expect("x");
    let mut values = column.to_vec();
    values.iter_mut().step_by(50).for_each(|value| *value += 0.02);
    *column = values.into();
    assert!(findings(&run(document.clone(), &Options::default())).contains("--robust leaves them out"));
    let robust = run(document, &Options { robust: true, ..Options::default() });
    for ((value, std), truth) in found(&robust).iter().zip(campaign.truth()) {
        assert!((value - truth).abs() < 4.0 * std, "{value} {std} {truth}");
    }
}

#[test]
fn a_constant_magnitude_that_is_not_known_gives_relative_sensitivities() {
    let campaign = Campaign { varies: 0.0, ..Campaign::default() };
    let mut document = campaign.document(4);
    document.recordings[0].columns.shift_remove("reference_nt");
    let message =
        scalarcal::run(document.clone(), &Options::default()).expect_err("no reference").to_string();
    assert!(message.contains("--constant-magnitude"), "{message}");
    let document = run(document, &Options { constant_magnitude: true, ..Options::default() });
    assert!(findings(&document).contains("only ratios of the sensitivities are observable"));
    let truth = campaign.truth();
    let all = found(&document);
    let ratio = (all[0].0 / all[1].0) / (truth[0] / truth[1]) - 1.0;
    assert!(ratio.abs() < 1e-5, "{ratio}");
    for place in 3..9 {
        assert!((all[place].0 - truth[place]).abs() < 4.0 * all[place].1, "{place}");
    }
}

#[test]
fn a_steady_field_raises_no_finding() {
    for (seed, reference_nt) in [(11, 0.1), (12, 1.0), (13, 0.1)] {
        let campaign = Campaign { varies: 0.0, rows: 3000, reference_nt, ..Campaign::default() };
        for stated in [true, false] {
            let mut document = campaign.document(seed);
            if !stated {
                document.facility = None;
            }
            let document = run(document, &Options::default());
            assert_eq!(findings(&document), "", "{seed} {stated}");
            for ((value, std), truth) in found(&document).iter().zip(campaign.truth()) {
                assert!((value - truth).abs() < 4.0 * std, "{value} {std} {truth}");
            }
        }
    }
}

#[test]
fn noise_of_the_reference_does_not_bias() {
    let campaign = Campaign { reference_nt: 480.0, rows: 20_000, ..Campaign::default() };
    let document = run(campaign.document(14), &Options::default());
    assert_eq!(findings(&document), "");
    for ((value, std), truth) in found(&document).iter().zip(campaign.truth()) {
        assert!((value - truth).abs() < 4.0 * std, "{value} {std} {truth}");
    }
}

#[test]
fn a_stated_magnitude_gives_the_scale_and_its_uncertainty() {
    let campaign = Campaign { varies: 0.0, ..Campaign::default() };
    let stated = |std: f64| {
        let mut document = campaign.document(15);
        let recording = &mut document.recordings[0];
        recording.columns.shift_remove("reference_nt");
        let magnitude = serde_json::json!({"value": 48_000.0, "std": std});
        recording.conditions.extra.insert("magnitude_nt".into(), magnitude);
        document
    };
    let document = run(stated(100.0), &Options::default());
    let (value, std) = found(&document)[0];
    assert!((std / value * 48_000.0 / 100.0 - 1.0).abs() < 0.01, "{value} {std}");
    assert!((value / campaign.truth()[0] - 1.0).abs() < 1e-4, "{value}");
    // Beside another reference it would need a scale of its own.
    let mut both = stated(100.0);
    let mut second = campaign.document(16).recordings.remove(0);
    second.id = "second".into();
    both.recordings.push(second);
    let message = scalarcal::run(both, &Options::default()).expect_err("two scales").to_string();
    assert!(message.contains("calibrate them one by one"), "{message}");
}

#[test]
fn what_is_known_of_two_sensors_stays() {
    let campaign = Campaign::default();
    let mut document = campaign.document(17);
    document.instrument = None;
    let sensors = document.calibration.get_or_insert_default().sensors.get_or_insert_default();
    for axis in [Axis::X, Axis::Y] {
        let stated = common::Quantity::new(campaign.sensitivity[axis.index()], 0.05);
        sensors.entry(axis).get_or_insert_default().sensitivity_nt_per_v = Some(stated);
    }
    let document = run(document, &Options { known: true, ..Options::default() });
    assert_eq!(findings(&document), "");
    for ((value, std), truth) in found(&document).iter().zip(campaign.truth()) {
        assert!((value - truth).abs() < 4.0 * std, "{value} {std} {truth}");
    }
}

#[test]
fn a_reference_of_zero_is_a_missing_one() {
    let campaign = Campaign::default();
    let mut document = campaign.document(18);
    let column = document.recordings[0].columns.get_mut("reference_nt").expect("a reference");
    let mut values = column.to_vec();
    values[100] = 0.0;
    *column = values.into();
    let document = run(document, &Options::default());
    let scalar = document.calibration.as_ref().and_then(|c| c.scalar.as_ref()).expect("a calibration");
    assert_eq!((scalar.missing, findings(&document)), (1, String::new()));
}

#[test]
fn a_scale_that_nothing_gives_is_refused() {
    let mut document = Campaign { varies: 0.0, ..Campaign::default() }.document(4);
    document.recordings[0].columns.shift_remove("reference_nt");
    document.instrument = None;
    let options = Options { constant_magnitude: true, ..Options::default() };
    let message = scalarcal::run(document, &options).expect_err("no scale").to_string();
    assert!(message.contains("neither a sensitivity nor a magnitude"), "{message}");
}

#[test]
fn declared_flicker_noise_is_that_of_the_fit() {
    let campaign = Campaign { flicker: 0.25, white_nt: 0.1, rows: 400, ..Campaign::default() };
    let mut document = campaign.document(8);
    let noise = r#"{"white_rms_nt": 0.1, "flicker_nt2_per_hz_at_1hz": 0.25, "flicker_exponent": 1.0}"#;
    document.instrument.as_mut().expect("an instrument").noise =
        Some(serde_json::from_str(noise).expect("a noise"));
    let document = run(document, &Options::default());
    let scalar = document.calibration.as_ref().and_then(|c| c.scalar.as_ref()).expect("a calibration");
    let ratio = |noise: &common::Noise| {
        noise.flicker_nt2_per_hz_at_1hz.expect("flicker") / noise.white_rms_nt.expect("white").powi(2)
    };
    // White noise of a residual is that of sensor and reference, 0.1 nT each.
    assert!((ratio(&scalar.noise) / (0.25 / 0.02) - 1.0).abs() < 1e-9);
    for ((value, std), truth) in found(&document).iter().zip(campaign.truth()) {
        assert!((value - truth).abs() < 4.0 * std, "{value} {std} {truth}");
    }
}

#[test]
fn saturated_rows_are_left_out() {
    let campaign = Campaign { rows: 3000, ..Campaign::default() };
    let mut document = campaign.document(5);
    let column = document.recordings[0].columns.get_mut("sensor_z_v").expect("z");
    let values: Vec<f64> = column.iter().map(|value| value.clamp(-7.0, 7.0)).collect();
    *column = values.into();
    let document = run(document, &Options::default());
    let scalar = document.calibration.as_ref().and_then(|c| c.scalar.as_ref()).expect("a calibration");
    assert!(scalar.left_out.contains_key("sensor z at the end of its range"));
    for ((value, std), truth) in found(&document).iter().zip(campaign.truth()) {
        assert!((value - truth).abs() < 4.0 * std, "{value} {std} {truth}");
    }
}

#[test]
fn constants_are_as_uncertain_as_their_sources_say() {
    let document = run(Campaign::default().document(6), &Options::default());
    let calibration = document.calibration.as_ref().expect("a calibration");
    let joint = calibration.uncertainty.as_ref().expect("sources");
    for axis in Axis::ALL {
        let sensor = calibration.sensor(axis).expect("a sensor");
        let k = sensor.sensitivity_nt_per_v.as_ref().expect("k");
        let std = joint.std(&common::uncertainty::sensitivity(axis, "v"));
        assert!((k.std().expect("a std") / std - 1.0).abs() < 1e-9);
        assert!(k.coverage_factor_95().expect("a factor") > 1.95);
    }
}
