//! Coverage of the 95 % intervals of all nine parameters. FLUXCAL_CAMPAIGNS sets how many campaigns.

use noise::Stream;
use scalarcal::{Assumed, Options};

use crate::build::{
    Campaign, MAGNITUDE_NT, NAMES, Turns, errors, findings, found, intervals_hold, result, run,
};

/// The interval's share, and what is allowed.
const BAND: [f64; 2] = [0.93, 0.97];
/// Of a stream, whose intervals are the wider of two: they may hold always.
const WIDE: [f64; 2] = [0.93, 1.0];

/// By so many campaigns of each case; in one pass no noise is declared.
fn covered(in_one_pass: bool, cases: impl IntoIterator<Item = (String, Campaign, u64)>) {
    let band = if in_one_pass { WIDE } else { BAND };
    for (name, campaign, usual) in cases {
        let options = Options { constant_magnitude: campaign.wanders.is_some(), ..Options::default() };
        intervals_hold(&name, &NAMES[..9], (usual, band), |seed| {
            let document = result(campaign.document(seed), &options, in_one_pass)
                .unwrap_or_else(|error| panic!("{name}, {seed}: {error}"));
            errors(&found(&document), &campaign.truth())
        });
    }
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
    covered(
        false,
        [
            ("10 ppm, all directions".into(), Campaign::default(), 80),
            ("1 %, all directions".into(), one_percent(Turns::Any), 8),
            ("10 ppm, poor rotations".into(), poor, 12),
            ("1 %, poor rotations".into(), one_percent(Turns::Poor), 8),
        ],
    );
}

#[test]
fn flicker_noise() {
    let cases = [
        ("all directions", Turns::Any, 40),
        ("slow turns", Turns::Slow, 12),
        ("poor rotations", Turns::Poor, 12),
    ];
    covered(
        false,
        cases.map(|(name, turns, usual)| (format!("flicker, {name}"), flicker(turns, 600), usual)),
    );
}

#[test]
fn noise_of_a_stream() {
    covered(true, [("stream, 1 %, poor rotations".into(), one_percent(Turns::Poor), 8)]);
    for turns in [Turns::Any, Turns::Slow, Turns::Poor] {
        let of = |rows: usize| (format!("stream, flicker, {turns:?}, {rows} rows"), flicker(turns, rows), 8);
        covered(true, [600, 6000].map(of));
    }
    for turns in [Turns::Any, Turns::Poor] {
        let campaign = Campaign { turns, rows: 6000, ..Campaign::default() };
        covered(true, [(format!("stream, 10 ppm, {turns:?}, 6000 rows"), campaign, 8)]);
    }
}

/// Turns about the vertical alone, by sensors of which limits are known: where those decide, intervals are wide.
#[test]
fn limits_of_the_sensors() {
    let assumed = Assumed { scales_within: Some(2.0), angles_within: Some(1.0), only: None };
    let options = Options { assumed, ..Options::default() };
    intervals_hold("turns about z, limits", &NAMES[..9], (40, WIDE), |seed| {
        let mut stream = Stream::new(seed, "sensors");
        // The squared length of two normal numbers gives a uniform one.
        let mut uniform = || (-0.5 * (stream.normal().powi(2) + stream.normal().powi(2))).exp();
        let mut within = |limit: f64| [0; 3].map(|_| limit * (2.0 * uniform() - 1.0));
        let turns = if seed.is_multiple_of(2) { Turns::AboutZ } else { Turns::Poor };
        let campaign = Campaign {
            sensitivity: within(0.02).map(|share| 6400.0 * (1.0 + share)),
            angles: within(1_f64.to_radians()),
            offset_nt: within(200.0),
            turns,
            ..Campaign::default()
        };
        let document = run(campaign.document(seed), &options);
        assert!(findings(&document).contains("assumed: scale factors within 2 %, angles"), "{seed}");
        errors(&found(&document), &campaign.truth())
    });
}

/// A field that nobody measured, and that wanders as that of the Earth does.
#[test]
fn unmeasured_field() {
    let slow = Campaign { wanders: Some(0.3), varies: 0.0, turns: Turns::Slow, ..Campaign::default() };
    let any = Campaign { wanders: Some(3.0), varies: 0.0, ..Campaign::default() };
    covered(
        false,
        [
            ("unmeasured field, slow turns".into(), slow, 12),
            ("unmeasured field, all directions".into(), any, 12),
        ],
    );
}
