//! Lines of power supplies.

use std::f64::consts::TAU;

use super::environment::direction;
use crate::draw::Draw;
use crate::effect::{Effect, in_geo};
use crate::finer::mains;
use crate::scene::Campaign;
use crate::signal::wandering;

/// Length of a held run, s, in which loads change: about a second.
const RUN_S: f64 = 1.0;

/// A cable's field under a load that changes, its components not in phase.
pub fn changing_load(_: &Campaign, draw: &mut Draw) -> Effect {
    let (along, across) = (direction(draw), 0.4 * direction(draw));
    let (departure, seed) = (draw.between(-0.05, 0.05), draw.below(1 << 20) as u64);
    let load = wandering(draw, 0.1, [0.4 * RUN_S, 2.0 * RUN_S], 3);
    let act = in_geo(move |_, run, size| {
        let phase = mains::phase(&run.times, departure, 0.02, 200.0, &mut Draw::new("grid", seed));
        let field = |(p, t): (&f64, &f64)| (along * p.sin() + across * p.cos()) * (size * (1.0 + load(*t)));
        phase.iter().zip(&run.times).map(field).collect()
    });
    Effect::new("mains under a changing load", vec!["mains".into()], act)
}

/// A railway's field at a third of the mains' frequency, which rises and falls as trains take power.
pub fn railway(_: &Campaign, draw: &mut Draw) -> Effect {
    let (along, across) = (direction(draw), 0.4 * direction(draw));
    let (departure, seed) = (draw.between(-0.1, 0.1), draw.below(1 << 20) as u64);
    let (depth, phase) = (draw.between(0.05, 0.15), draw.between(0.0, TAU));
    let act = in_geo(move |_, run, size| {
        let mains = mains::phase(&run.times, departure, 0.03, 200.0, &mut Draw::new("railway", seed));
        let power = |t: f64| 1.0 + depth * (TAU * t / (3.0 * RUN_S) + phase).sin();
        let field = |(p, t): (&f64, &f64)| {
            let third = p / 3.0;
            (along * third.sin() + across * third.cos()) * (size * power(*t))
        };
        mains.iter().zip(&run.times).map(field).collect()
    });
    Effect::new("railway power under a changing load", vec!["traction_power".into()], act)
}

/// Two feeders with loads of their own, a third of a turn apart: the sum wanders in size and phase.
pub fn two_feeders(_: &Campaign, draw: &mut Draw) -> Effect {
    let fields = [direction(draw), 0.5 * direction(draw)];
    let (departure, seed) = (draw.between(-0.05, 0.05), draw.below(1 << 20) as u64);
    let loads = [0; 2].map(|_| wandering(draw, 0.1, [0.4 * RUN_S, 2.0 * RUN_S], 3));
    let act = in_geo(move |_, run, size| {
        let phase = mains::phase(&run.times, departure, 0.02, 200.0, &mut Draw::new("grid", seed));
        let field = |(p, t): (&f64, &f64)| {
            fields[0] * ((1.0 + loads[0](*t)) * p.sin())
                + fields[1] * ((1.0 + loads[1](*t)) * (p + TAU / 3.0).sin())
        };
        phase.iter().zip(&run.times).map(|both| field(both) * size).collect()
    });
    Effect::new("mains of two feeders with loads of their own", vec!["mains".into()], act)
}

/// A locomotive whose power goes up and down in notches.
pub fn notches(_: &Campaign, draw: &mut Draw) -> Effect {
    let (along, across) = (direction(draw), 0.4 * direction(draw));
    let (departure, seed) = (draw.between(-0.1, 0.1), draw.below(1 << 20) as u64);
    let power = wandering(draw, 1.5, [RUN_S, 4.0 * RUN_S], 3);
    let act = in_geo(move |_, run, size| {
        let mains = mains::phase(&run.times, departure, 0.03, 200.0, &mut Draw::new("railway", seed));
        let field = |(p, t): (&f64, &f64)| {
            let (third, notch) = (p / 3.0, 1.0 + 0.05 * power(*t).round());
            (along * third.sin() + across * third.cos()) * (size * notch)
        };
        mains.iter().zip(&run.times).map(field).collect()
    });
    Effect::new("railway power in notches", vec!["traction_power".into()], act)
}
