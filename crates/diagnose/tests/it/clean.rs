//! Noise: where nothing else is left out, the rate of claims; and noise that is declared wrongly, or not at all, takes no
//! name away.

use common::{Document, Verdict};
use diagnose::Options;
use serde_json::{Value, json};

use crate::bench::{NOISE_NT, Scene, diagnosed, diagnosed_with, named, simulated};

/// FLUXCAL_CAMPAIGNS of them (6), white and with flicker noise up to f^-1.5 in turn, three with their noise
/// declared and three without, temperatures moving throughout.
#[test]
fn clean_recordings_are_not_claimed() {
    let campaigns = testkit::campaigns(6);
    let noises = [
        json!({"white_rms_nt": 0.3}),
        json!({"white_rms_nt": 0.2, "flicker_nt2_per_hz_at_1hz": 0.01, "flicker_exponent": 1.0}),
        json!({"white_rms_nt": 0.1, "flicker_nt2_per_hz_at_1hz": 0.003, "flicker_exponent": 1.5}),
    ];
    let mut claimed = 0;
    for campaign in 0..campaigns {
        let noise = &noises[campaign as usize % noises.len()];
        let mut document = simulated(Scene::Runs, &[], noise, 1000 + campaign);
        if campaign / 3 % 2 == 1 {
            document.instrument.get_or_insert_default().noise = None;
        }
        let (entry, _) = diagnosed_with(document, &Options { seed: campaign, ..Options::default() });
        if entry.verdict != Verdict::Agrees {
            claimed += 1;
            println!("campaign {campaign}: {} {:?}", entry.verdict.word(), entry.reasons);
        }
    }
    println!("{claimed} of {campaigns} claimed");
    // Of few, none; of many, no more than the level of 1 % gives in one run of a hundred.
    assert!(
        testkit::agrees((campaigns - claimed) as usize, campaigns as usize, [0.99, 1.0], 1),
        "{claimed} of {campaigns}"
    );
    assert!(campaigns > 20 || claimed == 0, "{claimed} of {campaigns}");
}

fn is_named(mut document: Document, noise: &Value, name: &str) {
    document.instrument.get_or_insert_default().noise = serde_json::from_value(noise.clone()).expect("noise");
    let (entry, _) = diagnosed(document);
    assert_eq!(
        (entry.verdict, named(&entry)),
        (Verdict::Explained, vec![name]),
        "{noise}: {:?}",
        entry.reasons
    );
}

/// What a declaration is off by counts neither as a difference nor as something that names have to explain.
#[test]
fn noise_that_is_declared_a_tenth_wrong_takes_no_name_away() {
    let bent = json!({"effect": "cubic_nonlinearity", "sensor": "z", "parameters": {"departure_nt": 4.0}});
    let document = simulated(Scene::Runs, &[bent], &json!({"white_rms_nt": NOISE_NT}), 31);
    for factor in [1.0 / 1.1, 1.1] {
        is_named(document.clone(), &json!({"white_rms_nt": factor * NOISE_NT}), "cubic_nonlinearity");
    }
}

/// A slow effect passes for slow noise where noise is estimated from what it left.
#[test]
fn a_slow_effect_is_not_taken_for_noise_that_nobody_declared() {
    let warm = json!({"effect": "warm_up", "sensor": "y", "parameters": {"amplitude_nt": 12.0, "time_constant_s": 9000.0}});
    let document = simulated(Scene::Pair, &[warm], &json!({"white_rms_nt": NOISE_NT}), 32);
    is_named(document, &Value::Null, "warm_up");
}
