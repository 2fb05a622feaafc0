//! In the core and in the mount.

use super::means::{in_one, mean, moments, rate, span};
use crate::draw::Draw;
use crate::effect::Effect;
use crate::finer::ode;
use crate::scene::{Campaign, Run};

/// Field to which contributions belong, nT.
const FULL_NT: f64 = 50_000.0;
const ARCSEC: f64 = 4.848e-6;

fn along(campaign: &Campaign, run: &Run, sensor: usize) -> Vec<f64> {
    run.times.iter().map(|t| run.along(&campaign.bench, sensor, *t)).collect()
}

/// Jumps at random whose chance grows with the way of the field, each of which dies away: of a course and of
/// the rows that a jump lasts.
fn avalanches(field: &[f64], each_nt: f64, rows: f64, draw: &mut Draw) -> Vec<f64> {
    let (kept, mut level) = ((-1.0 / rows).exp(), 0.0);
    let ways = field.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let next = |way: f64| {
        level *= kept;
        if draw.between(0.0, 1.0) < -(-way / each_nt).exp_m1() {
            level += draw.normal();
        }
        level
    };
    std::iter::once(0.0).chain(ways).map(next).collect()
}

/// Avalanches of domain walls, the more the faster the field goes, of either sign, each over after some
/// readings (Barkhausen).
///
/// ```text
/// dB = s Σ_k a_k exp(−(t − t_k) / tau), the t_k with the rate |dB/dt| / B_each
/// ```
///
/// dB and s in nT, a of variance 1, B_each 40 000 nT, tau between 3 and 8 readings.
///
/// Source: Durin and Zapperi 2006, The Barkhausen effect, in The Science of Hysteresis II.
pub fn barkhausen(_: &Campaign, draw: &mut Draw) -> Effect {
    let (rows, seed) = (draw.between(3.0, 8.0), draw.below(1 << 20) as u64);
    in_one(
        "avalanches of domain walls with the way of the field",
        draw,
        move |campaign, run, sensor, size| {
            let mut jumps = Draw::new(&format!("avalanches/{}", run.id), seed);
            let all = avalanches(&along(campaign, run, sensor), 40_000.0, rows, &mut jumps);
            all.into_iter().map(|level| size * level).collect()
        },
    )
}

/// A core that sees less of a field that moves, whichever way it moves: its permeability falls with the size
/// of the rate.
///
/// ```text
/// dB = 1e-3 s B / 50 000 nT · |dB/dt|
/// ```
pub fn rate_sensitivity(_: &Campaign, draw: &mut Draw) -> Effect {
    in_one("sensitivity with the size of the field's rate", draw, |campaign, run, sensor, size| {
        let field = |t: f64| run.along(&campaign.bench, sensor, t);
        run.times.iter().map(|t| 1e-3 * size * field(*t) / FULL_NT * rate(field, *t).abs()).collect()
    })
}

/// A signal behind a lag, at each row.
fn lagged(run: &Run, tau: f64, signal: impl Fn(f64) -> f64) -> Vec<f64> {
    let from = run.times[0] - 5.0 * tau;
    let slope = |t: f64, y: &[f64; 1]| [(signal(t) - y[0]) / tau];
    ode::march(from, [signal(from)], &run.times, 0.3 * tau, slope).iter().map(|y| y[0]).collect()
}

/// A core that its own feedback current warms, and a mount that bends with it.
///
/// ```text
/// dB = s u H / 50 000 nT, tau dH/dt = (B / 50 000 nT)² − H, u the SEN field across the sensor
/// ```
///
/// dB and s in nT, tau between 4 and 12 readings.
pub fn feedback_heat(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let tau = campaign.runs[0].step_s() * draw.between(4.0, 12.0);
    in_one("mount that bends as the feedback current warms it", draw, move |campaign, run, sensor, size| {
        let heat = |t: f64| (run.along(&campaign.bench, sensor, t) / FULL_NT).powi(2);
        let across = |t: f64| run.field_sen(&campaign.bench, t)[(sensor + 1) % 3] / FULL_NT;
        let warm = lagged(run, tau, heat);
        run.times.iter().zip(warm).map(|(t, warm)| size * across(*t) * warm).collect()
    })
}

