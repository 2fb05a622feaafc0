//! The recordings that reach a target in the least time at the facility.

use nalgebra::{Matrix3, SMatrix};
use physics::frames::ARCSEC;
use rayon::prelude::*;
use serde::Serialize;

use super::given::{Given, Setting, Times};
use super::information::{ALL, Information, Pieces, Said};
use super::radius::Reach;

pub const MOST_SETTINGS: usize = 48;
const MOST_DRIVES: usize = 64;
const CYCLES: [usize; 6] = [1, 2, 3, 4, 6, 8];
const WEAKEST: [usize; 6] = [1, 2, 3, 5, 8, 12];
const READINGS: [usize; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
/// Readings of a sensor in a setting, at most.
const MOST_READINGS: usize = 2000;
/// Of more candidates than this, the first is one of the first three orientations.
const MANY: usize = 40;
const MOST_THEODOLITE: usize = 50;
const THEODOLITE: [usize; 15] = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 25, 32, 40, MOST_THEODOLITE];
/// A coil is weak when another makes so many times its field.
const WEAK: f64 = 1.5;
/// Rounds in which orientations and readings settle.
const ROUNDS: usize = 4;

#[derive(Clone, Debug, PartialEq)]
pub struct Recordings {
    pub setting: Setting,
    /// The orientation of each, by its number among the candidates; one may come several times.
    pub orientations: Vec<usize>,
}

/// Time at the facility, h.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Hours {
    /// Turning the block, with the first reading of the theodolites.
    pub orientations: f64,
    /// Reading the theodolites again.
    pub theodolites: f64,
    pub drives: f64,
    pub temperatures: f64,
    pub total: f64,
}

impl Recordings {
    pub fn hours(&self, given: &Given) -> Hours {
        let [orientations, theodolites, drives] =
            given.hours(&self.setting).map(|hours| hours * self.orientations.len() as f64);
        let Times { temperature_levels, temperature_s, .. } = given.times;
        let temperatures = temperature_levels as f64 * temperature_s / 3600.0;
        let total = orientations + theodolites + drives + temperatures;
        Hours { orientations, theodolites, drives, temperatures, total }
    }
}

#[derive(Clone, Debug)]
pub struct Target {
    /// Error of a direction, arcsec.
    pub arcsec: f64,
    /// How far errors reach with the probability that is asked for.
    pub reach: Reach,
    /// Directions that count: the sensors (6), or the coils as well (12).
    pub turns: usize,
}

impl Target {
    /// The largest error of any direction, arcsec; infinite where one is not determined.
    pub fn worst_arcsec(&self, covariance: Option<&Information>) -> f64 {
        let Some(covariance) = covariance else { return f64::INFINITY };
        let of = |turn: usize| self.reach.of(block(covariance, turn)) / ARCSEC;
        (0..self.turns).step_by(2).map(of).fold(0.0, f64::max)
    }
}

/// The covariance of the two turns of a direction.
pub fn block(covariance: &Information, turn: usize) -> [[f64; 2]; 2] {
    [0, 1].map(|i| [0, 1].map(|j| covariance[(turn + i, turn + j)]))
}

/// The covariance of all that is common, as axescal states it: what the coils' gradients make is added.
pub fn covariance(said: &Said, prior: &Information) -> Option<Information> {
    let sum = said.information + prior;
    // In units in which the diagonal is one, an orientation that is not determined shows.
    let scale = SMatrix::<f64, ALL, 1>::from_fn(|k, _| sum[(k, k)].sqrt().recip());
    if !scale.iter().all(|scale| scale.is_finite()) {
        return None;
    }
    let scaled = Information::from_fn(|i, j| sum[(i, j)] * scale[i] * scale[j]);
    let root = scaled.cholesky().filter(|root| root.l_dirty().diagonal().min() > 1e-6)?;
    let inverse = root.inverse();
    let own = Information::from_fn(|i, j| inverse[(i, j)] * scale[i] * scale[j]);
    let pushed = own * said.gradients;
    Some(own + pushed * pushed.transpose())
}

