//! Which coils act across a sensor, and how far it leans towards each: what is odd in the field across and
//! does not depend on the field along, which belongs to the axes.
//!
//! A recording in which the field across changes has its own k, O and leans. Recordings in which it is held
//! show something only together: they share k and O, and, where the block stood alike, the leans.

use common::{Axis, Misalignment, Quantity};
use faer::Mat;
use physics::{Parameter, frames::ARCSEC};

use crate::departure::visible_share;
use crate::fit::{Fit, Unknown};
use crate::readings::{Run, span};
use crate::sides::Lean;
use crate::{Error, Result};

/// A field across that moves by less than this share of the field along is none.
pub const ACROSS: f64 = 0.01;
/// Orientations that differ by less than this are one setting of the block, rad.
const ONE_SETTING: f64 = 3e-4;

pub struct Leaning {
    pub coil: Axis,
    pub runs: Vec<usize>,
}

pub struct Across {
    /// For each run, the coils across the sensor that change in it or, where it is held, in its group.
    pub coils: Vec<Vec<Axis>>,
    pub leanings: Vec<Leaning>,
    /// Runs in which the field across is held.
    pub held: Vec<usize>,
}

impl Across {
    pub fn of(runs: &[Run<'_>]) -> Result<Self> {
        let all: Vec<usize> = (0..runs.len()).collect();
        let (changing, held): (Vec<usize>, Vec<usize>) =
            all.iter().partition(|number| !coils(runs, &[**number]).is_empty());
        let together = coils(runs, &held);
        if let (Some(first), true) = (held.first(), together.is_empty()) {
            let run = &runs[*first];
            let found = format!("no field across sensor {} that changes", run.sensor);
            let expected = "drive on a coil transverse to the sensor, at zero and with both signs: within one recording at one setting of the sensor, or one constant field in each of several";
            return Err(Error::document(format!("{}.columns", run.path), found, expected));
        }
        let mut groups: Vec<Vec<usize>> = changing.into_iter().map(|number| vec![number]).collect();
        for number in &held {
            let alike = |group: &Vec<usize>| {
                let rotation = |of: usize| runs[of].context.orientation.rotation;
                held.contains(&group[0])
                    && runs[group[0]].coil == runs[*number].coil
                    && (rotation(group[0]) - rotation(*number)).norm() < ONE_SETTING
            };
            match groups.iter_mut().find(|group| alike(group)) {
                Some(group) => group.push(*number),
                None => groups.push(vec![*number]),
            }
        }
        groups.sort();
        let mut across = Self { coils: vec![Vec::new(); runs.len()], leanings: Vec::new(), held };
        for group in groups {
            let own = if across.held.contains(&group[0]) { together.clone() } else { coils(runs, &group) };
            for number in &group {
                across.coils[*number].clone_from(&own);
            }
            let driven = |coil: &Axis| size(runs, &group, *coil) > 0.0;
            let leanings = own.into_iter().filter(driven).map(|coil| Leaning { coil, runs: group.clone() });
            across.leanings.extend(leanings);
        }
        Ok(across)
    }

    /// The leans, rad, then k and O: of each run, or one of all in which the field across is held.
    pub fn unknowns(&self, runs: &[Run<'_>]) -> Vec<Unknown> {
        let lean = |leaning: &Leaning| {
            let of = |(number, run): (usize, &Run<'_>)| -> Vec<f64> {
                let acts = leaning.runs.contains(&number);
                (0..run.context.rows)
                    .map(|row| if acts { run.coil_nt(leaning.coil, row) } else { 0.0 })
                    .collect()
            };
            Unknown::Column(runs.iter().enumerate().map(of).collect())
        };
        let mut unknowns: Vec<Unknown> = self.leanings.iter().map(lean).collect();
        for (number, run) in runs.iter().enumerate() {
            let held = self.held.contains(&number);
            if held && self.held[0] != number {
                continue;
            }
            let own = if held { self.held.clone() } else { vec![number] };
            unknowns.push(Unknown::Chain(Parameter::Sensitivity(run.sensor), own.clone()));
            unknowns.push(Unknown::Chain(Parameter::SensorOffset(run.sensor), own));
        }
        unknowns
    }

    /// The cosines between coils that the leans of a fit show.
    pub fn cosines(&self, runs: &[Run<'_>], fit: &Fit) -> Vec<Lean> {
        let leanings = self.leanings.iter().enumerate();
        leanings
            .map(|(at, leaning)| {
                let run = &runs[leaning.runs[0]];
                let eta = |axis: Axis| run.basic.eta.column(axis.index()).into_owned();
                let along = run.context.orientation.rotation * eta(run.coil);
                let sign = along.dot(&run.basic.mu.column(run.sensor.index())).signum();
                Lean {
                    coils: [run.coil, leaning.coil],
                    cosine: eta(run.coil).dot(&eta(leaning.coil)) + sign * fit.values[at],
                    std: fit.covariance(at, at).sqrt(),
                }
            })
            .collect()
    }

    pub fn named(&self, runs: &[Run<'_>], fit: &Fit) -> Vec<Misalignment> {
        let leanings = self.leanings.iter().enumerate();
        leanings
            .flat_map(|(at, leaning)| {
                leaning.runs.iter().map(move |number| Misalignment {
                    recording: runs[*number].context.recording.id.clone(),
                    coil: leaning.coil.to_string(),
                    angle_arcsec: Quantity::new(
                        fit.values[at] / ARCSEC,
                        fit.covariance(at, at).sqrt() / ARCSEC,
                    ),
                })
            })
            .collect()
    }
}

/// The values of a coil's field over the used rows of some runs, nT.
fn values(runs: &[Run<'_>], of: &[usize], coil: Axis) -> Vec<f64> {
    let one = |number: &usize| {
        let run = &runs[*number];
        run.rows.iter().map(|row| run.coil_nt(coil, *row)).collect::<Vec<_>>()
    };
    of.iter().flat_map(one).collect()
}

/// By how much a coil's field changes over some runs, nT.
fn size(runs: &[Run<'_>], of: &[usize], coil: Axis) -> f64 {
    span(values(runs, of, coil).into_iter())
}

/// The coils across the sensor whose fields change over some runs, and not in proportion to another's: a lean
/// towards the one could not be told from one towards the other.
fn coils(runs: &[Run<'_>], of: &[usize]) -> Vec<Axis> {
    let mut found: Vec<Axis> = Vec::new();
    for coil in Axis::ALL {
        let across = of.iter().all(|number| runs[*number].coil != coil);
        let along = of.iter().map(|number| size(runs, &[*number], runs[*number].coil)).fold(0.0, f64::max);
        let apart = |other: &Axis| {
            let (one, two) = (values(runs, of, coil), values(runs, of, *other));
            let with = Mat::from_fn(one.len(), 2, |i, j| if j == 0 { 1.0 } else { two[i] });
            visible_share(&with, &one) >= ACROSS
        };
        if across && size(runs, of, coil) > ACROSS * along && found.iter().all(apart) {
            found.push(coil);
        }
    }
    found
}
