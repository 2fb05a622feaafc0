//! The best set among candidates: all sets, or an exchange search where there are too many.

use nalgebra::{SMatrix, SVector};
use physics::frames::ARCSEC;
use rayon::prelude::*;

use super::information::TURNS;

/// Sets up to this number are all tried; beyond, the search exchanges members.
const MOST_SETS: f64 = 1.5e6;
const BEGINNINGS: usize = 24;

/// What an orientation says on the directions; informations add.
pub type Information = SMatrix<f64, TURNS, TURNS>;

/// Information of each candidate on the directions.
pub struct Field(pub Vec<Information>);

/// A set with its score, rounded so that sets equal but for rounding are equal.
#[derive(Clone, Debug, PartialEq, PartialOrd)]
pub struct Scored {
    /// Largest standard deviation, arcsec; infinite where the set does not determine the directions.
    pub worst: f64,
    /// Numbers of the members, rising.
    pub members: Vec<usize>,
}

impl Field {
    pub fn score(&self, mut members: Vec<usize>) -> Scored {
        members.sort_unstable();
        let sum = members.iter().fold(Information::zeros(), |sum, &member| sum + self.0[member]);
        let scale = SVector::<f64, TURNS>::from_fn(|k, _| sum[(k, k)]).max();
        let worst = match sum.cholesky() {
            Some(root) if root.l_dirty().diagonal().min().powi(2) > 1e-9 * scale => {
                let variance = root.inverse().diagonal().max();
                let arcsec = variance.sqrt() / ARCSEC;
                // Twelve digits: sets that differ only by rounding compare as equal.
                let digits = 10f64.powi(11 - arcsec.log10().floor() as i32);
                (arcsec * digits).round() / digits
            }
            _ => f64::INFINITY,
        };
        Scored { worst, members }
    }

    /// The best set of a size with the search that found it: of all sets where that is feasible, else by
    /// exchange.
    pub fn best(&self, size: usize) -> (usize, Scored, &'static str) {
        let count = self.0.len();
        let sets = (0..size).map(|k| (count - k) as f64 / (size - k) as f64).product::<f64>();
        if sets <= MOST_SETS {
            (size, self.exhaustive(size), "exhaustive")
        } else {
            (size, self.exchange(size), "exchange")
        }
    }

    pub fn exhaustive(&self, size: usize) -> Scored {
        let count = self.0.len();
        let least = |a: Scored, b: Scored| if b < a { b } else { a };
        let none = || Scored { worst: f64::INFINITY, members: (0..size).collect() };
        (0..=count - size)
            .into_par_iter()
            .map(|first| {
                let mut best = none();
                let mut members: Vec<usize> = (first..first + size).collect();
                loop {
                    best = least(best, self.score(members.clone()));
                    // The next combination that begins with `first`, in lexicographic order.
                    let Some(place) = (1..size).rev().find(|&p| members[p] < count - size + p) else {
                        break best;
                    };
                    members[place] += 1;
                    for p in place + 1..size {
                        members[p] = members[p - 1] + 1;
                    }
                }
            })
            .reduce(none, least)
    }

    /// Exchanges one member for one candidate as long as that helps, from several beginnings.
    pub fn exchange(&self, size: usize) -> Scored {
        let count = self.0.len();
        let improve = |mut members: Vec<usize>| {
            let mut best = self.score(members.clone());
            loop {
                let better = (0..size)
                    .flat_map(|place| (0..count).map(move |candidate| (place, candidate)))
                    .filter(|(_, candidate)| !members.contains(candidate))
                    .map(|(place, candidate)| {
                        let mut trial = members.clone();
                        trial[place] = candidate;
                        self.score(trial)
                    })
                    .fold(best.clone(), |a, b| if b.worst < a.worst { b } else { a });
                if better.worst >= best.worst {
                    return best;
                }
                members = better.members.clone();
                best = better;
            }
        };
        (0..BEGINNINGS)
            .into_par_iter()
            .map(|beginning| {
                // Spread over the candidates with a step that has no factor in common with their number.
                let step =
                    (0..).map(|k| 2 * (beginning + k) + 1).find(|step| gcd(*step, count) == 1).unwrap_or(1);
                improve((0..size).map(|k| (beginning + k * step) % count).collect())
            })
            .reduce(
                || Scored { worst: f64::INFINITY, members: (0..size).collect() },
                |a, b| if b < a { b } else { a },
            )
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}