pub struct Search<'a> {
    pub given: &'a Given,
    pub candidates: &'a [Matrix3<f64>],
    prior: Information,
    /// Each way to go through the drives, with what it says in each orientation.
    schedules: Vec<(Setting, Vec<Pieces>)>,
}

impl<'a> Search<'a> {
    /// Works out what every schedule says in every orientation.
    pub fn new(given: &'a Given, candidates: &'a [Matrix3<f64>]) -> Self {
        let strongest = given.coil_nt.into_iter().fold(0.0, f64::max);
        let weak = strongest > WEAK * given.coil_nt[given.weakest()];
        // Flicker noise is declared up to half the rate: drives that are read once would miss what is faster.
        let fewest = if given.has_memory() { 2 } else { 1 };
        let mut settings = Vec::new();
        for cycles in CYCLES {
            for weakest_coil in WEAKEST.into_iter().filter(|times| weak || *times == 1) {
                let drives = cycles * (4 + 2 * weakest_coil);
                let readings = READINGS.into_iter().filter(|readings| {
                    *readings >= fewest
                        && drives <= MOST_DRIVES
                        && (drives * readings <= MOST_READINGS || *readings == fewest)
                });
                settings.extend(readings.map(|readings| Setting {
                    theodolite_readings: 1,
                    cycles,
                    weakest_coil,
                    readings,
                }));
            }
        }
        let schedules =
            settings.into_par_iter().map(|setting| (setting, given.pieces(candidates, &setting))).collect();
        Self { given, candidates, prior: given.prior(), schedules }
    }

    /// The recordings of the least time that reach a target; else the best error that is within reach.
    pub fn least(&self, target: &Target) -> Result<Recordings, f64> {
        let mut found: Option<(f64, Recordings)> = None;
        // Orientations are added in the order of the most that can be done, then of what was found.
        let most = self.schedules.len() - 1;
        let mut order = self.order(&self.schedules[most].1, MOST_THEODOLITE, target);
        for _ in 0..ROUNDS {
            let Some(next) = self.along(&order, target) else { break };
            if found.as_ref().is_some_and(|(hours, _)| next.0 >= *hours) {
                break;
            }
            let setting = next.1.setting;
            found = Some(next);
            let of = |other: &&(Setting, Vec<Pieces>)| {
                Setting { theodolite_readings: setting.theodolite_readings, ..other.0 } == setting
            };
            let Some((_, pieces)) = self.schedules.iter().find(of) else { break };
            order = self.order(pieces, setting.theodolite_readings, target);
        }
        found.map(|(_, recordings)| recordings).ok_or_else(|| {
            let all = self.schedules.par_iter();
            let best = all.map(|(_, pieces)| self.worst_arcsec_of(pieces, MOST_THEODOLITE, &order, target));
            best.reduce(|| f64::INFINITY, f64::min)
        })
    }

    /// The least time where orientations are taken in an order.
    fn along(&self, order: &[usize], target: &Target) -> Option<(f64, Recordings)> {
        let better = |a: Option<(f64, Recordings)>, b: Option<(f64, Recordings)>| match (a, b) {
            (Some(a), Some(b)) => Some(if b.0 < a.0 { b } else { a }),
            (a, b) => a.or(b),
        };
        self.schedules
            .par_iter()
            .map(|(schedule, pieces)| {
                let mut best: Option<(f64, Recordings)> = None;
                for theodolite_readings in THEODOLITE {
                    let setting = Setting { theodolite_readings, ..*schedule };
                    let each: f64 = self.given.hours(&setting).iter().sum();
                    let most = best
                        .as_ref()
                        .map_or(order.len(), |(hours, _)| ((hours / each).ceil() as usize).saturating_sub(1));
                    let most = most.min(order.len());
                    if most < 3 {
                        break;
                    }
                    if let Some(count) = self.fewest(pieces, theodolite_readings, &order[..most], target) {
                        let hours = each * count as f64;
                        best = Some((hours, Recordings { setting, orientations: order[..count].to_vec() }));
                    }
                }
                best
            })
            .reduce(|| None, better)
    }

