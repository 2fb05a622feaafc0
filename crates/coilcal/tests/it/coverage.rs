//! Coverage of k and B0, resistor and voltmeter erring once a campaign (FLUXCAL_CAMPAIGNS sets how many).

use common::{Axis, Budget, Document, Quantity};
use noise::Stream;
use serde_json::{Value, json};

use crate::build::{calibrated, simulated};

/// Four readings of each level, in so many visits.
fn plan(seed: u64, visits: u64) -> Value {
    json!({
        "fluxcal": 1,
        "seed": seed,
        "facility": {
            "coils": {"z": {"resistor_ohm": 5.0, "resistor_relative_uncertainty": 2e-6, "max_nt": 60000}},
            "voltmeter": {"absolute_v": 2e-5, "relative": 1e-6}, "reference_std_nt": 0.5, "reference_range_nt": [15000, 65000]},
        "calibration": {"coils": {"z": {"constant_nt_per_a": 43000}}},
        "unstated": ["coils"],
        "drive": "voltage",
        "truth": {"calibration": {"coils": {"z": {"constant_nt_per_a": 43021.9, "offset_nt": 0.7}}}},
        "procedures": (0..visits).map(|visit| json!({
            "procedure": "coil_constant", "id": format!("coil-{visit}"), "coil": "z", "repeats": 4 / visits
        })).collect::<Vec<_>>()
    })
}

/// What shares an error of the site's field.
#[derive(Clone, Copy, Debug)]
enum Shared {
    /// The readings of one drive.
    Drive,
    /// Those of all drives with the same current.
    Level,
}

/// Adds a normal variate to the field of each drive, or of each level.
fn disturb(document: &mut Document, std_nt: f64, shared: Shared, seed: u64) {
    let mut draw = Stream::new(seed, "site");
    let mut of_levels: Vec<(f64, f64)> = Vec::new();
    for recording in &mut document.recordings {
        let drive = recording.column("coil_z_v").expect("the drive").to_vec();
        let mut site = 0.0;
        let mut reference = recording.column("reference_nt").expect("the reference").to_vec();
        for row in 0..reference.len() {
            if row == 0 || (drive[row] - drive[row - 1]).abs() > 1e-4 {
                let before = of_levels.iter().find(|(level, _)| (level - drive[row]).abs() < 1e-2);
                site = match (shared, before) {
                    (Shared::Level, Some((_, site))) => *site,
                    _ => std_nt * draw.normal(),
                };
                of_levels.push((drive[row], site));
            }
            reference[row] += site;
        }
        recording.columns.insert("reference_nt".into(), reference.into());
    }
}

/// Asserts that intervals cover where the site's field changes by so much from one drive to the next.
fn covers(site_nt: f64, shared: Shared, alone_falls_short: bool) {
    let count = testkit::campaigns(200) as usize;
    let visits = match shared {
        Shared::Drive => 1,
        Shared::Level => 2,
    };
    // For constant and offset: covered by the joint uncertainty, covered by type A alone.
    let mut covered = [[0; 2]; 2];
    for seed in 0..count as u64 {
        let mut document = simulated(&plan(seed, visits));
        disturb(&mut document, site_nt, shared, seed);
        let found = calibrated(document);
        let coil = found.coil(Axis::Z).expect("coil z");
        let fit = coil.constant.as_ref().expect("a fit");
        let values =
            [(&coil.constant_nt_per_a, "constant_nt_per_a", 43021.9), (&coil.offset_nt, "offset_nt", 0.7)];
        for (number, (quantity, key, truth)) in values.into_iter().enumerate() {
            let quantity: &Quantity = quantity.as_ref().expect("a quantity");
            let Budget { type_a, type_b } = fit.uncertainty[key];
            let (std, factor) =
                (quantity.std().expect("a std"), quantity.coverage_factor_95().expect("a factor"));
            assert!((std - type_a.hypot(type_b)).abs() < 1e-12 * std && type_b > 0.0);
            let missed = (quantity.value() - truth).abs();
            covered[number][0] += usize::from(missed <= factor * std);
            covered[number][1] += usize::from(missed <= factor * type_a);
        }
    }
    for (key, [joint, alone]) in ["constant", "offset"].iter().zip(covered) {
        let percent = |covered: usize| 100.0 * covered as f64 / count as f64;
        println!(
            "site {site_nt} nT by {shared:?}, {key}: {:.1} % of {count}, without the common errors {:.1} %",
            percent(joint),
            percent(alone)
        );
        assert!(testkit::agrees(joint, count, [0.93, 0.97], 2), "{key}: {joint} of {count}");
        assert!(!alone_falls_short || percent(alone) < 90.0, "{key}: {alone} of {count}");
    }
}

#[test]
fn intervals_cover_and_would_not_without_the_common_errors() {
    covers(0.0, Shared::Drive, true);
}

#[test]
fn intervals_cover_where_readings_of_one_drive_share_the_site_s_field() {
    [0.2, 0.5, 2.0].into_iter().for_each(|site_nt| covers(site_nt, Shared::Drive, false));
}

#[test]
fn intervals_cover_where_all_readings_of_a_level_err_together() {
    [0.2, 0.5, 2.0].into_iter().for_each(|site_nt| covers(site_nt, Shared::Level, false));
}
