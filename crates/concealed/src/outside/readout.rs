//! Between the sensors and the file.

use std::f64::consts::TAU;

use super::means::{direction, in_one, mean, span};
use super::walk;
use crate::draw::Draw;
use crate::effect::{Effect, in_block};
use crate::finer::ode;
use crate::scene::{Campaign, Run};
use crate::signal::wandering;

/// Field to which contributions belong, nT.
const FULL_NT: f64 = 50_000.0;

/// Two converters that take turns, and whose gains are not quite equal.
///
/// ```text
/// dB = s (−1)^n B / 50 000 nT, n the number of the row
/// ```
///
/// Source: Kester (ed.) 2005, Data Conversion Handbook (time-interleaved converters).
pub fn interleaved(_: &Campaign, draw: &mut Draw) -> Effect {
    in_one("two converters that take turns", draw, |campaign, run, sensor, size| {
        let turn = |row: usize| if row.is_multiple_of(2) { size } else { -size };
        let field = |t: &f64| run.along(&campaign.bench, sensor, *t) / FULL_NT;
        run.times.iter().enumerate().map(|(row, t)| turn(row) * field(t)).collect()
    })
}

/// Levels of a number of traps, each full or empty at random, with a chance of its own to change.
fn traps(rows: usize, kinds: &[(f64, f64)], draw: &mut Draw) -> Vec<f64> {
    let mut full: Vec<bool> = kinds.iter().map(|_| draw.between(0.0, 1.0) < 0.5).collect();
    let mut next = || {
        kinds
            .iter()
            .zip(&mut full)
            .map(|((chance, height), full)| {
                *full ^= draw.between(0.0, 1.0) < *chance;
                if *full { *height } else { -height }
            })
            .sum()
    };
    (0..rows).map(|_| next()).collect()
}

/// Popcorn noise of three traps in an amplifier: eight levels, quick changes on top of slow ones.
///
/// ```text
/// dB = s Σ_k ± h_k, the k-th sign changing with a chance p_k in each row
/// ```
///
/// dB and s in nT, h 1, 0.7 and 0.5, p between 0.8 and 12 %.
///
/// Source: Kogan 1996, Electronic Noise and Fluctuations in Solids, chapter 8.
pub fn popcorn(_: &Campaign, draw: &mut Draw) -> Effect {
    let kinds =
        [(draw.between(0.008, 0.02), 1.0), (draw.between(0.02, 0.05), 0.7), (draw.between(0.05, 0.12), 0.5)];
    let seed = draw.below(1 << 20) as u64;
    in_one("popcorn noise of three traps", draw, move |_, run, _, size| {
        let mut changes = Draw::new(&format!("traps/{}", run.id), seed);
        traps(run.times.len(), &kinds, &mut changes).into_iter().map(|level| size * level).collect()
    })
}

/// A chopper whose residual is seen at an alias, and whose oscillator drifts with the temperature of the
/// electronics.
///
/// ```text
/// dB = s sin(phi), dphi/dt = 2π (1 + a (T_E − mean)) / P
/// ```
///
/// dB and s in nT, P between 6 and 12 readings, a between 0.1 and 0.2 per K.
///
/// Source: Enz and Temes 1996, Circuit techniques for reducing the effects of op-amp imperfections, Proc.
/// IEEE 84, 1584.
pub fn chopper(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let step = campaign.runs[0].step_s();
    let (period, drift) = (step * draw.between(6.0, 12.0), draw.between(0.1, 0.2) * draw.sign());
    let (begin, mean_c) = (draw.between(0.0, TAU), mean(campaign, |run, t| run.temperatures[1](t)));
    in_one("alias of a chopper that drifts with temperature", draw, move |_, run, _, size| {
        let rate = |t: f64| TAU / period * (1.0 + drift * (run.temperatures[1](t) - mean_c));
        let phases = ode::march(run.times[0], [begin], &run.times, step, |t, _| [rate(t)]);
        phases.iter().map(|phase| size * phase[0].sin()).collect()
    })
}