    /// The smallest number of an order's orientations that reaches the target.
    fn fewest(
        &self,
        pieces: &[Pieces],
        theodolite_readings: usize,
        order: &[usize],
        target: &Target,
    ) -> Option<usize> {
        let reaches = |count: usize| {
            self.worst_arcsec_of(pieces, theodolite_readings, &order[..count], target) <= target.arcsec
        };
        if !reaches(order.len()) {
            return None;
        }
        let (mut low, mut high) = (2, order.len());
        while high - low > 1 {
            let middle = usize::midpoint(low, high);
            if reaches(middle) { high = middle } else { low = middle }
        }
        Some(high)
    }

    fn worst_arcsec_of(
        &self,
        pieces: &[Pieces],
        theodolite_readings: usize,
        orientations: &[usize],
        target: &Target,
    ) -> f64 {
        let std = self.given.theodolite_rad(theodolite_readings);
        let said = Said::of(orientations.iter().map(|orientation| pieces[*orientation].said(std)));
        target.worst_arcsec(covariance(&said, &self.prior).as_ref())
    }

    /// The first three orientations, then one after the other, each the one that lowers the largest error
    /// most.
    fn order(&self, pieces: &[Pieces], theodolite_readings: usize, target: &Target) -> Vec<usize> {
        let std = self.given.theodolite_rad(theodolite_readings);
        let each: Vec<Said> = pieces.iter().map(|pieces| pieces.said(std)).collect();
        let count = each.len();
        let score = |members: &[usize]| {
            let said = Said::of(members.iter().map(|member| &each[*member]));
            // Twelve digits, so that what is equal but for rounding is equal.
            let worst = target.worst_arcsec(covariance(&said, &self.prior).as_ref());
            let digits = 10f64.powi(11 - worst.log10().floor().clamp(-30.0, 30.0) as i32);
            if worst.is_finite() { (worst * digits).round() / digits } else { worst }
        };
        let firsts = if count > MANY { 1 } else { count };
        let triples: Vec<[usize; 3]> = (0..firsts)
            .flat_map(|a| (a + 1..count).flat_map(move |b| (b + 1..count).map(move |c| [a, b, c])))
            .collect();
        let scored = |members: Vec<usize>| (score(&members), members);
        let least = |a: (f64, Vec<usize>), b: (f64, Vec<usize>)| {
            if b.0.total_cmp(&a.0).then_with(|| b.1.cmp(&a.1)).is_lt() { b } else { a }
        };
        // Whatever is compared with it comes first, undetermined directions too.
        let none = || (f64::INFINITY, vec![usize::MAX]);
        let mut best = triples.into_par_iter().map(|triple| scored(triple.into())).reduce(none, least).1;
        while best.len() < MOST_SETTINGS {
            let with = |candidate: usize| scored(best.iter().copied().chain([candidate]).collect());
            best = (0..count).into_par_iter().map(with).reduce(none, least).1;
        }
        best
    }

    /// The covariance that recordings give, where facility and instrument err as `given` says.
    pub fn covariance(&self, given: &Given, recordings: &Recordings) -> Option<Information> {
        let pieces = given.pieces(self.candidates, &recordings.setting);
        let std = given.theodolite_rad(recordings.setting.theodolite_readings);
        let said = Said::of(recordings.orientations.iter().map(|orientation| pieces[*orientation].said(std)));
        covariance(&said, &given.prior())
    }

    /// The same recordings with one setting more, in the orientation that helps most.
    pub fn with_one_more(&self, recordings: &Recordings, target: &Target) -> Recordings {
        let with = |candidate: usize| Recordings {
            orientations: recordings.orientations.iter().copied().chain([candidate]).collect(),
            ..recordings.clone()
        };
        let pieces = self.given.pieces(self.candidates, &recordings.setting);
        let worst = |more: &Recordings| {
            self.worst_arcsec_of(&pieces, more.setting.theodolite_readings, &more.orientations, target)
        };
        let all = (0..self.candidates.len()).map(with);
        all.min_by(|a, b| worst(a).total_cmp(&worst(b))).unwrap_or_else(|| recordings.clone())
    }
}
