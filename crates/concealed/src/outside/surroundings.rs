//! In the facility and around it.

use nalgebra::Vector3;
use std::f64::consts::TAU;

use super::means::{direction, moments, span};
use super::slip;
use crate::draw::Draw;
use crate::effect::{Effect, in_geo};
use crate::scene::Campaign;
use crate::signal::{Signal, wandering};

/// A wave that comes and goes: e^(−(t/w)²/2) times the cosine and the sine of 2π t / period.
fn packet(since: f64, period: f64, width: f64) -> [f64; 2] {
    let (sine, cosine) = (TAU * since / period).sin_cos();
    [cosine, sine].map(|wave| wave * (-0.5 * (since / width).powi(2)).exp())
}

/// Pulsations of Earth's field, of a minute to two and a half (Pc4), which the nulling does not reach: waves
/// in packets, each with an ellipse of its own.
///
/// ```text
/// dB_geo = s Σ_k (a_k cos x + b_k sin x) exp(−(t − t_k)² / (2 w_k²)), x = 2π (t − t_k) / P_k
/// ```
///
/// dB and s in nT, P between 60 and 150 s, w between one and a half and three periods; a packet for every
/// fifty readings.
///
/// Source: Jacobs, Kato, Matsushita and Troitskaya 1964, Classification of geomagnetic micropulsations, J.
/// Geophys. Res. 69, 180.
pub fn pulsations(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let all: Vec<(f64, f64, f64, [Vector3<f64>; 2])> = moments(campaign, 50, draw)
        .into_iter()
        .map(|at| {
            let period = draw.between(60.0, 150.0);
            let ellipse = [direction(draw) * draw.between(0.5, 1.5), direction(draw) * 0.4];
            (at, period, period * draw.between(1.5, 3.0), ellipse)
        })
        .collect();
    let act = in_geo(move |_, run, size| {
        let field = |t: &f64| {
            let one = |(at, period, width, ellipse): &(f64, f64, f64, [Vector3<f64>; 2])| {
                let [cosine, sine] = packet(t - at, *period, *width);
                ellipse[0] * cosine + ellipse[1] * sine
            };
            all.iter().map(one).sum::<Vector3<f64>>() * size
        };
        run.times.iter().map(field).collect()
    });
    Effect::new("packets of pulsations of the natural field", Vec::new(), act)
}

/// Floors of a building, and the height of each, m.
const FLOORS: usize = 6;
const STOREY_M: f64 = 3.5;

/// Where a lift is at a time, of its stops in order: the moment of arrival and the floor.
fn floor(stops: &[(f64, usize)], t: f64) -> usize {
    let arrived = stops.partition_point(|(arrival, _)| *arrival <= t);
    stops[arrived.saturating_sub(1)].1
}

/// Stops of a lift for `span` s: it stands between `least` and `most`, then goes to another floor.
fn stops(span: f64, least: f64, most: f64, draw: &mut Draw) -> Vec<(f64, usize)> {
    let mut all = vec![(0.0, draw.below(FLOORS))];
    while let Some((arrival, floor)) = all.last().copied().filter(|(arrival, _)| *arrival < span) {
        all.push((arrival + draw.octaves(least, most), (floor + 1 + draw.below(FLOORS - 1)) % FLOORS));
    }
    all
}

/// A lift: a magnetised cabin that goes from floor to floor, at any hour, faster than readings come.
///
/// ```text
/// dB_geo = s (3 n (n.m) − m) (d / r)³, r n the way to the floor where it stands, d its smallest distance
/// ```
///
/// dB and s in nT, d between 8 and 15 m, six floors of 3.5 m; it stands for 4 to 25 readings.
///
/// Source: Jackson, Classical Electrodynamics (field of a dipole).
pub fn lift(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let step = campaign.runs[0].step_s();
    let (distance, moment) = (draw.between(8.0, 15.0), direction(draw));
    let stops = stops(span(campaign), 4.0 * step, 25.0 * step, draw);
    let act = in_geo(move |_, run, size| {
        let field = |t: &f64| {
            let height = STOREY_M * (floor(&stops, *t) as f64 - 1.0);
            let place = Vector3::new(0.6 * distance, 0.8 * distance, height);
            let (r, n) = (place.norm(), place.normalize());
            (3.0 * n * n.dot(&moment) - moment) * size * (distance / r).powi(3)
        };
        run.times.iter().map(field).collect()
    });
    Effect::new("lift that goes from floor to floor", Vec::new(), act)
}

