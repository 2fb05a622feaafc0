//! Windings of the coils, and the metal about them.

use nalgebra::Vector3;
use std::sync::Arc;

use super::electronics::span;
use super::facility::{current, per_ampere};
use crate::draw::Draw;
use crate::effect::{Act, Effect, in_geo, named};
use crate::finer::{beside, convection, modes, square, turns};
use crate::scene::{Campaign, Run};
use crate::signal::Signal;

/// Two rings of metal about a coil, each with its own time constant.
pub fn two_rings(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let coil = draw.below(3);
    let tau = campaign.runs[0].step_s() * draw.octaves(2.0, 10.0);
    let (quick, share) = (tau * draw.between(0.15, 0.4), draw.between(0.2, 0.45));
    let act = in_geo(move |campaign, run, size| {
        let current = current(run, coil);
        let rings = [(1.0 - share, tau), (share, quick)];
        let within = beside::lags(&current, &run.times, rings, 8.0 * tau);
        let unit = per_ampere(campaign, coil) * -1e-4 * size;
        run.times.iter().zip(within).map(|(t, d)| unit * (current(*t) - d)).collect()
    });
    Effect::new("two rings of metal about the coil", vec![named("eddy_currents", coil)], act)
}

/// A former of ribs and plates beside each other, which the winding warms.
pub fn ribs_and_plates(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let coil = draw.below(3);
    let ribs = span(campaign) / 3.0 * draw.octaves(0.1, 0.3);
    let (plates, share) = (ribs * draw.between(0.2, 0.5), draw.between(0.2, 0.45));
    let act = in_geo(move |campaign, run, size| {
        let current = current(run, coil);
        let heat: Signal = {
            let current = current.clone();
            Arc::new(move |t| current(t).powi(2))
        };
        let warm = beside::lags(&heat, &run.times, [(1.0 - share, ribs), (share, plates)], 0.0);
        let unit = per_ampere(campaign, coil) * -50e-6 * size;
        run.times.iter().zip(warm).map(|(t, warm)| unit * warm * current(*t)).collect()
    });
    Effect::new("ribs and plates of a former that the winding warms", vec![named("coil_heating", coil)], act)
}

/// Places of the sensors in the block as the document has them, SEN, m.
const PLACES_M: [[f64; 3]; 3] = [[0.04, 0.0, 0.01], [0.0, 0.05, 0.0], [0.0, 0.01, -0.04]];

/// What each sensor's place has over the centre of a coil: of the coil, and its field of a size at a place in
/// GEO, m, over that at the centre.
fn away_from_centre(
    coil: usize,
    field: impl Fn(&Vector3<f64>, &Vector3<f64>, f64) -> Vector3<f64> + Send + Sync + 'static,
) -> Act {
    Arc::new(move |campaign: &Campaign, _, size| {
        let axis: Vector3<f64> = campaign.bench.eta.column(coil).into();
        let one = |run: &Run| {
            let current = current(run, coil);
            let turn = (run.attitude)(run.times[0]);
            std::array::from_fn(|sensor| {
                let place = turn.transpose() * Vector3::from(PLACES_M[sensor]);
                let over = turn * (field(&axis, &place, size) - axis);
                let seen = run.sensor_axis(&campaign.bench, sensor).dot(&over);
                let strength = |t: &f64| campaign.bench.coil_nt_per_a[coil] * current(*t);
                run.times.iter().map(|t| seen * strength(t)).collect()
            })
        };
        campaign.runs.iter().map(one).collect()
    })
}

/// Helmholtz's pair whose windings have not quite the same number of turns.
pub fn unequal_turns(_: &Campaign, draw: &mut Draw) -> Effect {
    let (coil, radius, sign) = (draw.below(3), draw.between(1.6, 2.4), draw.sign());
    let excess = move |size: f64| 1e-3 * sign * size;
    let act = away_from_centre(coil, move |axis, place, size| turns::pair(axis, place, radius, excess(size)));
    Effect::new("pair of windings with unequal turns", vec![named("coil_gradient", coil)], act)
        .with(move |size| vec![("gradient_ppm_per_m", 1e6 * turns::gradient(radius, excess(size)))])
}

/// A pair of square windings with unequal turns.
pub fn square_windings(_: &Campaign, draw: &mut Draw) -> Effect {
    let (coil, side, sign) = (draw.below(3), draw.between(1.8, 3.0), draw.sign());
    let excess = move |size: f64| 1e-3 * sign * size;
    let act = away_from_centre(coil, move |axis, place, size| square::pair(axis, place, side, excess(size)));
    Effect::new("pair of square windings with unequal turns", vec![named("coil_gradient", coil)], act)
        .with(move |size| vec![("gradient_ppm_per_m", 1e6 * square::gradient(side, excess(size)))])
}

/// Round rods of metal about a coil, into which its field diffuses.
pub fn rods(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let coil = draw.below(3);
    let tau = campaign.runs[0].step_s() * draw.octaves(3.0, 12.0);
    let lags = modes::seconds(modes::rod(), tau);
    let act = in_geo(move |campaign, run, size| {
        let current = current(run, coil);
        let within = beside::lags(&current, &run.times, lags, 8.0 * tau);
        let unit = per_ampere(campaign, coil) * -1e-4 * size;
        run.times.iter().zip(within).map(|(t, d)| unit * (current(*t) - d)).collect()
    });
    Effect::new("round rods of metal about the coil", vec![named("eddy_currents", coil)], act)
}

/// A winding that still air cools, cold at the beginning of each run.
pub fn winding_in_still_air(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let coil = draw.below(3);
    let tau = span(campaign) / 3.0 * draw.octaves(0.08, 0.25);
    let act = in_geo(move |campaign, run, size| {
        let current = current(run, coil);
        let heat: Signal = {
            let current = current.clone();
            Arc::new(move |t| current(t).powi(2))
        };
        let warm = convection::heated(&heat, &run.times, tau);
        let unit = per_ampere(campaign, coil) * -50e-6 * size;
        run.times.iter().zip(warm).map(|(t, warm)| unit * warm * current(*t)).collect()
    });
    Effect::new("winding that still air cools", vec![named("coil_heating", coil)], act)
}
