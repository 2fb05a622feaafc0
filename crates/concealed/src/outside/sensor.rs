//! In the sensors and what holds them.

use nalgebra::Vector3;
use std::f64::consts::TAU;

use super::means::{direction, in_one, mean, moments, rate, span};
use super::{slip, walk};
use crate::draw::Draw;
use crate::effect::{Effect, in_block, in_geo};
use crate::scene::{Campaign, Run};

const ARCSEC: f64 = 4.848e-6;

/// Domain walls of the core hang on its defects, and the field has to move on before they hang on others.
///
/// ```text
/// dB = s w(X), X = ∫ |dB|, w of mean 0 and variance 1 with the correlation exp(−X / X_0)
/// ```
///
/// dB and s in nT, X_0 between 5 000 and 15 000 nT. The contribution is frozen while the field stands, and
/// changes the more between readings the faster the field goes.
///
/// Source: Alessandro, Beatrice, Bertotti and Montorsi 1990, Domain-wall dynamics and Barkhausen effect in
/// metallic ferromagnetic materials, J. Appl. Phys. 68, 2901.
pub fn pinning(_: &Campaign, draw: &mut Draw) -> Effect {
    let (length_nt, seed) = (draw.between(5000.0, 15_000.0), draw.below(1 << 20) as u64);
    in_one(
        "domain walls pinned at random along the way of the field",
        draw,
        move |campaign, run, sensor, size| {
            let field: Vec<f64> = run.times.iter().map(|t| run.along(&campaign.bench, sensor, *t)).collect();
            let moved = field.windows(2).map(|pair| (pair[1] - pair[0]).abs() / length_nt);
            let mut defects = Draw::new(&format!("defects/{}", run.id), seed);
            let pinned = walk::walk(std::iter::once(0.0).chain(moved), &mut defects);
            pinned.iter().map(|w| size * w).collect()
        },
    )
}

/// A block that friction holds while its support expands: it twists, and springs back when the twist is too
/// large.
///
/// ```text
/// dB_sen = s θ n × B_sen, θ = T_S − T_held, T_held = T_S as soon as |θ| > h
/// ```
///
/// s in seconds of arc per K, h between 1 and 2 K, n a direction fixed in the block.
///
/// Source: Bowden and Tabor 1950, The Friction and Lubrication of Solids (stick and slip).
pub fn friction(_: &Campaign, draw: &mut Draw) -> Effect {
    let (about, most_k) = (direction(draw), draw.between(1.0, 2.0));
    let act = in_block(move |campaign, run, size| {
        let twist = slip::departures(run.times.iter().map(|t| run.temperatures[0](*t)), most_k);
        let turned = |(t, twist): (&f64, &f64)| {
            about.cross(&run.field_sen(&campaign.bench, *t)) * (ARCSEC * size * twist)
        };
        run.times.iter().zip(&twist).map(turned).collect()
    });
    Effect::new("block that friction holds while its support expands", Vec::new(), act)
}

/// A difference of temperature across the core strains it, whether the heat flows in or out.
///
/// ```text
/// dB = 100 s |dT_S/dt|
/// ```
///
/// dB and s in nT, the rate in K/s.
pub fn heat_flow(_: &Campaign, draw: &mut Draw) -> Effect {
    in_one("offset with the size of the rate of temperature", draw, |_, run, _, size| {
        run.times.iter().map(|t| 100.0 * size * rate(|t| run.temperatures[0](t), *t).abs()).collect()
    })
}

