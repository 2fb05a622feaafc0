//! Coverage of the intervals of what is named: every effect of the catalogue by turns, at sizes from 0.3 to
//! 10 times the noise, in recordings of their own seeds. FLUXCAL_CAMPAIGNS sets how many, FLUXCAL_FIRST with
//! which to begin.

use common::{Diagnosis, Quantity, Verdict};
use serde_json::{Value, json};
use std::collections::BTreeMap;

use crate::bench::{diagnosed, noise, scaled, simulated, target};
use crate::single::cases;

/// Times the noise.
const SIZES: [f64; 4] = [3.0, 1.0, 10.0, 0.5];

/// By how much a quantity is off, the end of its interval of 95 % being one.
fn off(found: &Quantity, truth: f64) -> Option<f64> {
    let [low, high] = found.interval_95()?;
    let end = if truth > found.value() { high } else { low };
    Some((found.value() - truth) / (end - found.value()).abs())
}

/// A parameter and by how much it is off.
type Off = (String, f64);

/// The parameters of an answer, where it is the right name.
fn sized(entry: &Diagnosis, truth: &Value) -> Vec<Off> {
    let [effect] = &entry.effects[..] else { return Vec::new() };
    let right = entry.ambiguity.is_empty()
        && matches!(entry.verdict, Verdict::Explained | Verdict::PartlyExplained)
        && target(&json!(effect)) == target(truth);
    let of = |(name, found): (&String, &Quantity)| {
        let off = off(found, truth["parameters"][name].as_f64()?)?;
        let bound = if found.is_at_least() { ", at least" } else { "" };
        Some((format!("{}.{name}{bound}", effect.effect), off))
    };
    if right { effect.parameters.iter().filter_map(of).collect() } else { Vec::new() }
}

fn campaign(number: usize) -> Vec<Off> {
    let all = cases();
    let (turn, round) = (number % all.len(), number / all.len());
    let (scene, effect) = &all[turn];
    let effect = scaled(*scene, effect, SIZES[(turn + round) % SIZES.len()]);
    let document = simulated(*scene, std::slice::from_ref(&effect), &noise(), 1000 + number as u64);
    sized(&diagnosed(document).0, &effect)
}

#[test]
fn intervals_hold() {
    let first = testkit::number("FLUXCAL_FIRST").unwrap_or(0) as usize;
    let mut all: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for number in first..first + testkit::campaigns(4) as usize {
        for (name, off) in campaign(number) {
            if off.abs() > 1.0 {
                println!("campaign {number}: {name} is off by {off:.2} times what its interval allows");
            }
            all.entry(name).or_default().push(off);
        }
    }
    let held = |offs: &[f64]| offs.iter().filter(|off| off.abs() <= 1.0).count();
    for (name, offs) in &all {
        println!("{name}: {} of {}", held(offs), offs.len());
    }
    all.retain(|name, _| !name.ends_with("at least"));
    let offs: Vec<f64> = all.into_values().flatten().collect();
    println!("all: {} of {}", held(&offs), offs.len());
    assert!(testkit::agrees(held(&offs), offs.len(), [0.93, 0.97], 1), "{} of {}", held(&offs), offs.len());
}