/// A size of which x or more has the probability x^−1.5, from 1 on, the largest cut at 6.
fn burst(draw: &mut Draw) -> f64 {
    draw.between(0.0, 1.0).max(1e-9).powf(-1.0 / 1.5).min(6.0)
}

/// Trams that start: bursts of the current between rail and ground, few of them large, along one direction.
///
/// ```text
/// dB_geo = s v Σ_k a_k for t_k <= t < t_k + d_k, P(|a| > x) = x^−1.5
/// ```
///
/// dB and s in nT, v a direction, a of either sign, d between one and five readings; a burst for every twelve
/// readings.
///
/// Source: Lowes 2009, DC railways and the magnetic fields they produce, Earth Planets Space 61, i.
pub fn tram(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (step, along) = (campaign.runs[0].step_s(), direction(draw));
    let bursts: Vec<(f64, f64, f64)> = moments(campaign, 12, draw)
        .into_iter()
        .map(|at| (at, at + step * draw.between(1.0, 5.0), draw.sign() * burst(draw)))
        .collect();
    let act = in_geo(move |_, run, size| {
        let current = |t: f64| -> f64 {
            bursts.iter().filter(|(on, off, _)| (*on..*off).contains(&t)).map(|(_, _, a)| a).sum()
        };
        run.times.iter().map(|t| along * (size * current(*t))).collect()
    });
    Effect::new("bursts of a tram line's current", Vec::new(), act)
}

/// Nulling that waits until the natural field has gone by a threshold, and then takes all of it out.
///
/// ```text
/// dB_geo = s (U − U_taken), U_taken = U as soon as |U − U_taken| > 1/2, per axis
/// ```
///
/// dB and s in nT, U of rms 1, with periods of 20 to 90 readings.
///
/// Source: NASA CR-156638, test of the Earth field nulling system.
pub fn stepwise_nulling(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let step = campaign.runs[0].step_s();
    let outside: [Signal; 3] = std::array::from_fn(|_| wandering(draw, 1.0, [20.0 * step, 90.0 * step], 4));
    let act = in_geo(move |_, run, size| {
        let left = |signal: &Signal| slip::departures(run.times.iter().map(|t| signal(*t)), 0.5);
        let left = outside.each_ref().map(left);
        (0..run.times.len()).map(|row| Vector3::from_fn(|axis, _| size * left[axis][row])).collect()
    });
    Effect::new("nulling that waits for a threshold", Vec::new(), act)
}

