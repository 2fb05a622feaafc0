//! What is found and said of sensors that are turned in a field.

use common::{Axis, Calibration, Noise, NoiseOfSensors, Quantity, Recording};
use mainfield::Place;
use program::place::AtPlace;
use scalarcal::Options;

use crate::build::{
    Campaign, MAGNITUDE_NT, Turns, change, constants, findings, found, near, run, scalar, told,
};

/// Options of which one is set.
fn with(set: impl FnOnce(&mut Options)) -> Options {
    let mut options = Options::default();
    set(&mut options);
    options
}

#[test]
fn what_is_true_is_found_without_findings() {
    let steady =
        |reference_nt: f64| Campaign { varies: 0.0, rows: 3000, reference_nt, ..Campaign::default() };
    let noisy = Campaign { reference_nt: 480.0, rows: 20_000, ..Campaign::default() };
    // The seed, and whether the noise of the reference may be stated or not.
    let cases = [
        (1, Campaign::default(), &[true][..]),
        (11, steady(0.1), &[true, false]),
        (12, steady(1.0), &[true, false]),
        (13, steady(0.1), &[true, false]),
        (14, noisy, &[true]),
    ];
    for (seed, campaign, ways) in cases {
        for stated in ways {
            let mut document = campaign.document(seed);
            if !stated {
                document.facility = None;
            }
            let document = run(document, &Options::default());
            assert_eq!(findings(&document), "", "{seed} {stated}");
            near(&found(&document), &campaign.truth());
        }
    }
}

#[test]
fn a_biased_reference_is_said_and_fitted() {
    let campaign = Campaign { bias_nt: 20.0, ..Campaign::default() };
    let said = findings(&run(campaign.document(1), &Options::default()));
    assert!(said.contains("the reference reads +"), "{said}");
    let fitted = run(campaign.document(1), &with(|options| options.fit.reference_offset = true));
    near(&found(&fitted), &[campaign.truth().as_slice(), &[20.0]].concat());
    assert_eq!(findings(&fitted), "");
}

/// A place and limits, as options of the command.
#[test]
fn what_is_assumed_is_where_nothing_better_is_known() {
    let at = |latitude_deg: f64| AtPlace {
        place: Some(Place { latitude_deg, longitude_deg: 15.87, height_m: 400.0 }),
        date: Some("2024-03-10".into()),
        field_model: None,
    };
    let placed = with(|options| options.magnitude.at = at(47.93));
    let campaign = Campaign { varies: 0.0, ..Campaign::default() };
    let plain = found(&run(campaign.document(1), &Options::default()));
    // A scalar magnetometer beside the sensors, or in a recording of its own, is better than a place.
    let mut apart = campaign.document(1);
    let mut scalar = apart.recordings[0].clone();
    scalar.id = "scalar".into();
    scalar.columns.retain(|name, _| ["time_s", "reference_nt"].contains(&name.as_str()));
    apart.recordings[0].columns.shift_remove("reference_nt");
    let alone = apart.clone();
    apart.recordings.push(scalar);
    for document in [campaign.document(1), apart] {
        assert_eq!(found(&run(document, &placed))[0].1, plain[0].1);
    }
    // Two days of one place have one common error; a magnitude that is stated stays.
    let mut days = alone.clone();
    days.recordings.push(Recording { id: "later".into(), ..alone.recordings[0].clone() });
    days.recordings[1].conditions.extra.insert("magnitude_nt".into(), 48_000.into());
    days.recordings[1].conditions.extra.insert("field_model".into(), "an earlier day".into());
    let two = run(days, &placed);
    assert!(found(&two)[0].1 > 10.0, "{:?}", found(&two));
    let mut stated = alone.clone();
    stated.recordings[0].conditions.extra.insert("magnitude_nt".into(), 48_000.into());
    let kept = &run(stated, &placed).recordings[0].conditions.extra["magnitude_nt"];
    assert_eq!(kept, &serde_json::json!(48_000));
}

/// Offsets alone: of sensors that are nominal, and of others, whose readings contradict it.
#[test]
fn offsets_alone() {
    let mut only = with(|options| options.assumed.only = Some("offsets".into()));
    only.magnitude.magnitude_nt = Some(MAGNITUDE_NT);
    let nominal = Campaign {
        sensitivity: [6400.0; 3],
        angles: [0.0; 3],
        varies: 0.0,
        turns: Turns::Poor,
        ..Campaign::default()
    };
    let without = |campaign: &Campaign| {
        let mut document = campaign.document(1);
        document.recordings[0].columns.shift_remove("reference_nt");
        document.instrument.get_or_insert_default().nominal_sensitivity_nt_per_v = Some(6400.0);
        document
    };
    let document = run(without(&nominal), &only);
    near(&found(&document)[3..6], &nominal.truth()[3..6]);
    let calibration = document.calibration.as_ref().expect("a calibration");
    let sensor = calibration.sensor(Axis::X).expect("a sensor");
    assert_eq!((&sensor.sensitivity_nt_per_v, sensor.offset_nt.is_some()), (&None, true));
    assert!(calibration.axes.as_ref().is_none_or(|axes| axes.sensors.is_none()));
    let other = Campaign { sensitivity: [6440.0, 6360.0, 6420.0], ..nominal };
    let refused = scalarcal::run(without(&other), &only).expect_err("contradicted").to_string();
    assert!(refused.contains("--scales-within 2 --angles-within 1"), "{refused}");
}

