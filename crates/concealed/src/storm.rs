//! A magnetic storm in the natural field.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::draw::Draw;
use crate::scene::{Campaign, Run, World};
use crate::signal::{Signal, mixed};

/// A storm in its largest component.
#[derive(Clone, Debug)]
struct Storm {
    /// Its sudden commencement: the moment, s, the height, nT, and how long it takes, s.
    commencement: (f64, f64, f64),
    /// Its main phase: the depth, nT, and the time after the commencement at which it is deepest, s.
    main: (f64, f64),
    /// Pulsations: size, nT, period, s, and phase of each.
    pulsations: Vec<(f64, f64, f64)>,
}

/// Time in which pulsations die away, over that of the main phase.
const DYING: f64 = 1.5;

impl Storm {
    /// At a time, nT, x the time since its commencement:
    ///
    /// ```text
    /// A (1 + tanh(x / w)) / 2 − D u² exp(2 − 2 u) + Σ a_k sin(2π x / P_k + φ_k) min(1, u) exp(−u / 1.5),   u = x / τ > 0
    /// ```
    ///
    /// Source: Gonzalez et al. 1994, What is a geomagnetic storm?, J. Geophys. Res. 99, 5771.
    fn at(&self, t: f64) -> f64 {
        let (moment, height, width) = self.commencement;
        let (depth, deepest) = self.main;
        let since = t - moment;
        let commenced = 0.5 * height * (1.0 + (since / width).tanh());
        let u = (since / deepest).max(0.0);
        let wave = |(size, period, phase): &(f64, f64, f64)| size * (TAU * since / period + phase).sin();
        let pulses = self.pulsations.iter().map(wave).sum::<f64>() * u.min(1.0) * (-u / DYING).exp();
        commenced - depth * (u * u * (2.0 - 2.0 * u).exp()) + pulses
    }

    /// One that commences in the first half of a run: 20 to 60 nT in some minutes, then 100 to 400 nT down
    /// within hours, with pulsations of 40 s to 10 minutes, or eight readings where that is longer.
    fn of(run: &Run, draw: &mut Draw) -> Storm {
        let (step, span) = (run.step_s(), run.step_s() * run.times.len() as f64);
        let begin = run.times.first().copied().unwrap_or(0.0);
        let moment = begin + span * draw.between(0.1, 0.5);
        let wave = |draw: &mut Draw| {
            (draw.between(3.0, 15.0), draw.octaves(40.0, 600.0).max(8.0 * step), draw.between(0.0, TAU))
        };
        Storm {
            commencement: (moment, draw.between(20.0, 60.0), draw.between(60.0, 200.0).max(2.0 * step)),
            main: (draw.between(100.0, 400.0), draw.octaves(3600.0, 14_400.0)),
            pulsations: (0..4).map(|_| wave(draw)).collect(),
        }
    }
}

/// Adds a storm to the natural field of each run: whole in the northern component, a share of it in the
/// others.
pub fn over(campaign: &mut Campaign, draw: &mut Draw) {
    let shares = [1.0, draw.sign() * draw.between(0.1, 0.4), draw.sign() * draw.between(0.2, 0.5)];
    for run in &mut campaign.runs {
        let storm = Storm::of(run, draw);
        let signal: Signal = Arc::new(move |t| storm.at(t));
        let with =
            |quiet: &Signal, axis: usize| mixed(vec![(1.0, quiet.clone()), (shares[axis], signal.clone())]);
        if let World::Natural(field) | World::Pair(field) = &mut run.world {
            *field = std::array::from_fn(|axis| with(&field[axis], axis));
        }
        for (name, column) in &mut run.columns {
            let axis = ["outside_x_nt", "outside_y_nt", "outside_z_nt"].iter().position(|own| own == name);
            if let Some(axis) = axis {
                *column = with(column, axis);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SceneKind;
    use crate::scenes;

    /// Before it nothing, right after it its commencement, at the deepest its depth, and in the end the
    /// commencement alone.
    #[test]
    fn a_storm_goes_through_its_phases() {
        let storm =
            Storm { commencement: (1000.0, 40.0, 10.0), main: (250.0, 7200.0), pulsations: Vec::new() };
        assert!(storm.at(900.0).abs() < 1e-6);
        assert!((storm.at(1060.0) - 40.0).abs() < 0.5);
        assert!((storm.at(8200.0) - (40.0 - 250.0)).abs() < 1e-9);
        assert!((storm.at(1000.0 + 20.0 * 7200.0) - 40.0).abs() < 1e-6);
    }

    /// Hundreds of nT come to the field that is told, on board and of a pair, and to that outside of a site.
    #[test]
    fn a_storm_is_told_in_the_field() {
        for kind in [SceneKind::Site, SceneKind::Craft, SceneKind::Pair] {
            let mut draw = Draw::new("storm", 1);
            let quiet = scenes::of_rows(kind, 600, true, None, &mut draw);
            let mut stormy = quiet.clone();
            over(&mut stormy, &mut draw);
            let run = |campaign: &Campaign, t: f64| match (&campaign.runs[0].world, kind) {
                (_, SceneKind::Site) => {
                    campaign.runs[0].column("outside_x_nt").map_or(0.0, |signal| signal(t))
                }
                (World::Natural(field) | World::Pair(field), _) => field[0](t),
                _ => 0.0,
            };
            let most = quiet.runs[0].times.iter().map(|t| (run(&stormy, *t) - run(&quiet, *t)).abs());
            let most = most.fold(0.0, f64::max);
            assert!((50.0..600.0).contains(&most), "{kind:?}: {most}");
        }
    }
}