/// Two coils on one supply: the current of one sags with the size of the other's.
///
/// ```text
/// dB_geo = −s n I_k |I_j| / 1 A², n the axis of coil k, j the next coil
/// ```
///
/// dB and s in nT.
pub fn shared_supply(_: &Campaign, draw: &mut Draw) -> Effect {
    let coil = draw.below(3);
    let act = in_geo(move |campaign, run, size| {
        let current = |coil: usize, t: f64| run.current(coil).map_or(0.0, |current| current(t));
        let unit: Vector3<f64> = campaign.bench.eta.column(coil).into();
        let sag = |t: f64| -size * current(coil, t) * current((coil + 1) % 3, t).abs();
        run.times.iter().map(|t| unit * sag(*t)).collect()
    });
    Effect::new("two coils that share a supply", Vec::new(), act)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{campaign, field_of};
    use super::*;
    use std::collections::BTreeSet;

    /// A packet has the sum √(2π) w e^(−(2π w / P)² / 2) of a Gaussian wave, and is gone after six widths.
    #[test]
    fn a_packet_is_a_gaussian_wave() {
        for (period, width) in [(10.0, 15.0), (20.0, 8.0)] {
            let all: Vec<[f64; 2]> =
                (-6000..=6000).map(|k| packet(0.02 * f64::from(k), period, width)).collect();
            let sum = |part: usize| 0.02 * all.iter().map(|both| both[part]).sum::<f64>();
            let expected = TAU.sqrt() * width * (-0.5 * (TAU * width / period).powi(2)).exp();
            assert!((sum(0) - expected).abs() < 1e-6 && sum(1).abs() < 1e-9, "{} for {expected}", sum(0));
            assert!(packet(6.0 * width, period, width)[0].abs() < 1e-7);
        }
    }

    /// A lift has one level for each floor, to which it comes back.
    #[test]
    fn a_lift_has_a_level_for_each_floor() {
        let campaign = campaign(1);
        let run = &campaign.runs[0];
        let added = (lift(&campaign, &mut Draw::new("lift", 1)).act)(&campaign, &campaign.plain(), 1.0);
        let levels: BTreeSet<i64> = added[0][2].iter().map(|value| (1e9 * value).round() as i64).collect();
        assert!((3..=FLOORS).contains(&levels.len()), "{levels:?}");
        let moves = added[0][2].windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!((run.times.len() / 25..run.times.len() / 4).contains(&moves), "{moves}");
    }

    /// Of the bursts an eighth is above four times the least, and none above the cut.
    #[test]
    fn bursts_follow_a_power_law() {
        let mut draw = Draw::new("bursts", 1);
        let all: Vec<f64> = (0..8000).map(|_| burst(&mut draw)).collect();
        let share = all.iter().filter(|size| **size > 4.0).count() as f64 / all.len() as f64;
        assert!((share - 0.125).abs() < 0.01, "{share}");
        assert!(all.iter().all(|size| (1.0..=6.0).contains(size)));
    }

    /// Between bursts a tram line has no field.
    #[test]
    fn a_tram_line_returns_to_zero() {
        let campaign = campaign(2);
        let added = field_of(&campaign, &tram(&campaign, &mut Draw::new("tram", 1)));
        let quiet = added.iter().filter(|field| field.iter().all(|value| *value == 0.0)).count();
        assert!((0.6..0.95).contains(&(quiet as f64 / added.len() as f64)), "{quiet} of {}", added.len());
    }

    /// No axis is ever left with more than the threshold.
    #[test]
    fn nulling_leaves_at_most_its_threshold() {
        let campaign = campaign(3);
        let added = field_of(&campaign, &stepwise_nulling(&campaign, &mut Draw::new("nulling", 1)));
        let most = 0.5 * 3.0_f64.sqrt();
        assert!(added.iter().flatten().all(|value| value.abs() <= most));
    }

    /// A sag follows the sign of its own coil, and is the same for both directions of the other's.
    #[test]
    fn a_sag_is_odd_in_one_current_and_even_in_the_other() {
        let campaign = campaign(4);
        let reversed = |which: usize| {
            let mut campaign = campaign.clone();
            for run in &mut campaign.runs {
                if let crate::scene::World::Coils(currents) = &mut run.world {
                    let old = currents[which].clone();
                    currents[which] = std::sync::Arc::new(move |t| -old(t));
                }
            }
            field_of(&campaign, &shared_supply(&campaign, &mut Draw::new("supply", 1)))
        };
        let coil = Draw::new("supply", 1).below(3);
        let as_it_is = field_of(&campaign, &shared_supply(&campaign, &mut Draw::new("supply", 1)));
        assert_eq!(reversed((coil + 1) % 3), as_it_is);
        let negative: Vec<[f64; 3]> = as_it_is.iter().map(|field| field.map(|value| -value)).collect();
        assert_eq!(reversed(coil), negative);
    }
}
