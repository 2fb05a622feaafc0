//! On board.

use nalgebra::Vector3;

use crate::draw::Draw;
use crate::effect::{Effect, in_block};
use crate::finer::plates::{self, Plate};
use crate::scene::Campaign;
use crate::scenes;

/// The loop of an array's current.
pub fn stray_current(_: &Campaign, draw: &mut Draw) -> Effect {
    let field: Vector3<f64> = Vector3::from_fn(|_, _| draw.normal());
    let act = in_block(move |_, run, size| {
        let current = |t: &f64| run.column("panel_current_a").map_or(0.0, |signal| signal(*t));
        run.times.iter().map(|t| field * size * current(t)).collect()
    });
    Effect::new("loop of the array's current", vec!["stray_current panel_current_a".into()], act).with(
        move |size| {
            let names = ["x_nt_per_a", "y_nt_per_a", "z_nt_per_a"];
            names.into_iter().zip(field.iter().map(|f| size * f)).collect()
        },
    )
}

/// Twelve plates that the Sun warms, each with its field.
pub fn sun_warmed(draw: &mut Draw) -> Vec<Plate> {
    let mut vector = |unit: bool| {
        let v: Vector3<f64> = Vector3::from_fn(|_, _| draw.normal());
        let v = if unit { v.normalize() } else { v };
        [v.x, v.y, v.z]
    };
    (0..12).map(|_| Plate { normal: vector(true), field_nt: vector(false) }).collect()
}

/// Currents between unlike metals.
pub fn sun(_: &Campaign, draw: &mut Draw) -> Effect {
    let plates = sun_warmed(draw);
    let act = in_block(move |_, run, size| {
        let tau = 0.5 * run.step_s();
        let field = plates::field(&plates, |t| scenes::sun(run, t), &run.times, tau, 20.0 * tau);
        field.into_iter().map(|b| Vector3::from(b) * size).collect()
    });
    let accepted = vec!["sun_thermoelectric".into(), "sun_thermoelectric_harmonics".into()];
    Effect::new("twelve plates that the Sun warms", accepted, act)
}
