//! SINDy's ensemble: thresholded least squares on bags of the rows; what most bags keep is chosen, its
//! coefficients are their medians.
//!
//! Source: Fasel, Kutz, Brunton & Brunton 2022, Ensemble-SINDy, Proc. R. Soc. A 478, 20210904; PySINDy's
//! `EnsembleOptimizer`, de Silva et al. 2020, JOSS 5, 2104. Bags are drawn with replacement, as many pieces
//! of time as there are; threshold and ridge are those of the least extended Bayesian information criterion
//! on all rows.
//!
//! Its threshold is on single coefficients, which mean nothing where columns run together. So of each grid it
//! has the value that explains most by itself, and it goes without smooth structure, of which every name has
//! a part: with it, far fewer names were right.

use diagnose::{Dictionary, Error};
use estimate::screen::Screen;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::collections::BTreeSet;

use crate::Choice;
use crate::blocks::{Blocks, Sample};
use crate::criterion::{Criterion, SEARCH};
use crate::reduced::{Reduced, VISIBLE};
use crate::stability::{HELD, held, shares};
use crate::thresholded::{Kept, thresholded};

/// Pieces of time of which bags are made.
const PIECES: usize = 40;
/// Bags: Fasel's.
const BAGS: u64 = 100;
/// The share of bags that must keep a group.
const SHARE: f64 = 0.6;
/// Thresholds that are tried, in standard deviations of the residual for a column of unit rms.
const THRESHOLDS: [f64; 12] = [0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.8];
/// Ridges that are tried, as shares of the rows.
const RIDGES: [f64; 6] = [1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0];

/// Chooses groups of a dictionary.
pub fn choose(dictionary: &Dictionary, screen: &Screen, seed: u64) -> Result<Choice, Error> {
    let (owners, reduced) = library(dictionary, screen)?;
    let blocks = Blocks::of(dictionary, &reduced.columns, PIECES);
    let whole = blocks.sample(&[1.0; PIECES])?;
    let Some((threshold, ridge)) = settings(screen, &reduced, &whole) else {
        let reasons = vec!["no threshold keeps anything that lowers the criterion".into()];
        return Ok(Choice { reasons, ..Choice::default() });
    };
    let bags: Vec<Vec<f64>> = (0..BAGS).map(|number| bag(seed, number)).collect();
    let (found, medians) = ensemble(&blocks, &reduced, &bags, threshold, ridge)?;
    let mut kept: Vec<usize> = (0..found.len()).filter(|column| found[*column] >= SHARE).collect();
    kept.sort_by(|a, b| found[*b].total_cmp(&found[*a]));
    let unit = (whole.squares / whole.rows).sqrt();
    let mut reasons = vec![format!(
        "kept in at least {SHARE} of {BAGS} bags at a threshold of {:.2} standard deviations of the residual and a ridge of {:.0e} of the rows",
        threshold / unit,
        ridge / whole.rows
    )];
    reasons.extend(kept.iter().map(|column| {
        let name = &dictionary.groups[owners[*column]].name;
        let rms = dictionary.noise_nt * medians[*column].abs();
        format!("a column of {name}: {:.2} of the bags, rms {rms:.2e} nT", found[*column])
    }));
    let mut groups: Vec<usize> = Vec::new();
    for column in &kept {
        if !groups.contains(&owners[*column]) {
            groups.push(owners[*column]);
        }
    }
    let columns = kept.iter().map(|column| reduced.columns[*column].clone()).collect();
    Ok(Choice { groups, columns, reasons })
}

/// The columns of each name at the value of its grid that explains most by itself, each of mean square one,
/// and the group of each.
fn library(dictionary: &Dictionary, screen: &Screen) -> Result<(Vec<usize>, Reduced), Error> {
    let (mut owners, mut reduced) = (Vec::new(), Reduced { groups: Vec::new(), columns: Vec::new() });
    for (number, group) in dictionary.groups.iter().enumerate().filter(|(_, g)| g.effect.is_some()) {
        let mut best: Option<(f64, &[usize])> = None;
        for form in &group.forms {
            let gain = screen.gain(&form.columns)?.gain;
            if best.is_none_or(|(most, _)| gain > most) {
                best = Some((gain, &form.columns));
            }
        }
        let Some((_, columns)) = best else { continue };
        for column in columns.iter().filter(|column| screen.visible(**column) > VISIBLE) {
            let unit = (screen.freedom() / screen.product(*column, *column)).sqrt();
            reduced.groups.push(owners.len()..owners.len() + 1);
            reduced.columns.push(vec![(*column, unit)]);
            owners.push(number);
        }
    }
    Ok((owners, reduced))
}

