//! The iron of the body on which the sensors are mounted, apart from their calibration (FLUXCAL_CAMPAIGNS).

use common::{Axis, BodyIron, Document};
use nalgebra::{Matrix3, Vector3};
use scalarcal::{FitOptions, Options};

use crate::build::{Campaign, errors, findings, found, intervals_hold, near, run, scalar, told};

fn on_body() -> Campaign {
    Campaign {
        soft: Matrix3::new(0.004, -0.0012, 0.0005, -0.0012, -0.0021, 0.0008, 0.0005, 0.0008, 0.0033),
        hard_nt: Vector3::new(310.0, -120.0, 45.0),
        ..Campaign::default()
    }
}

/// One recording, and whether the sensors are on the body.
fn recorded(campaign: &Campaign, seed: u64, mounted: Option<bool>) -> Document {
    let mut document = campaign.document(seed);
    document.recordings[0].id = format!("{mounted:?}");
    document.recordings[0].conditions.mounted = mounted;
    document
}

/// Away from the body, then on it.
fn both(campaign: &Campaign, seed: u64) -> Document {
    let mut document = recorded(&Campaign::default(), 2 * seed, Some(false));
    document.recordings.extend(recorded(campaign, 2 * seed + 1, Some(true)).recordings);
    document
}

/// Values and standard uncertainties in the order of [`truth`].
fn iron(document: &Document) -> Vec<(f64, f64)> {
    let BodyIron { hard_iron_nt, soft_iron_ppm, .. } = scalar(document).body.as_ref().expect("a body");
    let hard = Axis::ALL.map(|axis| hard_iron_nt.get(axis).expect("a component").clone());
    hard.iter().chain(soft_iron_ppm.values()).map(|one| (one.value(), one.std().expect("a std"))).collect()
}

fn truth(campaign: &Campaign) -> Vec<f64> {
    let soft = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)].map(|place| 1e6 * campaign.soft[place]);
    campaign.hard_nt.iter().copied().chain(soft).collect()
}

/// SEN is nearest to the sensors' nominal axes, the campaign's frame has x along x: the iron turned there.
fn turned(campaign: &Campaign) -> Campaign {
    let mu = campaign.mu();
    let root = (mu.transpose() * mu).symmetric_eigen();
    let lengths = Matrix3::from_diagonal(&root.eigenvalues.map(f64::sqrt));
    let nearest = root.eigenvectors * lengths * root.eigenvectors.transpose();
    let turn = nearest * mu.try_inverse().expect("axes");
    Campaign {
        soft: turn * campaign.soft * turn.transpose(),
        hard_nt: turn * campaign.hard_nt,
        ..campaign.clone()
    }
}

#[test]
fn intervals_of_the_iron_hold() {
    let truth = truth(&turned(&on_body()));
    let of = |seed: u64| {
        let document = run(both(&on_body(), seed), &Options::default());
        assert!(scalar(&document).includes_body);
        errors(&iron(&document), &truth)
    };
    let names = ["x", "y", "z", "xx", "yy", "zz", "xy", "yz", "xz"];
    intervals_hold("iron", &names, (12, [0.93, 0.97]), of);
}

#[test]
fn a_body_without_iron_shows_none() {
    let body = scalar(&run(both(&Campaign::default(), 3), &Options::default())).body.clone().expect("a body");
    assert!(body.p_value > 1e-3 && body.degrees_of_freedom == 9.0, "{body:?}");
    let with_iron = run(both(&on_body(), 3), &Options::default());
    assert_eq!(findings(&with_iron), "");
    let body = scalar(&with_iron).body.clone().expect("a body");
    assert!(body.p_value < 1e-9, "{body:?}");
}

#[test]
fn the_calibration_is_that_on_the_body() {
    let together = run(both(&on_body(), 4), &Options::default());
    let alone = run(recorded(&on_body(), 9, Some(true)), &Options::default());
    for ((a, std), (b, _)) in found(&together).iter().zip(found(&alone)) {
        assert!((a - b).abs() < 0.1 * std, "{a} {b} {std}");
    }
    assert_eq!(scalar(&together).recordings, ["Some(true)"]);
    let told = findings(&alone);
    assert!(told.contains("include the iron of the body") && told.contains("mounted: false"), "{told}");
}

#[test]
fn their_own_calibration_may_be_known_beforehand() {
    let fit = FitOptions { known: true, ..FitOptions::default() };
    let known = Options { fit, ..Options::default() };
    let away = run(recorded(&Campaign::default(), 10, Some(false)), &Options::default());
    assert!(!scalar(&away).includes_body);
    let mut document = recorded(&on_body(), 11, Some(true));
    document.calibration.clone_from(&away.calibration);
    let document = run(document, &known);
    near(&iron(&document), &truth(&turned(&on_body())));
    let alone = recorded(&on_body(), 11, Some(true));
    let message = told(scalarcal::run(alone, &known));
    assert!(message.contains("no calibration of all three sensors"), "{message}");
}
