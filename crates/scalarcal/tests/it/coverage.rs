//! Coverage of the 95 % intervals of all nine parameters. FLUXCAL_CAMPAIGNS sets how many campaigns.

use rayon::prelude::*;
use scalarcal::Options;

use crate::build::{Campaign, MAGNITUDE_NT, Turns, found};

/// The interval's share, and what is allowed.
const BAND: [f64; 2] = [0.93, 0.97];
const NAMES: [&str; 9] = ["k x", "k y", "k z", "O x", "O y", "O z", "xy", "yz", "xz"];

fn covered(name: &str, campaign: &Campaign, usual: u64, band: [f64; 2]) {
    let campaigns = testkit::campaigns(usual);
    let truth = campaign.truth();
    let inside: Vec<[bool; 9]> = (0..campaigns)
        .into_par_iter()
        .map(|seed| {
            let document = scalarcal::run(campaign.document(seed), &Options::default())
                .unwrap_or_else(|error| panic!("{name}, {seed}: {error}"));
            let found = found(&document);
            std::array::from_fn(|k| (found[k].0 - truth[k]).abs() <= 1.96 * found[k].1)
        })
        .collect();
    let shares: Vec<usize> = (0..9).map(|k| inside.iter().filter(|one| one[k]).count()).collect();
    let each: Vec<String> = NAMES
        .iter()
        .zip(&shares)
        .map(|(name, count)| format!("{name} {:.1}", 100.0 * *count as f64 / campaigns as f64))
        .collect();
    println!("{name}: {} % of {campaigns}", each.join(", "));
    for (parameter, count) in NAMES.iter().zip(&shares) {
        assert!(
            testkit::agrees(*count, campaigns as usize, band, 9),
            "{name}, {parameter}: {count} of {campaigns} in their 95 % intervals"
        );
    }
}

#[test]
fn ten_ppm_all_directions() {
    covered("10 ppm, all directions", &Campaign::default(), 80, BAND);
}

#[test]
fn one_percent_all_directions() {
    let noise = Campaign { white_nt: 0.01 * MAGNITUDE_NT, rows: 1500, ..Campaign::default() };
    covered("1 %, all directions", &noise, 8, BAND);
}

#[test]
fn ten_ppm_poor_rotations() {
    covered("10 ppm, poor rotations", &Campaign { turns: Turns::Poor, ..Campaign::default() }, 12, BAND);
}

#[test]
fn one_percent_poor_rotations() {
    let poor =
        Campaign { white_nt: 0.01 * MAGNITUDE_NT, rows: 1500, turns: Turns::Poor, ..Campaign::default() };
    covered("1 %, poor rotations", &poor, 8, BAND);
}

#[test]
fn flicker_noise_slow_turns() {
    let slow =
        Campaign { flicker: 0.25, white_nt: 0.1, turns: Turns::Slow, rows: 600, ..Campaign::default() };
    covered("flicker, slow turns", &slow, 12, BAND);
}

#[test]
fn flicker_noise_all_directions() {
    let any = Campaign { flicker: 0.25, white_nt: 0.1, rows: 600, ..Campaign::default() };
    covered("flicker, all directions", &any, 40, BAND);
}

#[test]
fn flicker_noise_poor_rotations() {
    let poor =
        Campaign { flicker: 0.25, white_nt: 0.1, turns: Turns::Poor, rows: 600, ..Campaign::default() };
    covered("flicker, poor rotations", &poor, 12, BAND);
}
