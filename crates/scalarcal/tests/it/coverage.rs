//! Coverage of the 95 % intervals of all nine parameters. FLUXCAL_CAMPAIGNS sets how many campaigns.

use common::Document;
use scalarcal::{Options, stream};

use crate::build::{Campaign, MAGNITUDE_NT, NAMES, Turns, found, intervals_hold, piece};

/// The interval's share, and what is allowed.
const BAND: [f64; 2] = [0.93, 0.97];
/// Of a stream, whose intervals are the wider of two: they may hold always.
const WIDE: [f64; 2] = [0.93, 1.0];

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
    let truth = campaign.truth();
    intervals_hold(name, &NAMES[..9], (usual, band), |seed| {
        let document = run(campaign.document(seed)).unwrap_or_else(|error| panic!("{name}, {seed}: {error}"));
        found(&document).iter().zip(truth).map(|((value, std), truth)| (value - truth, *std)).collect()
    });
}

/// Noise of 1 % of the magnitude.
fn one_percent(turns: Turns) -> Campaign {
    Campaign { white_nt: 0.01 * MAGNITUDE_NT, rows: 1500, turns, ..Campaign::default() }
}

fn flicker(turns: Turns, rows: usize) -> Campaign {
    Campaign { flicker: 0.25, white_nt: 0.1, turns, rows, ..Campaign::default() }
}

#[test]
fn white_noise() {
    let poor = Campaign { turns: Turns::Poor, ..Campaign::default() };
    covered("10 ppm, all directions", &Campaign::default(), 80, BAND);
    covered("1 %, all directions", &one_percent(Turns::Any), 8, BAND);
    covered("10 ppm, poor rotations", &poor, 12, BAND);
    covered("1 %, poor rotations", &one_percent(Turns::Poor), 8, BAND);
}

#[test]
fn flicker_noise() {
    covered("flicker, all directions", &flicker(Turns::Any, 600), 40, BAND);
    covered("flicker, slow turns", &flicker(Turns::Slow, 600), 12, BAND);
    covered("flicker, poor rotations", &flicker(Turns::Poor, 600), 12, BAND);
}

#[test]
fn white_noise_of_a_stream() {
    covered_in_a_stream("stream, 1 %, poor rotations", &one_percent(Turns::Poor), 8, WIDE);
    for (name, turns) in [("all directions", Turns::Any), ("poor rotations", Turns::Poor)] {
        let one = Campaign { turns, rows: 6000, ..Campaign::default() };
        covered_in_a_stream(&format!("stream, 10 ppm, {name}, 6000 rows"), &one, 8, WIDE);
    }
}

#[test]
fn flicker_noise_of_a_stream() {
    let ways = [("all directions", Turns::Any), ("slow turns", Turns::Slow), ("poor rotations", Turns::Poor)];
    for (name, turns) in ways {
        for rows in [600, 6000] {
            let name = format!("stream, flicker, {name}, {rows} rows");
            covered_in_a_stream(&name, &flicker(turns, rows), 8, WIDE);
        }
    }
}

/// A field that nobody measured, and that wanders as that of the Earth does.
#[test]
fn unmeasured_field() {
    let slow = Campaign { wanders: Some(0.3), varies: 0.0, turns: Turns::Slow, ..Campaign::default() };
    covered("unmeasured field, slow turns", &slow, 12, BAND);
    let any = Campaign { wanders: Some(3.0), varies: 0.0, ..Campaign::default() };
    covered("unmeasured field, all directions", &any, 12, BAND);
}