/// A sensitivity that is compensated for temperature over the range of the campaign, while the bend that
/// belongs to it is not.
///
/// ```text
/// dB = s (T_S − T_mean) / 10 K · x (x² − 1), x = B / b, b² = mean(B⁴) / mean(B²)
/// ```
///
/// dB and s in nT; with this b the departure has no part that is proportional to the field.
pub fn warm_bend(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let mean_k = mean(campaign, |run, t| run.temperatures[0](t));
    in_one("bend that is proportional to temperature", draw, move |campaign, run, sensor, size| {
        let field = |run: &Run, t: f64| run.along(&campaign.bench, sensor, t);
        let moment = |power: i32| mean(campaign, |run, t| field(run, t).powi(power));
        let trimmed = (moment(4) / moment(2)).sqrt();
        let bent = |t: &f64| {
            let (warm, x) = ((run.temperatures[0](*t) - mean_k) / 10.0, field(run, *t) / trimmed);
            size * warm * x * (x * x - 1.0)
        };
        run.times.iter().map(bent).collect()
    })
}

/// A block of plastic that takes up moisture and swells unevenly: one sensor turns with a humidity that
/// nobody recorded.
///
/// ```text
/// dB = s w(t) u, w of mean 0 and variance 1 with the correlation exp(−|t| / tau), u the SEN field across the sensor
/// ```
///
/// s in seconds of arc, tau between 2 and 6 % of the campaign.
pub fn humidity(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let tau = span(campaign) * draw.between(0.02, 0.06);
    let seed = draw.below(1 << 20) as u64;
    in_one("axis that turns with an unrecorded humidity", draw, move |campaign, run, sensor, size| {
        let mut air = Draw::new(&format!("air/{}", run.id), seed);
        let turned = walk::walk(run.times.iter().map(|_| run.step_s() / tau), &mut air);
        let across = |t: f64| run.field_sen(&campaign.bench, t)[(sensor + 1) % 3];
        run.times.iter().zip(turned).map(|(t, w)| ARCSEC * size * w * across(*t)).collect()
    })
}

/// A turn that begins at a knock and dies away: sin(2π t / period) e^(−t / tau) after it, nothing before.
fn swinging(since: f64, period: f64, tau: f64) -> f64 {
    if since < 0.0 { 0.0 } else { (TAU * since / period).sin() * (-since / tau).exp() }
}