/// A field across the sensor with its cube, as a core has it that is not quite symmetric.
///
/// ```text
/// dB = s (u / 50 000 nT)³, u the SEN field across the sensor
/// ```
pub fn cube_across(_: &Campaign, draw: &mut Draw) -> Effect {
    in_one("cube of the field across", draw, |campaign, run, sensor, size| {
        let across = |t: &f64| run.field_sen(&campaign.bench, *t)[(sensor + 1) % 3] / FULL_NT;
        run.times.iter().map(|t| size * across(t).powi(3)).collect()
    })
}

/// A mount that gives way after the block was turned, anew in each run.
///
/// ```text
/// dB = s u exp(−(t − t_run) / tau), u the SEN field across the sensor
/// ```
///
/// s in seconds of arc, tau between 15 and 40 readings.
pub fn after_a_turn(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let tau = campaign.runs[0].step_s() * draw.between(15.0, 40.0);
    in_one("mount that gives way after each turn", draw, move |campaign, run, sensor, size| {
        let across = |t: f64| run.field_sen(&campaign.bench, t)[(sensor + 2) % 3];
        let left = |t: f64| (-(t - run.times[0]) / tau).exp();
        run.times.iter().map(|t| ARCSEC * size * across(*t) * left(*t)).collect()
    })
}

/// A compensation whose amplifier drifts: the offset goes with the product of two temperatures, each over its
/// mean.
///
/// ```text
/// dB = s (T_S − mean) (T_E − mean) / 10 K²
/// ```
pub fn two_temperatures(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let means = [0, 1].map(|k| mean(campaign, |run, t| run.temperatures[k](t)));
    in_one("offset with the product of two temperatures", draw, move |_, run, _, size| {
        let warm = |k: usize, t: f64| run.temperatures[k](t) - means[k];
        run.times.iter().map(|t| 0.1 * size * warm(0, *t) * warm(1, *t)).collect()
    })
}

/// An amplifier with an automatic zero, which misses it by something else each time.
///
/// ```text
/// dB = s a_k for t_k <= t < t_(k+1)
/// ```
///
/// dB and s in nT, a of variance 1; a zero for every 25 readings, at random.
pub fn automatic_zero(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let mut zeros: Vec<f64> = moments(campaign, 25, draw);
    zeros.sort_by(f64::total_cmp);
    let levels: Vec<f64> = (0..=zeros.len()).map(|_| draw.normal()).collect();
    in_one("automatic zero that misses", draw, move |_, run, _, size| {
        let level = |t: &f64| levels[zeros.partition_point(|zero| zero <= t)];
        run.times.iter().map(|t| size * level(t)).collect()
    })
}

