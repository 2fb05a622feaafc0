//! Between two magnetometers.

use nalgebra::Vector3;

use crate::draw::Draw;
use crate::effect::{Effect, in_geo};
use crate::finer::{beside, diffusion, modes};
use crate::scene::{Campaign, World};

/// A conductor below one pillar into which the field diffuses, mostly seen in the vertical component.
pub fn induction(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let tau = campaign.runs[0].step_s() * draw.octaves(5.0, 25.0);
    let (north, east) = (draw.sign() * draw.between(0.004, 0.01), draw.between(-0.006, 0.006));
    let act = in_geo(move |_, run, size| {
        let World::Pair(field) = &run.world else { return vec![Vector3::zeros(); run.times.len()] };
        let faster = |axis: usize| -> Vec<f64> {
            let within = diffusion::within(&field[axis], &run.times, tau, 8.0 * tau);
            run.times.iter().zip(within).map(|(t, d)| field[axis](*t) - d).collect()
        };
        let (x, y) = (faster(0), faster(1));
        let value = |row: usize| size * (north * x[row] + east * y[row]);
        (0..run.times.len()).map(|row| Vector3::new(0.1 * value(row), 0.0, value(row))).collect()
    });
    Effect::new("conductor into which the field diffuses", vec!["induction_difference".into()], act)
}

/// A conducting half space below one pillar: what it keeps of a field has no one time constant.
pub fn half_space(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let tau = campaign.runs[0].step_s() * draw.octaves(6.0, 25.0);
    let (north, east) = (draw.sign() * draw.between(0.004, 0.01), draw.between(-0.006, 0.006));
    let lags = modes::seconds(modes::spread::<9>(0.5, 3.0), tau);
    let act = in_geo(move |_, run, size| {
        let World::Pair(field) = &run.world else { return vec![Vector3::zeros(); run.times.len()] };
        let faster = |axis: usize| -> Vec<f64> {
            let within = beside::lags(&field[axis], &run.times, lags, 8.0 * tau);
            run.times.iter().zip(within).map(|(t, d)| field[axis](*t) - d).collect()
        };
        let (x, y) = (faster(0), faster(1));
        let value = |row: usize| size * (north * x[row] + east * y[row]);
        (0..run.times.len()).map(|row| Vector3::new(0.1 * value(row), 0.0, value(row))).collect()
    });
    Effect::new("conducting half space below one pillar", vec!["induction_difference".into()], act)
}
