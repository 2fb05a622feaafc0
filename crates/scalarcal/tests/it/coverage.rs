//! Coverage of the 95 % intervals of all nine parameters. FLUXCAL_CAMPAIGNS sets how many campaigns.

use common::Document;
use rayon::prelude::*;
use scalarcal::{Options, stream};

use crate::build::{Campaign, MAGNITUDE_NT, Turns, found, piece};

/// The interval's share, and what is allowed.
const BAND: [f64; 2] = [0.93, 0.97];
/// Of a stream, whose intervals are the wider of two: they may hold always.
const WIDE: [f64; 2] = [0.93, 1.0];
const NAMES: [&str; 9] = ["k x", "k y", "k z", "O x", "O y", "O z", "xy", "yz", "xz"];

fn covered(name: &str, campaign: &Campaign, usual: u64, band: [f64; 2]) {
    let options = Options { constant_magnitude: campaign.wanders.is_some(), ..Options::default() };
    let run = |document: Document| scalarcal::run(document, &options);
    covered_by(name, campaign, usual, band, run);
}

/// The same in one pass; no noise is declared.
fn covered_in_a_stream(name: &str, campaign: &Campaign, usual: u64, band: [f64; 2]) {
    let run = |document: Document| {
        let rows = 0..document.recordings[0].rows();
        stream::document(&piece(&document, rows), document, &Options::default())
    };
    covered_by(name, campaign, usual, band, run);
}

fn covered_by(
    name: &str,
    campaign: &Campaign,
    usual: u64,
    band: [f64; 2],
    run: impl Fn(Document) -> Result<Document, scalarcal::Error> + Sync,
) {
    let campaigns = testkit::campaigns(usual);
    let truth = campaign.truth();
    let inside: Vec<[bool; 9]> = (0..campaigns)
        .into_par_iter()
        .map(|seed| {
            let document =
                run(campaign.document(seed)).unwrap_or_else(|error| panic!("{name}, {seed}: {error}"));
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

#[test]
fn stream_one_percent_poor_rotations() {
    let poor =
        Campaign { white_nt: 0.01 * MAGNITUDE_NT, rows: 1500, turns: Turns::Poor, ..Campaign::default() };
    covered_in_a_stream("stream, 1 %, poor rotations", &poor, 8, WIDE);
}

#[test]
fn stream_white_noise() {
    for (name, turns) in [("all directions", Turns::Any), ("poor rotations", Turns::Poor)] {
        let one = Campaign { turns, rows: 6000, ..Campaign::default() };
        covered_in_a_stream(&format!("stream, 10 ppm, {name}, 6000 rows"), &one, 8, WIDE);
    }
}

fn stream_flicker(name: &str, turns: Turns) {
    for rows in [600, 6000] {
        let one = Campaign { flicker: 0.25, white_nt: 0.1, turns, rows, ..Campaign::default() };
        covered_in_a_stream(&format!("stream, flicker, {name}, {rows} rows"), &one, 8, WIDE);
    }
}

#[test]
fn stream_flicker_all_directions() {
    stream_flicker("all directions", Turns::Any);
}

#[test]
fn stream_flicker_slow_turns() {
    stream_flicker("slow turns", Turns::Slow);
}

#[test]
fn stream_flicker_poor_rotations() {
    stream_flicker("poor rotations", Turns::Poor);
}

/// A field that nobody measured, and that wanders as that of the Earth does.
#[test]
fn unmeasured_field_slow_turns() {
    let slow = Campaign { wanders: Some(0.3), varies: 0.0, turns: Turns::Slow, ..Campaign::default() };
    covered("unmeasured field, slow turns", &slow, 12, BAND);
}

#[test]
fn unmeasured_field_all_directions() {
    let any = Campaign { wanders: Some(3.0), varies: 0.0, ..Campaign::default() };
    covered("unmeasured field, all directions", &any, 12, BAND);
}