/// A clock whose error swings about zero, as one does that is steered.
///
/// ```text
/// dB = −1e-3 s dB/dt sin(2π t / P)
/// ```
///
/// s in ms, P between 4 and 10 % of the campaign.
pub fn swinging_clock(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (period, begin) = (span(campaign) * draw.between(0.04, 0.1), draw.between(0.0, 6.0));
    in_one("clock that is steered to and fro", draw, move |campaign, run, sensor, size| {
        let field = |t: f64| run.along(&campaign.bench, sensor, t);
        let late = |t: f64| 1e-3 * size * (std::f64::consts::TAU * t / period + begin).sin();
        run.times.iter().map(|t| -late(*t) * rate(field, *t)).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::{campaign, of_sensor};
    use super::*;

    /// In a field that goes at an even pace the level has the variance of shot noise: p / (1 − k²), p the
    /// chance of a jump in a reading and k what is kept; where the field stands nothing begins.
    #[test]
    fn avalanches_are_shot_noise() {
        let field: Vec<f64> = (0..60_000).map(|k| 4000.0 * f64::from(k)).collect();
        let all = avalanches(&field, 40_000.0, 5.0, &mut Draw::new("avalanches", 1));
        let found = all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64;
        let exact = -(-0.1_f64).exp_m1() / -(-0.4_f64).exp_m1();
        assert!((found / exact - 1.0).abs() < 0.1, "{found} for {exact}");
        assert!(
            avalanches(&[5.0; 100], 40_000.0, 5.0, &mut Draw::new("avalanches", 2)).iter().all(|x| *x == 0.0)
        );
    }

    /// A lag of many time constants' length forgets how it began: a constant field gives its square.
    #[test]
    fn a_constant_field_warms_by_its_square() {
        let campaign = campaign(3);
        let found = lagged(&campaign.runs[0], 100.0, |_| 0.49);
        assert!(found.iter().all(|heat| (heat - 0.49).abs() < 1e-12));
    }

    /// The rate of a field of one sign and of the other is alike: reversed, everything is.
    #[test]
    fn a_sensitivity_with_the_rate_is_odd_in_the_field() {
        let campaign = campaign(4);
        let mut reversed = campaign.clone();
        for run in &mut reversed.runs {
            if let crate::scene::World::Coils(currents) = &mut run.world {
                currents.iter_mut().for_each(|current| {
                    let old = current.clone();
                    *current = std::sync::Arc::new(move |t| -old(t));
                });
            }
        }
        for make in [rate_sensitivity, cube_across] {
            let effect = make(&campaign, &mut Draw::new("odd", 1));
            let (one, other) = (of_sensor(&campaign, &effect), of_sensor(&reversed, &effect));
            let sums = one
                .iter()
                .flatten()
                .zip(other.iter().flatten())
                .map(|(a, b)| (a + b).abs() / a.abs().max(1e-9));
            assert!(sums.fold(0.0, f64::max) < 1e-6);
        }
    }

    /// After one time constant of each run the mount has given way by all but 1/e.
    #[test]
    fn a_mount_gives_way_in_each_run() {
        let campaign = campaign(5);
        let effect = after_a_turn(&campaign, &mut Draw::new("turn", 1));
        for (run, added) in campaign.runs.iter().zip(of_sensor(&campaign, &effect)) {
            let relative = |row: usize| {
                let across = run.field_sen(&campaign.bench, run.times[row])[(effect.sensors[0] + 2) % 3];
                added[row] / (ARCSEC * across)
            };
            let taus = 20.0 * run.step_s() / (relative(0) / relative(20)).ln() / run.step_s();
            assert!((relative(0) - 1.0).abs() < 1e-9 && (15.0..=40.0).contains(&taus), "{taus}");
        }
    }

    /// Between two zeros nothing changes.
    #[test]
    fn a_zero_holds_until_the_next() {
        let campaign = campaign(6);
        let added = of_sensor(&campaign, &automatic_zero(&campaign, &mut Draw::new("zero", 1)));
        for run in added {
            let changes = run.windows(2).filter(|pair| pair[0] != pair[1]).count();
            assert!((4..=run.len() / 25).contains(&changes), "{changes}");
        }
    }

    /// Over the campaign the two temperatures' product has no more than its covariance for a mean.
    #[test]
    fn temperatures_are_taken_over_their_means() {
        let campaign = campaign(7);
        let added = of_sensor(&campaign, &two_temperatures(&campaign, &mut Draw::new("two", 1)));
        let count = added.iter().flatten().count() as f64;
        let sum = |k: usize| mean(&campaign, |run, t| run.temperatures[k](t));
        let means = [sum(0), sum(1)];
        let covariance = mean(&campaign, |run, t| {
            (run.temperatures[0](t) - means[0]) * (run.temperatures[1](t) - means[1])
        });
        assert!((added.iter().flatten().sum::<f64>() / count - 0.1 * covariance).abs() < 1e-9);
    }

    /// A clock that swings is right on the average: early as long as late.
    #[test]
    fn a_steered_clock_is_right_on_the_average() {
        let campaign = campaign(8);
        let effect = swinging_clock(&campaign, &mut Draw::new("clock", 1));
        let late = |run: &Run, t: f64, added: f64| {
            -1e3 * added / rate(|t| run.along(&campaign.bench, effect.sensors[0], t), t)
        };
        let all: Vec<f64> = campaign
            .runs
            .iter()
            .zip(of_sensor(&campaign, &effect))
            .flat_map(|(run, added)| {
                run.times.iter().zip(added).map(|(t, added)| late(run, *t, added)).collect::<Vec<f64>>()
            })
            .collect();
        assert!(all.iter().all(|late| late.abs() <= 1.0 + 1e-6));
        assert!((all.iter().sum::<f64>() / all.len() as f64).abs() < 0.2);
    }
}
