//! In the coils and their building.

use nalgebra::Vector3;
use std::sync::Arc;

use crate::draw::Draw;
use crate::effect::{Effect, in_geo, named};
use crate::finer::{diffusion, nulling, thermal};
use crate::scene::{Campaign, Run};
use crate::signal::Signal;

/// Field of one ampere of a coil, GEO, nT.
pub(super) fn per_ampere(campaign: &Campaign, coil: usize) -> Vector3<f64> {
    campaign.bench.eta.column(coil) * campaign.bench.coil_nt_per_a[coil]
}

pub(super) fn current(run: &Run, coil: usize) -> Signal {
    run.current(coil).cloned().unwrap_or_else(|| Arc::new(|_| 0.0))
}

/// A plate of metal through which a coil's field diffuses, in eight modes.
pub fn eddy_currents(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let coil = draw.below(3);
    let tau = campaign.runs[0].step_s() * draw.octaves(2.0, 12.0);
    let act = in_geo(move |campaign, run, size| {
        let current = current(run, coil);
        let within = diffusion::within(&current, &run.times, tau, 8.0 * tau);
        let unit = per_ampere(campaign, coil) * -1e-4 * size;
        run.times.iter().zip(within).map(|(t, d)| unit * (current(*t) - d)).collect()
    });
    Effect::new("field that diffuses through metal in eight modes", vec![named("eddy_currents", coil)], act)
}

/// Winding and former warm each other; the former's size is what counts.
pub fn coil_heating(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let coil = draw.below(3);
    let span = campaign.runs[0].step_s() * campaign.runs[0].times.len() as f64;
    let former = span * draw.octaves(0.08, 0.3);
    let act = in_geo(move |campaign, run, size| {
        let current = current(run, coil);
        let first = run.times.first().copied().unwrap_or(0.0);
        let warm = thermal::former_of_coil(&current, first, &run.times, 0.1 * former, former);
        let unit = per_ampere(campaign, coil) * -50e-6 * size;
        run.times.iter().zip(warm).map(|(t, w)| unit * w * current(*t)).collect()
    });
    Effect::new("winding and former of the coil warm each other", vec![named("coil_heating", coil)], act)
}

/// A former that expands, a little behind its thermometer.
pub fn coil_temperature(_: &Campaign, draw: &mut Draw) -> Effect {
    let (coil, ppm) = (draw.below(3), -10.0);
    let act = in_geo(move |campaign, run, size| {
        let step = run.step_s();
        let warm = thermal::core(&run.temperatures[2], &run.times, step, 0.4 * step, 0.2);
        let current = current(run, coil);
        let expanded = |warm: f64| 1.0 / (1.0 - 1e-6 * size * ppm * (warm - campaign.reference_c[2])) - 1.0;
        let unit = per_ampere(campaign, coil);
        run.times.iter().zip(warm).map(|(t, w)| unit * expanded(w) * current(*t)).collect()
    });
    Effect::new("coil's former that expands, a sample late", vec![named("coil_temperature", coil)], act)
        .with(move |size| vec![("coefficient_ppm_per_k", size * ppm)])
}

/// A nulling loop with an integrator, fed with the natural variation; the building's metal sends a share of
/// it to the test volume late.
pub fn nulling(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let shares: [f64; 3] = std::array::from_fn(|_| draw.sign() * draw.between(0.004, 0.01));
    let step = campaign.runs[0].step_s();
    let metal = [step * draw.between(2.0, 5.0), step * draw.between(0.3, 1.0)];
    let act = in_geo(move |_, run, size| {
        let of = |axis: usize| -> Vec<f64> {
            let name = ["outside_x_nt", "outside_y_nt", "outside_z_nt"][axis];
            let Some(outside) = run.column(name) else { return vec![0.0; run.times.len()] };
            nulling::left(outside, &run.times, 0.5, metal, size * shares[axis], 10.0 * metal[0])
        };
        let parts = [0, 1, 2].map(of);
        (0..run.times.len()).map(|row| Vector3::from_fn(|axis, _| parts[axis][row])).collect()
    });
    Effect::new("nulling loop with an integrator, metal between", vec!["nulling_leakage".into()], act).with(
        move |size| {
            let ppm = |axis: usize| 1e6 * size * shares[axis];
            vec![
                ("north_ppm", ppm(0)),
                ("east_ppm", ppm(1)),
                ("down_ppm", ppm(2)),
                ("lag_s", metal[0] + metal[1]),
            ]
        },
    )
}

/// A nulling loop whose amplifier is proportional, behind a building that the variation passes late: a loop
/// of gain G leaves 1/(1 + G) of what comes to it, and is itself G-fold faster than its filter.
pub fn proportional_nulling(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let shares: [f64; 3] = std::array::from_fn(|_| draw.sign() * draw.between(0.004, 0.01));
    let step = campaign.runs[0].step_s();
    let building = [step * draw.between(1.5, 4.0), step * draw.between(0.5, 1.5)];
    let filter = step * draw.between(0.05, 0.3);
    let lag = building.iter().sum::<f64>() - filter;
    let act = in_geo(move |_, run, size| {
        let of = |axis: usize| -> Vec<f64> {
            let name = ["outside_x_nt", "outside_y_nt", "outside_z_nt"][axis];
            let Some(outside) = run.column(name) else { return vec![0.0; run.times.len()] };
            nulling::proportional(outside, &run.times, building, filter, size * shares[axis])
        };
        let parts = [0, 1, 2].map(of);
        (0..run.times.len()).map(|row| Vector3::from_fn(|axis, _| parts[axis][row])).collect()
    });
    Effect::new("proportional nulling loop behind a building", vec!["nulling_leakage".into()], act).with(
        move |size| {
            let ppm = |axis: usize| 1e6 * size * shares[axis];
            vec![("north_ppm", ppm(0)), ("east_ppm", ppm(1)), ("down_ppm", ppm(2)), ("lag_s", lag)]
        },
    )
}