#[test]
fn offsets_that_follow_a_temperature() {
    let campaign = Campaign { per_k: [0.3, -0.3, 0.15], rows: 2000, ..Campaign::default() };
    let said = findings(&run(campaign.document(1), &Options::default()));
    assert!(said.contains("is not constant in time"), "{said}");
    let options = with(|options| options.with = vec![physics::Kind::OffsetTemperature]);
    let document = run(campaign.document(1), &options);
    assert_eq!(findings(&document), "");
    let per_k: Vec<(f64, f64)> = found(&document).into_iter().skip(9).step_by(2).collect();
    assert!(per_k.len() == 3 && per_k.iter().all(|(_, std)| *std < 0.01), "{per_k:?}");
    near(&per_k, &campaign.per_k);
    let effects = &document.model.as_ref().expect("a model").effects;
    assert_eq!(effects.len(), 3);
    // A second run takes what was found off the readings, finds the same sensors, and keeps the effects; one
    // that fits them again finds them again.
    for options in [Options::default(), options] {
        let again = run(document.clone(), &options);
        let [one, other] = [&document, &again].map(|one| constants(one.calibration.as_ref().expect("some")));
        for (a, b) in one.iter().zip(other) {
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
    let refused = scalarcal::run(campaign.document(1), &Options::default());
    assert!(matches!(refused, Err(scalarcal::Error::Unanswerable(_))));
    let message = told(refused);
    assert!(
        message.contains("rotated only about z") && message.contains("with the block turned by"),
        "{message}"
    );
    let good = run(Campaign::default().document(2), &Options::default());
    let mut document = campaign.document(1);
    document.calibration = good.calibration.map(|calibration| Calibration { scalar: None, ..calibration });
    let known = with(|options| options.fit.known = true);
    let document = run(document, &known);
    near(&found(&document), &campaign.truth());
    // A third run would count the same readings twice.
    let message = told(scalarcal::run(document, &known));
    assert!(message.contains("would count twice"), "{message}");
}

#[test]
fn disturbed_rows_are_told_and_weighed_down() {
    let campaign = Campaign::default();
    let mut document = campaign.document(3);
    change(&mut document, "sensor_x_v", |row, value| if row % 50 == 0 { value + 0.02 } else { value });
    assert!(findings(&run(document.clone(), &Options::default())).contains("--robust leaves them out"));
    near(&found(&run(document, &with(|options| options.robust = true))), &campaign.truth());
}

#[test]
fn a_constant_magnitude_needs_a_sensitivity() {
    let mut document = Campaign { varies: 0.0, ..Campaign::default() }.document(4);
    document.recordings[0].columns.shift_remove("reference_nt");
    document.instrument = None;
    let message = told(scalarcal::run(document, &with(|options| options.constant_magnitude = true)));
    assert!(message.contains("neither a sensitivity nor a magnitude"), "{message}");
}

#[test]
fn a_stated_magnitude_gives_the_scale_and_its_uncertainty() {
    let campaign = Campaign { varies: 0.0, ..Campaign::default() };
    let mut document = campaign.document(15);
    let recording = &mut document.recordings[0];
    recording.columns.shift_remove("reference_nt");
    let magnitude = serde_json::json!({"value": 48_000.0, "std": 100.0});
    recording.conditions.extra.insert("magnitude_nt".into(), magnitude);
    let (value, std) = found(&run(document.clone(), &Options::default()))[0];
    assert!((std / value * 48_000.0 / 100.0 - 1.0).abs() < 0.01, "{value} {std}");
    assert!((value / campaign.truth()[0] - 1.0).abs() < 1e-4, "{value}");
    // Beside another reference it would need a scale of its own.
    let mut second = campaign.document(16).recordings.remove(0);
    second.id = "second".into();
    document.recordings.push(second);
    let message = told(scalarcal::run(document, &Options::default()));
    assert!(message.contains("calibrate them one by one"), "{message}");
}

#[test]
fn what_is_known_of_two_sensors_stays() {
    let campaign = Campaign::default();
    let mut document = campaign.document(17);
    document.instrument = None;
    let sensors = document.calibration.get_or_insert_default().sensors.get_or_insert_default();
    for axis in [Axis::X, Axis::Y] {
        let stated = Quantity::new(campaign.sensitivity[axis.index()], 0.05);
        sensors.entry(axis).get_or_insert_default().sensitivity_nt_per_v = Some(stated);
    }
    let document = run(document, &with(|options| options.fit.known = true));
    assert_eq!(findings(&document), "");
    near(&found(&document), &campaign.truth());
}

#[test]
fn a_reference_of_zero_is_a_missing_one() {
    let mut document = Campaign::default().document(18);
    change(&mut document, "reference_nt", |row, value| if row == 100 { 0.0 } else { value });
    let document = run(document, &Options::default());
    assert_eq!((scalar(&document).missing, findings(&document)), (1, String::new()));
}

#[test]
fn declared_flicker_noise_is_that_of_the_fit() {
    let campaign = Campaign { flicker: 0.25, white_nt: 0.1, rows: 400, ..Campaign::default() };
    let mut document = campaign.document(8);
    let noise = Noise { white_rms_nt: Some(0.1), flicker_nt2_per_hz_at_1hz: Some(0.25), ..Noise::default() };
    document.instrument.get_or_insert_default().noise = Some(NoiseOfSensors::Same(noise));
    let document = run(document, &Options::default());
    let noise = &scalar(&document).noise;
    let ratio =
        noise.flicker_nt2_per_hz_at_1hz.expect("flicker") / noise.white_rms_nt.expect("white").powi(2);
    // White noise of a residual is that of sensor and reference, 0.1 nT each.
    assert!((ratio / (0.25 / 0.02) - 1.0).abs() < 1e-9);
    near(&found(&document), &campaign.truth());
}