/// Charge that creeps back into a capacitor after a field of either sign near the end of the range.
///
/// ```text
/// dB = s Q, tau dQ/dt = max(0, |B| / B_0 − 1) − Q
/// ```
///
/// dB and s in nT, B_0 between 20 000 and 28 000 nT, tau between 8 and 20 readings.
///
/// Source: Pease 1982, Understand capacitor soakage to optimize analog systems, EDN 27.
pub fn soakage(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let tau = campaign.runs[0].step_s() * draw.between(8.0, 20.0);
    let level = draw.between(20_000.0, 28_000.0);
    in_one("charge that soaks into a capacitor", draw, move |campaign, run, sensor, size| {
        let over = |t: f64| (run.along(&campaign.bench, sensor, t).abs() / level - 1.0).max(0.0);
        let from = run.times[0] - 5.0 * tau;
        let charge = ode::march(from, [0.0], &run.times, 0.2 * tau, |t, q| [(over(t) - q[0]) / tau]);
        charge.iter().map(|q| size * q[0]).collect()
    })
}

/// A loop through damp earth: a share of a recorded current, which goes with a humidity that nobody recorded.
///
/// ```text
/// dB = s I w(t), w of mean 0 and variance 1 with the correlation exp(−|t| / tau)
/// ```
///
/// dB in nT, s in nT/A, tau between 2 and 5 % of the campaign.
pub fn ground_loop(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let tau = span(campaign) * draw.between(0.02, 0.05);
    let seed = draw.below(1 << 20) as u64;
    in_one("ground loop through damp earth", draw, move |_, run, _, size| {
        let mut air = Draw::new(&format!("damp/{}", run.id), seed);
        let damp = walk::walk(run.times.iter().map(|_| run.step_s() / tau), &mut air);
        let current = |t: f64| run.column("panel_current_a").map_or(0.0, |current| current(t));
        run.times.iter().zip(damp).map(|(t, damp)| size * current(*t) * damp).collect()
    })
}

/// What a regulator that switches strings of a width on and off has beside the current itself: from −1/2 to
/// 1/2.
fn beside_strings(current: f64, width: f64) -> f64 {
    let strings = current / width;
    strings.round() - strings
}

/// A regulator that switches strings of a solar array one by one, each with a loop of its own: the field goes
/// in steps beside the current.
///
/// ```text
/// dB_sen = s v (round(I / q) − I / q)
/// ```
///
/// dB and s in nT, q between 0.25 and 0.5 A, v a direction.
///
/// Source: O'Sullivan and Weinberg 1977, The sequential switching shunt regulator S3R, ESA SP-126.
pub fn strings(_: &Campaign, draw: &mut Draw) -> Effect {
    let (along, width) = (direction(draw), draw.between(0.25, 0.5));
    let act = in_block(move |_, run, size| {
        let current = |t: f64| run.column("panel_current_a").map_or(0.0, |current| current(t));
        run.times.iter().map(|t| along * (size * beside_strings(current(*t), width))).collect()
    });
    Effect::new("strings that a regulator switches", Vec::new(), act)
}

/// Whether pulses of a period are on: for a share of each of them.
fn pulsed(turns: f64, share: f64) -> f64 {
    f64::from(u8::from(turns.rem_euclid(1.0) < share))
}

