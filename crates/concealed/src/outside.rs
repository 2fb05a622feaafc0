//! Plausible physics that the catalogue does not have: no name of the catalogue is right.

mod cores;
mod electronics;
mod means;
mod readout;
mod rooms;
mod sensor;
mod slip;
mod surroundings;
#[cfg(test)]
mod unlike;
mod walk;

use nalgebra::Vector3;

use crate::draw::Draw;
use crate::effect::{Effect, in_geo};
use crate::finer::ode;
use crate::scene::Campaign;
use crate::signal::wandering;
use means::{in_one, rate};

/// What is outside, with its name in scores.
pub type Outside = (&'static str, fn(&Campaign, &mut Draw) -> Effect);

/// All of them, in runs in coils.
pub const ALL: [Outside; 14] = [
    ("contact that opens and closes", telegraph),
    ("thermo-emf of a warming rate", warming_rate),
    ("pick-up rectified by an amplifier", rectified_rate),
    ("output stage with a dead zone", crossover),
    ("gain that changes at a moment", gain_step),
    ("compressor whose speed drifts", compressor),
    ("magnetic aftereffect", aftereffect),
    ("pressure that nobody recorded", pressure),
    ("supply weaker in one direction", bipolar_supply),
    ("product of the three fields", triple_product),
    ("logger that stamps unevenly", jitter),
    ("heater that nobody recorded", heater),
    ("phase change of a glue", glue),
    ("rate of a neighbour's field", neighbour_rate),
];

/// Further ones, in runs in coils; apart, so that the cases of [`ALL`] stay as they are.
pub const FURTHER: [Outside; 36] = [
    ("pinning of domain walls", sensor::pinning),
    ("block that sticks and slips", sensor::friction),
    ("heat flow of either direction", sensor::heat_flow),
    ("bend that follows temperature", sensor::warm_bend),
    ("humidity that turns an axis", sensor::humidity),
    ("suspension that swings", sensor::swing),
    ("beat with a switching supply", electronics::beat),
    ("loop that rings in large fields", electronics::ringing),
    ("multiplexer that slews", electronics::multiplexer),
    ("ripple of a reference", electronics::ripple),
    ("oven of a reference", electronics::oven),
    ("relay that toggles", electronics::relay),
    ("sensitivity with a load", electronics::load),
    ("geomagnetic pulsations", surroundings::pulsations),
    ("lift between floors", surroundings::lift),
    ("bursts of a tram line", surroundings::tram),
    ("nulling that acts in steps", surroundings::stepwise_nulling),
    ("coils that share a supply", surroundings::shared_supply),
    ("avalanches of domain walls", cores::barkhausen),
    ("sensitivity with the rate of the field", cores::rate_sensitivity),
    ("core warmed by its feedback", cores::feedback_heat),
    ("cube of the field across", cores::cube_across),
    ("mount that gives way after a turn", cores::after_a_turn),
    ("product of two temperatures", cores::two_temperatures),
    ("automatic zero that misses", cores::automatic_zero),
    ("clock that is steered", cores::swinging_clock),
    ("converters that take turns", readout::interleaved),
    ("popcorn noise", readout::popcorn),
    ("alias of a chopper", readout::chopper),
    ("soakage of a capacitor", readout::soakage),
    ("ground loop", readout::ground_loop),
    ("strings of a solar array", readout::strings),
    ("heater in pulses", readout::heater_pulses),
    ("steel door", rooms::door),
    ("crane", rooms::crane),
    ("wind on a building", rooms::wind),
];

/// Two levels, thirty changes in a run on the average, at random.
fn telegraph(_: &Campaign, draw: &mut Draw) -> Effect {
    let seed = draw.below(1 << 20) as u64;
    in_one("random telegraph of a bad contact", draw, move |_, run, _, size| {
        let mut flips = Draw::new(&format!("flips/{}", run.id), seed);
        let chance = 30.0 / run.times.len() as f64;
        let mut closed = true;
        let next = |_: &f64| {
            closed ^= flips.between(0.0, 1.0) < chance;
            if closed { size } else { -size }
        };
        run.times.iter().map(next).collect()
    })
}

fn warming_rate(_: &Campaign, draw: &mut Draw) -> Effect {
    in_one("offset in proportion to the rate of warming, a thermo-emf", draw, |_, run, _, size| {
        run.times.iter().map(|t| 100.0 * size * rate(|t| run.temperatures[0](t), *t)).collect()
    })
}

fn rectified_rate(_: &Campaign, draw: &mut Draw) -> Effect {
    in_one("offset with the size of the field's rate", draw, |campaign, run, sensor, size| {
        let field = |t: f64| run.along(&campaign.bench, sensor, t);
        run.times.iter().map(|t| 1e-3 * size * rate(field, *t).abs()).collect()
    })
}

fn crossover(_: &Campaign, draw: &mut Draw) -> Effect {
    let width = draw.between(2000.0, 5000.0);
    in_one("dead zone of an output stage about zero", draw, move |campaign, run, sensor, size| {
        let field = |t: &f64| run.along(&campaign.bench, sensor, *t);
        run.times.iter().map(|t| -size * (field(t) / width).tanh()).collect()
    })
}

fn gain_step(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let run = &campaign.runs[1.min(campaign.runs.len() - 1)];
    let at = run.times[(run.times.len() as f64 * draw.between(0.3, 0.7)) as usize];
    in_one("sensitivity that changes at a moment", draw, move |campaign, run, sensor, size| {
        let gain = |t: &f64| if *t < at { 0.0 } else { 3e-5 * size };
        run.times.iter().map(|t| gain(t) * run.along(&campaign.bench, sensor, *t)).collect()
    })
}

fn compressor(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let step = campaign.runs[0].step_s();
    let (period, phase) = (step * draw.between(4.0, 9.0), draw.between(0.0, 6.0));
    let speed = wandering(draw, 0.05, [30.0 * step, 120.0 * step], 3);
    let loudness = wandering(draw, 0.4, [40.0 * step, 150.0 * step], 3);
    in_one("hum of a compressor whose speed and load drift", draw, move |_, run, _, size| {
        let mut turned = phase;
        let mut at = run.times[0];
        let next = |t: &f64| {
            turned += std::f64::consts::TAU * (t - at) / period * (1.0 + speed(*t));
            at = *t;
            size * (1.0 + loudness(*t)) * turned.sin()
        };
        run.times.iter().map(next).collect()
    })
}

/// Domain walls that go on creeping: relaxation times spread evenly over their logarithm.
fn aftereffect(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let step = campaign.runs[0].step_s();
    in_one("magnetic aftereffect, logarithmic in time", draw, move |campaign, run, sensor, size| {
        let taus: [f64; 5] = std::array::from_fn(|k| step * 3.0_f64.powi(k as i32));
        let field = |t: f64| (run.along(&campaign.bench, sensor, t) / 30_000.0).powi(3);
        let from = run.times[0] - 20.0 * step;
        let lags = ode::march(from, [field(from); 5], &run.times, 0.3 * step, |t, x| {
            std::array::from_fn(|k| (field(t) - x[k]) / taus[k])
        });
        lags.iter().map(|x| size * x.iter().sum::<f64>() / 5.0).collect()
    })
}

fn pressure(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let span = campaign.runs.last().and_then(|run| run.times.last()).copied().unwrap_or(1.0);
    let course = wandering(draw, 1.0, [0.04 * span, 0.15 * span], 6);
    in_one("offset with an unrecorded pressure", draw, move |_, run, _, size| {
        run.times.iter().map(|t| size * course(*t)).collect()
    })
}

fn bipolar_supply(_: &Campaign, draw: &mut Draw) -> Effect {
    let coil = draw.below(3);
    let act = in_geo(move |campaign, run, size| {
        let current = |t: &f64| run.current(coil).map_or(0.0, |current| current(*t));
        let unit: Vector3<f64> = campaign.bench.eta.column(coil).into();
        run.times.iter().map(|t| unit * size * current(t).abs()).collect()
    });
    Effect::new("supply whose gain differs for the two directions of a coil's current", Vec::new(), act)
}

fn triple_product(_: &Campaign, draw: &mut Draw) -> Effect {
    in_one("product of the three fields", draw, |campaign, run, _, size| {
        let product =
            |t: &f64| run.field_sen(&campaign.bench, *t).iter().map(|b| b / 25_000.0).product::<f64>();
        run.times.iter().map(|t| size * product(t)).collect()
    })
}

fn jitter(_: &Campaign, draw: &mut Draw) -> Effect {
    let seed = draw.below(1 << 20) as u64;
    in_one("readings at moments that are off at random", draw, move |campaign, run, sensor, size| {
        let mut ticks = Draw::new(&format!("jitter/{}", run.id), seed);
        let field = |t: f64| run.along(&campaign.bench, sensor, t);
        run.times.iter().map(|t| field(t - 1e-3 * size * ticks.normal()) - field(*t)).collect()
    })
}

fn heater(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let step = campaign.runs[0].step_s();
    let (period, duty) = (step * draw.between(25.0, 60.0), draw.between(0.3, 0.5));
    in_one("current of an unrecorded heater, on and off", draw, move |_, run, _, size| {
        let on = |t: &f64| f64::from(u8::from((t / period).fract() < duty));
        run.times.iter().map(|t| size * on(t)).collect()
    })
}

fn glue(_: &Campaign, draw: &mut Draw) -> Effect {
    let (at, width) = (draw.between(-2.5, 2.5), draw.between(0.5, 1.2));
    in_one("offset that goes over at one temperature", draw, move |campaign, run, _, size| {
        let warm = |t: &f64| run.temperatures[0](*t) - campaign.reference_c[0];
        run.times.iter().map(|t| size * ((warm(t) - at) / width).tanh()).collect()
    })
}

fn neighbour_rate(_: &Campaign, draw: &mut Draw) -> Effect {
    in_one("crosstalk of a neighbour's rate", draw, |campaign, run, sensor, size| {
        let field = |t: f64| run.along(&campaign.bench, (sensor + 1) % 3, t);
        run.times.iter().map(|t| 1e-3 * size * rate(field, *t)).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base;
    use crate::scene::SceneKind;
    use crate::scenes::{self, Length};
    use std::collections::BTreeSet;

    /// Runs in coils.
    pub fn campaign(seed: u64) -> Campaign {
        scenes::campaign(SceneKind::Coils, Length::Long, true, None, &mut Draw::new("outside", seed))
    }

    /// What all sensors get of a size of one, row by row.
    pub fn field_of(campaign: &Campaign, effect: &Effect) -> Vec<[f64; 3]> {
        let added = (effect.act)(campaign, &campaign.plain(), 1.0);
        added.iter().flat_map(|run| (0..run[0].len()).map(|row| [0, 1, 2].map(|k| run[k][row]))).collect()
    }

    /// What the sensor of an effect gets of a size of one, run by run.
    pub fn of_sensor(campaign: &Campaign, effect: &Effect) -> Vec<Vec<f64>> {
        let added = (effect.act)(campaign, &campaign.plain(), 1.0);
        added.into_iter().map(|run| run[effect.sensors[0]].clone()).collect()
    }

    #[test]
    fn every_name_is_there_once() {
        let names: BTreeSet<&str> = ALL.iter().chain(&FURTHER).map(|(name, _)| *name).collect();
        assert_eq!(names.len(), ALL.len() + FURTHER.len());
    }

    /// What the further ones add is finite, in proportion to the size, the same each time, without a name,
    /// and a fresh calibration does not take it up.
    #[test]
    fn further_ones_add_what_no_calibration_takes_up() {
        for (number, (name, make)) in FURTHER.into_iter().enumerate() {
            for length in Length::ALL {
                let mut draw = Draw::new(name, number as u64);
                let campaign = scenes::campaign(SceneKind::Coils, length, true, None, &mut draw);
                let (plain, effect) = (campaign.plain(), make(&campaign, &mut draw));
                assert!(effect.accepted.is_empty() && !effect.on_codes, "{name}");
                let (once, twice) =
                    ((effect.act)(&campaign, &plain, 1.0), (effect.act)(&campaign, &plain, 2.0));
                for (once, twice) in once.iter().flatten().flatten().zip(twice.iter().flatten().flatten()) {
                    assert!(once.is_finite() && (twice - 2.0 * once).abs() <= 1e-9 * twice.abs(), "{name}");
                }
                let whole = base::rms(&once).into_iter().fold(0.0, f64::max);
                let left = base::size_left(&campaign, &once);
                assert!(left > 0.1 * whole && whole > 0.0, "{name}: {left} of {whole} is left");
            }
        }
    }
}
