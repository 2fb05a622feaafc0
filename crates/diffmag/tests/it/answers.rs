//! What a run answers, and how often something holds over campaigns.

use common::{Axis, DifferentialCalibration, DifferentialFit, Document, Quantity};
use indexmap::IndexMap;
use rayon::prelude::*;

pub fn found(document: &Document, correct_clock: bool) -> DifferentialCalibration {
    let found = diffmag::run(document.clone(), &diffmag::Options { correct_clock }).expect("fitted");
    found.calibration.expect("a calibration").differential.expect("a fit")
}

pub fn fit(document: &Document) -> DifferentialFit {
    *found(document, false).fit.expect("a fit")
}

/// The elements of η by name with their places: `xy` is what the test's y takes from the reference's x.
pub fn elements() -> impl Iterator<Item = (String, usize, usize)> {
    let of = |from: Axis| Axis::ALL.map(|to| (format!("{from}{to}"), from.index(), to.index()));
    Axis::ALL.into_iter().flat_map(of)
}

pub fn std(quantity: &Quantity) -> f64 {
    quantity.std().expect("an uncertainty")
}

/// How far a quantity is from the truth, in its standard uncertainties.
pub fn off(quantity: &Quantity, truth: f64) -> f64 {
    (quantity.value() - truth) / std(quantity)
}

/// Whether the truth is in the 95 % interval.
pub fn holds(quantity: &Quantity, truth: f64) -> bool {
    off(quantity, truth).abs() <= 1.96
}

/// What a campaign says, by name: a number, or one where something holds and zero where it does not.
#[derive(Default)]
pub struct Said(Vec<(String, f64)>);

impl Said {
    pub fn number(&mut self, name: impl Into<String>, number: f64) {
        self.0.push((name.into(), number));
    }

    pub fn holds(&mut self, name: impl Into<String>, holds: bool) {
        self.number(name, f64::from(u8::from(holds)));
    }
}

/// Sums of what campaigns say, and how many numbers are in each.
pub type Sums = IndexMap<String, (f64, usize)>;

/// Makes some campaigns and prints the means of what they say.
pub fn over(name: &str, count: u64, campaign: impl Fn(u64) -> Said + Send + Sync) -> Sums {
    let all: Vec<Said> = (0..count).into_par_iter().map(campaign).collect();
    let mut sums = Sums::new();
    for (key, number) in all.into_iter().flat_map(|said| said.0) {
        let (sum, count) = sums.entry(key).or_default();
        (*sum, *count) = (*sum + number, *count + 1);
    }
    for (key, (sum, count)) in &sums {
        println!("{name}: {key}: {:.4} over {count}", sum / *count as f64);
    }
    sums
}

pub fn share(sums: &Sums, key: &str) -> f64 {
    let (sum, count) = sums[key];
    sum / count as f64
}

/// Shares that do not agree with a band, all that are judged taken together.
pub fn outside(shares: &Sums, band: [f64; 2], judged: impl Fn(&str) -> bool) -> Vec<String> {
    let judged: Vec<_> = shares.iter().filter(|(key, _)| judged(key)).collect();
    let apart = |(held, tried): (f64, usize)| !testkit::agrees(held as usize, tried, band, judged.len());
    let apart = judged.iter().filter(|(_, share)| apart(**share));
    apart.map(|(key, (held, tried))| format!("{key}: {held} of {tried}")).collect()
}