/// Threshold and ridge of the least criterion; None where nothing is better than nothing.
fn settings(screen: &Screen, reduced: &Reduced, whole: &Sample) -> Option<(f64, f64)> {
    let unit = (whole.squares / whole.rows).sqrt();
    let criterion = Criterion { rows: screen.freedom(), search: SEARCH };
    let nothing = criterion.of(whole.squares, 0.0, 0.0);
    let all: Vec<(f64, f64)> = RIDGES
        .iter()
        .flat_map(|ridge| THRESHOLDS.map(|t| (t * unit / (1.0 + ridge), ridge * whole.rows)))
        .collect();
    let value = |(threshold, ridge): (f64, f64)| {
        let kept = thresholded(whole, &reduced.groups, threshold, ridge);
        let columns = kept.groups.len() as f64;
        let log_candidates = columns * (reduced.columns.len() as f64).ln();
        (criterion.of(whole.squares - kept.gain, columns, log_candidates), (threshold, ridge))
    };
    let values: Vec<(f64, (f64, f64))> = all.into_par_iter().map(value).collect();
    let best = values.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 < nothing).then_some(best.1)
}

/// As many pieces as there are, drawn with replacement: how often each.
fn bag(seed: u64, number: u64) -> Vec<f64> {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(number);
    let mut weights = vec![0.0; PIECES];
    (0..PIECES).for_each(|_| weights[generator.random_range(0..PIECES)] += 1.0);
    weights
}

/// In which share of the bags that hold it each group is kept, and the medians of all coefficients.
fn ensemble(
    blocks: &Blocks,
    reduced: &Reduced,
    bags: &[Vec<f64>],
    threshold: f64,
    ridge: f64,
) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let one = |weights: &Vec<f64>| {
        let sample = blocks.sample(weights)?;
        Ok((thresholded(&sample, &reduced.groups, threshold, ridge), held(&sample, reduced, HELD)))
    };
    let found: Vec<(Kept, Vec<bool>)> = bags.par_iter().map(one).collect::<Result<_, Error>>()?;
    let median = |column: usize| {
        let all: Vec<f64> = found.iter().map(|(kept, _)| kept.coefficients[column]).collect();
        estimate::stats::median(&all)
    };
    let medians = (0..reduced.columns.len()).map(median).collect();
    let chosen: Vec<(BTreeSet<usize>, Vec<bool>)> =
        found.into_iter().map(|(kept, held)| (kept.groups.into_iter().collect(), held)).collect();
    Ok((shares(&chosen, reduced.groups.len()), medians))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thresholded::reference::{cases, list, lists, rows};

    /// PySINDy's EnsembleOptimizer on the same bags: fixtures/reference/baselines_pysindy.py.
    #[test]
    fn the_shares_and_medians_of_pysindy() {
        for case in cases() {
            let rows = rows(&case);
            let blocks = Blocks::of_rows(&rows);
            let width = case.columns.len();
            let reduced =
                Reduced { groups: (0..width).map(|k| k..k + 1).collect(), columns: vec![Vec::new(); width] };
            let bags = lists(&case.value["bags"]);
            for expected in case.value["ensembles"].as_array().expect("ensembles") {
                let threshold = expected["threshold"].as_f64().expect("a number");
                let (shares, medians) = ensemble(&blocks, &reduced, &bags, threshold, 0.05).expect("finite");
                for (found, expected) in shares.iter().zip(list(&expected["inclusion"])) {
                    assert!((found - expected).abs() < 1e-12, "{found} for {expected} at {threshold}");
                }
                for (found, expected) in medians.iter().zip(list(&expected["medians"])) {
                    assert!((found - expected).abs() < 1e-8, "{found} for {expected} at {threshold}");
                }
            }
        }
    }
}