/// A heater in pulses whose width follows the temperature that it holds.
///
/// ```text
/// dB = s for frac(t / P) < 1/2 − 0.02 (T_S − mean) / 1 K, else 0
/// ```
///
/// dB and s in nT, P between 9 and 20 readings, its phase wandering.
pub fn heater_pulses(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let step = campaign.runs[0].step_s();
    let period = step * draw.between(9.0, 20.0);
    let phase = wandering(draw, 0.3, [60.0 * step, 200.0 * step], 3);
    let mean_c = mean(campaign, |run, t| run.temperatures[0](t));
    let share = move |run: &Run, t: f64| 0.5 - 0.02 * (run.temperatures[0](t) - mean_c);
    in_one("heater in pulses of a width that follows temperature", draw, move |_, run, _, size| {
        run.times.iter().map(|t| size * pulsed(t / period + phase(*t), share(run, *t))).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::{campaign, of_sensor};
    use super::*;

    /// Over two rows the converters' errors cancel but for what the field has moved.
    #[test]
    fn converters_take_turns() {
        let campaign = campaign(1);
        let effect = interleaved(&campaign, &mut Draw::new("turns", 1));
        for (run, added) in campaign.runs.iter().zip(of_sensor(&campaign, &effect)) {
            for (row, (t, value)) in run.times.iter().zip(added).enumerate() {
                let exact = run.along(&campaign.bench, effect.sensors[0], *t) / FULL_NT;
                assert!((value - if row % 2 == 0 { exact } else { -exact }).abs() < 1e-12);
            }
        }
    }

    /// A trap that changes with a chance p in each row has the correlation (1 − 2 p)^k.
    #[test]
    fn traps_forget_exponentially() {
        let levels = traps(80_000, &[(0.05, 1.0)], &mut Draw::new("traps", 1));
        for lag in [1, 4, 12] {
            let sum: f64 = levels.iter().zip(&levels[lag..]).map(|(a, b)| a * b).sum();
            let exact = 0.9_f64.powi(lag as i32);
            assert!((sum / (levels.len() - lag) as f64 - exact).abs() < 0.05, "{lag}");
        }
    }

    /// It stays within its amplitude and spends the time of a sine about it: mean square 1/2.
    #[test]
    fn a_chopper_is_a_sine() {
        let campaign = campaign(2);
        let all: Vec<f64> = of_sensor(&campaign, &chopper(&campaign, &mut Draw::new("chopper", 1))).concat();
        let square = all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64;
        assert!((square - 0.5).abs() < 0.05 && all.iter().all(|x| x.abs() <= 1.0), "{square}");
    }

    /// Charge never has the other sign.
    #[test]
    fn charge_has_one_sign() {
        let campaign = campaign(3);
        let added = of_sensor(&campaign, &soakage(&campaign, &mut Draw::new("soakage", 1)));
        assert!(added.iter().flatten().all(|charge| *charge >= 0.0));
        assert!(added.iter().flatten().any(|charge| *charge > 0.01));
    }

    /// Without a current there is no loop, and with it the loop has its rms.
    #[test]
    fn a_ground_loop_goes_with_its_current() {
        let (mut squares, mut count) = (0.0, 0.0);
        for seed in 0..20 {
            let campaign = campaign(seed);
            let added = of_sensor(&campaign, &ground_loop(&campaign, &mut Draw::new("damp", seed)));
            for (run, added) in campaign.runs.iter().zip(&added) {
                let current = run.column("panel_current_a").expect("a current");
                for (t, value) in run.times.iter().zip(added) {
                    squares += value * value;
                    count += current(*t).powi(2);
                }
            }
        }
        assert!((squares / count - 1.0_f64).abs() < 0.3, "{}", squares / count);
    }

    /// An even spread between ± 1/2, and nothing at whole strings.
    #[test]
    fn strings_are_an_even_spread() {
        let all: Vec<f64> = (0..20_000).map(|k| beside_strings(1e-3 * f64::from(k), 0.4)).collect();
        let square = all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64;
        assert!((square - 1.0 / 12.0).abs() < 1e-3 && beside_strings(1.2, 0.4).abs() < 1e-12);
    }

    #[test]
    fn pulses_are_on_for_their_share() {
        let on: f64 = (0..10_000).map(|k| pulsed(f64::from(k) * 0.001_37, 0.35)).sum();
        assert!((on / 10_000.0 - 0.35).abs() < 0.01, "{on}");
    }
}
