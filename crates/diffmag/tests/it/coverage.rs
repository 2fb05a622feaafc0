//! Coverage of η, the angles, noise level and clock over simulated pairs, under white and under flicker noise
//! with natural field variation; and how far the source's own intervals fall short. The noise here is
//! periodic over the recording, which no drift is held against: that is in drift.rs. FLUXCAL_CAMPAIGNS sets
//! how many.

use common::{Axis, DifferentialFit};
use nalgebra::Matrix3;
use serde_json::{Value, json};

use crate::answers::{Said, elements, found, holds, outside, over};
use crate::natural::{plan, simulated};

/// The fit, with what is said of the nine parameters that are not known where the five of one of the
/// instruments are known exactly.
fn known(
    name: &str,
    (matrix, scale): (Matrix3<f64>, [f64; 3]),
    campaign: &simulate::Campaign,
    said: &mut Said,
) -> DifferentialFit {
    let pair = campaign.truth.differential.as_ref().expect("two instruments");
    let axes = (0..3).flat_map(|j| [pair.test.phi_deg[j], pair.test.theta_deg[j]]);
    let degrees = [pair.reference.alpha_deg, pair.reference.beta_deg, pair.reference.gamma_deg];
    let degrees = degrees.into_iter().chain(axes);
    let (r, t) = (pair.reference.scale, pair.test.scale);
    let ratios = [t[0] / r[0], r[0] / r[1], r[2] / r[1], t[0] / t[1], t[2] / t[1]];
    let epsilon = |i: usize, j: usize| {
        let cosine = matrix.row(i).dot(&matrix.row(j)) / (matrix.row(i).norm() * matrix.row(j).norm());
        cosine.asin().to_degrees() * 3600.0
    };
    let known = json!({
        "instrument": name,
        "non_orthogonality_arcsec": {"xy": epsilon(0, 1), "yz": epsilon(1, 2), "xz": epsilon(0, 2)},
        "ratio_x_y": scale[0] / scale[1],
        "ratio_z_y": scale[2] / scale[1],
    });
    let mut given = campaign.document.clone();
    given.calibration =
        Some(serde_json::from_value(json!({"differential": {"known": known}})).expect("known"));
    let found = found(&given, false);
    let fourteen = found.fourteen.expect("fourteen");
    assert!(fourteen.numerical_difference_rad < 1e-12, "{}", fourteen.numerical_difference_rad);
    for ((key, angle), value) in fourteen.angles.iter().zip(degrees) {
        if angle.std_arcsec > 0.0 && !fourteen.undetermined.contains(key) {
            let off = 3600.0 * (angle.value_deg - value);
            said.holds(format!("{key} with the {name} known"), off.abs() <= 1.96 * angle.std_arcsec);
        }
    }
    for ((key, ratio), value) in fourteen.ratios.iter().zip(ratios) {
        if ratio.std().is_some_and(|std| std > 1e-12) {
            said.holds(format!("{key} with the {name} known"), holds(ratio, value));
        }
    }
    *found.fit.expect("a fit")
}

fn campaign(noise: &Value, seed: u64) -> Said {
    let mut plan = plan(seed, noise, 3.0);
    // Axes so far from the vertical that they have an azimuth.
    plan["truth"]["differential"]["reference"]["gamma_deg"] = json!(5.0);
    plan["truth"]["differential"]["test"]["theta_deg"][2] = json!(6.0);
    let campaign = simulated(&plan);
    let pair = campaign.truth.differential.as_ref().expect("two instruments");
    let mut said = Said::default();
    let fit = known("reference", (pair.reference_matrix(), pair.reference.scale), &campaign, &mut said);
    known("test", (pair.test.matrix(), pair.test.scale), &campaign, &mut said);
    let truth = pair.calibration().expect("a matrix").matrix.expect("a matrix");
    for (name, i, j) in elements() {
        let element = &fit.elements[&name];
        let plain = (element.least_squares - truth[i][j]).abs();
        let weighted = (element.weighted - truth[i][j]).abs();
        said.holds(format!("{name} weighted"), weighted <= 1.96 * element.weighted_std);
        said.holds(format!("{name} least squares"), plain <= 1.96 * element.std_noise);
        said.holds(format!("{name} as the source has it"), plain <= 1.96 * element.std_independent);
    }
    let white = noise["white_rms_nt"].as_f64().expect("white");
    for axis in Axis::ALL {
        let of = fit.axes.get(axis).expect("an axis");
        said.holds(format!("{axis} white"), holds(&of.white_rms_nt, white));
        if let Some(flicker) = noise["flicker_nt2_per_hz_at_1hz"].as_f64() {
            let density = &of.density_at_1hz_nt_per_sqrt_hz;
            said.holds(format!("{axis} density at 1 Hz"), holds(density, flicker.sqrt()));
        }
    }
    let clock = fit.clock.expect("a clock");
    said.holds("clock offset", holds(&clock.offset_s, 0.0));
    said.holds("clock rate", holds(&clock.rate_ppm, 0.0));
    said
}

fn covers(name: &str, noise: &Value, source_falls_short: bool) {
    let usual = if source_falls_short { 2 } else { 1 };
    let shares = over(name, testkit::campaigns(usual), |seed| campaign(noise, seed));
    let of_source = |key: &str| key.ends_with("as the source has it");
    for (key, (held, tried)) in shares.iter().filter(|(key, _)| source_falls_short && of_source(key)) {
        assert!(*held < 0.9 * *tried as f64, "{key}: {held} of {tried}");
    }
    let outside = outside(&shares, [0.93, 0.97], |key| !of_source(key));
    assert!(outside.is_empty(), "{name}: {}", outside.join(", "));
}

#[test]
fn under_white_noise() {
    covers("white", &json!({"white_rms_nt": 0.1}), false);
}

#[test]
fn under_flicker_noise_where_the_source_falls_short() {
    covers("flicker", &json!({"white_rms_nt": 0.02, "flicker_nt2_per_hz_at_1hz": 1e-3}), true);
}