/// A block on a fibre that swings about the vertical after each knock.
///
/// ```text
/// dB_geo = −s θ z × B_geo, θ = Σ_k a_k sin(2π (t − t_k) / P) exp(−(t − t_k) / tau) over the knocks t_k < t
/// ```
///
/// s in seconds of arc; P between 2.5 and 7 readings, tau between 12 and 30; a knock every forty readings on
/// the average, a of variance 1.
pub fn swing(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let step = campaign.runs[0].step_s();
    let (period, tau) = (step * draw.between(2.5, 7.0), step * draw.between(12.0, 30.0));
    let knocks: Vec<(f64, f64)> =
        moments(campaign, 40, draw).into_iter().map(|at| (at, draw.normal())).collect();
    let act = in_geo(move |campaign, run, size| {
        let turned = |t: &f64| knocks.iter().map(|(at, a)| a * swinging(t - at, period, tau)).sum::<f64>();
        let around = |t: &f64| Vector3::z().cross(&run.field_geo(&campaign.bench, *t));
        run.times.iter().map(|t| around(t) * (-ARCSEC * size * turned(t))).collect()
    });
    Effect::new("suspension that swings after knocks", Vec::new(), act)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{campaign, of_sensor};
    use super::*;

    /// The steps between readings are larger where the field goes faster.
    #[test]
    fn pinning_changes_with_the_way_of_the_field() {
        let campaign = campaign(1);
        let effect = pinning(&campaign, &mut Draw::new("pinning", 1));
        let sensor = effect.sensors[0];
        let (mut slow, mut fast) = (Vec::new(), Vec::new());
        for (run, added) in campaign.runs.iter().zip(of_sensor(&campaign, &effect)) {
            for (times, added) in run.times.windows(2).zip(added.windows(2)) {
                let field = |t: f64| run.along(&campaign.bench, sensor, t);
                let moved = (field(times[1]) - field(times[0])).abs();
                if moved < 1000.0 { &mut slow } else { &mut fast }.push((added[1] - added[0]).powi(2));
            }
        }
        let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
        assert!(mean(&slow) < 0.5 * mean(&fast), "{} {}", mean(&slow), mean(&fast));
    }

    /// A twist never goes beyond the most that friction holds, and stands across the field.
    #[test]
    fn a_twist_is_bounded() {
        let campaign = campaign(2);
        let added =
            (friction(&campaign, &mut Draw::new("friction", 1)).act)(&campaign, &campaign.plain(), 1.0);
        for (run, added) in campaign.runs.iter().zip(&added) {
            for (row, t) in run.times.iter().enumerate() {
                let most = 2.0 * ARCSEC * run.field_sen(&campaign.bench, *t).norm();
                assert!(added.iter().all(|column| column[row].abs() <= most));
            }
        }
    }

    /// Heat that flows in does what heat that flows out does.
    #[test]
    fn heat_flow_has_one_sign() {
        let campaign = campaign(3);
        let effect = heat_flow(&campaign, &mut Draw::new("heat", 1));
        let added = of_sensor(&campaign, &effect);
        assert!(added.iter().flatten().all(|value| *value >= 0.0));
        for (run, added) in campaign.runs.iter().zip(&added) {
            let warmed = |t: f64| (run.temperatures[0](t + 0.5) - run.temperatures[0](t - 0.5)).abs();
            let off = run.times.iter().zip(added).map(|(t, value)| (value - 100.0 * warmed(*t)).abs());
            assert!(off.fold(0.0, f64::max) < 1e-9);
        }
    }

    /// Over the campaign the bend at any one temperature has no part in proportion to the field.
    #[test]
    fn a_bend_has_no_slope() {
        let campaign = campaign(4);
        let effect = warm_bend(&campaign, &mut Draw::new("bend", 1));
        let (sensor, added) = (effect.sensors[0], of_sensor(&campaign, &effect));
        let mean_k = super::super::means::mean(&campaign, |run, t| run.temperatures[0](t));
        let (mut slope, mut size) = (0.0, 0.0);
        for (run, added) in campaign.runs.iter().zip(&added) {
            for (t, value) in run.times.iter().zip(added) {
                let bend = value / (run.temperatures[0](*t) - mean_k);
                slope += bend * run.along(&campaign.bench, sensor, *t);
                size += (bend * run.along(&campaign.bench, sensor, *t)).abs();
            }
        }
        assert!(slope.abs() < 1e-6 * size, "{slope} of {size}");
    }

    /// The turn of an axis has the rms of the stated size.
    #[test]
    fn a_humid_axis_turns_by_its_size() {
        let (mut squares, mut count) = (0.0, 0.0);
        for seed in 0..30 {
            let campaign = campaign(seed);
            let effect = humidity(&campaign, &mut Draw::new("humidity", seed));
            let sensor = effect.sensors[0];
            for (run, added) in campaign.runs.iter().zip(of_sensor(&campaign, &effect)) {
                for (t, value) in run.times.iter().zip(added) {
                    let across = run.field_sen(&campaign.bench, *t)[(sensor + 1) % 3];
                    squares += (value / (ARCSEC * across)).powi(2);
                    count += 1.0;
                }
            }
        }
        assert!((squares / count - 1.0_f64).abs() < 0.2, "{}", squares / count);
    }

    /// After a period the same again, smaller by e^(−P / tau); before the knock nothing.
    #[test]
    fn a_swing_dies_away() {
        for k in 1..50 {
            let t = 0.37 * f64::from(k);
            let (now, later) = (swinging(t, 4.0, 20.0), swinging(t + 4.0, 4.0, 20.0));
            assert!((later - now * (-0.2_f64).exp()).abs() < 1e-12);
            assert_eq!(swinging(-t, 4.0, 20.0), 0.0);
        }
    }
}
