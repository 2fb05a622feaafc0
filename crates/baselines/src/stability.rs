//! Stability selection: what the group lasso chooses in most halves of the recordings.
//!
//! In each half the groups that come in first, up to q of them, are noted; those that come in in a share π of
//! the halves are chosen. Of G groups, the expected number of those chosen that a half takes with no more
//! than the mean probability q/G is at most q²/((2π − 1) G). Source: Meinshausen & Bühlmann 2010, Stability
//! selection, JRSS B 72, 417; in pairs of halves that share no row, for which that holds without their
//! assumption of exchangeability: Shah & Samworth 2013, Variable selection with error control, JRSS B 75, 55.
//!
//! Halves are made of pieces of time and not of single rows, for noise has memory. What happens at one moment
//! is in one half of a pair alone: of each group those halves count that hold it, and for such groups the
//! bound is not proven.

use diagnose::{Dictionary, Error};
use estimate::screen::Screen;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;

use crate::Choice;
use crate::blocks::{Blocks, Sample};
use crate::lasso::Lasso;
use crate::reduced::Reduced;

/// Pieces of time of which halves are made.
const PIECES: usize = 40;
/// Pairs of halves: Shah & Samworth's.
const PAIRS: u64 = 50;
/// The share of halves π.
const SHARE: f64 = 0.75;
/// The bound on the expected number of false choices, from which q follows.
const FALSE: f64 = 0.1;
/// A sample in which the mean square of a group's columns is less than this share of what it is in all rows
/// does not count for it.
pub const HELD: f64 = 0.5;

/// Chooses groups of a dictionary.
pub fn choose(dictionary: &Dictionary, screen: &Screen, seed: u64) -> Result<Choice, Error> {
    let reduced = Reduced::of(dictionary, screen)?;
    let blocks = Blocks::of(dictionary, &reduced.columns, PIECES);
    let there = reduced.groups.iter().filter(|group| !group.is_empty()).count() as f64;
    let first = (FALSE * (2.0 * SHARE - 1.0) * there).sqrt().floor().max(1.0);
    let halves: Vec<[Vec<f64>; 2]> = (0..PAIRS).map(|pair| halves(seed, pair)).collect();
    let halves: Vec<&Vec<f64>> = halves.iter().flatten().collect();
    let found: Vec<(BTreeSet<usize>, Vec<bool>)> = halves
        .par_iter()
        .map(|weights| {
            let sample = blocks.sample(weights)?;
            Ok((Lasso::of(&sample, &reduced.groups).first(first as usize), held(&sample, &reduced, HELD)))
        })
        .collect::<Result<_, Error>>()?;
    let shares = shares(&found, reduced.groups.len());
    let mut groups: Vec<usize> = (0..shares.len()).filter(|group| shares[*group] >= SHARE).collect();
    groups.sort_by(|a, b| shares[*b].total_cmp(&shares[*a]));
    let bound = first * first / ((2.0 * SHARE - 1.0) * there);
    let mut reasons = vec![format!(
        "chosen in at least {SHARE} of {} halves, the first {first} of {there} groups in each: {bound:.2} false ones expected at most",
        found.len()
    )];
    reasons.extend(groups.iter().map(|g| format!("{}: {:.2}", dictionary.groups[*g].name, shares[*g])));
    let columns = groups.iter().flat_map(|group| reduced.columns[reduced.groups[*group].clone()].to_vec());
    Ok(Choice { columns: columns.collect(), groups, reasons })
}

/// Half of the pieces, and the other half.
fn halves(seed: u64, pair: u64) -> [Vec<f64>; 2] {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(pair);
    let mut first: Vec<f64> = (0..PIECES).map(|piece| f64::from(u8::from(piece < PIECES / 2))).collect();
    first.shuffle(&mut generator);
    let second = first.iter().map(|weight| 1.0 - weight).collect();
    [first, second]
}

/// Whether the columns of each group, of mean square one over all rows, have a mean square of at least so
/// much in a sample.
pub fn held(sample: &Sample, reduced: &Reduced, least: f64) -> Vec<bool> {
    let of = |group: &Range<usize>| {
        let squares: f64 = group.clone().map(|j| sample.gram[(j, j)]).sum();
        squares >= least * sample.rows * group.len() as f64
    };
    reduced.groups.iter().map(of).collect()
}

/// In which share of the samples that hold it each group was chosen.
pub fn shares(found: &[(BTreeSet<usize>, Vec<bool>)], groups: usize) -> Vec<f64> {
    let share = |group: usize| {
        let counts: Vec<bool> =
            found.iter().filter(|(_, held)| held[group]).map(|(chosen, _)| chosen.contains(&group)).collect();
        let chosen = counts.iter().filter(|chosen| **chosen).count();
        chosen as f64 / counts.len().max(1) as f64
    };
    (0..groups).map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_share_no_piece_and_are_repeatable() {
        let [first, second] = halves(1, 7);
        assert_eq!(first.iter().sum::<f64>(), 20.0);
        assert!(first.iter().zip(&second).all(|(a, b)| a + b == 1.0));
        assert_eq!(halves(1, 7), [first.clone(), second]);
        assert_ne!(halves(1, 8)[0], first);
    }

    #[test]
    fn what_is_in_one_half_counts_there_alone() {
        let set = |groups: &[usize]| groups.iter().copied().collect::<BTreeSet<usize>>();
        let found = [(set(&[0, 1]), vec![true, true]), (set(&[0]), vec![true, false])];
        assert_eq!(shares(&found, 2), [1.0, 1.0]);
        let found = [(set(&[0, 1]), vec![true, true]), (set(&[0]), vec![true, true])];
        assert_eq!(shares(&found, 2), [1.0, 0.5]);
    }
}
