//! On board.

use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::sync::Arc;

use crate::draw::Draw;
use crate::effect::{Effect, in_block};
use crate::finer::plates::{self, Plate};
use crate::finer::rotor::Rotor;
use crate::finer::{beside, bodies, ode};
use crate::scene::{Campaign, Run};
use crate::scenes::{self, WHEEL};
use crate::signal::Signal;

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

/// The loop of an array's current, and what it induces in the metal about it.
pub fn loop_in_metal(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (field, metal) =
        (Vector3::from_fn(|_, _| draw.normal()), Vector3::from_fn(|_, _| 0.1 * draw.normal()));
    let tau = campaign.runs[0].step_s() * draw.octaves(0.5, 3.0);
    let act = in_block(move |_, run, size| {
        let Some(current) = run.column("panel_current_a") else {
            return vec![Vector3::zeros(); run.times.len()];
        };
        let late = bodies::last(current, &run.times, [tau], 8.0 * tau);
        let of = |(t, late): (&f64, f64)| {
            let now = current(*t);
            (field * now + metal * (now - late)) * size
        };
        run.times.iter().zip(late).map(of).collect()
    });
    Effect::new("loop of the array's current in metal", vec!["stray_current panel_current_a".into()], act)
        .with(move |size| {
            let names = ["x_nt_per_a", "y_nt_per_a", "z_nt_per_a"];
            names.into_iter().zip(field.iter().map(|f: &f64| size * f)).collect()
        })
}

/// A body that the Sun warms through and through, its skin and what is behind it: linear in the Sun's
/// direction, and late.
pub fn skin_and_body(_: &Campaign, draw: &mut Draw) -> Effect {
    let parts: [Vector3<f64>; 4] = std::array::from_fn(|_| Vector3::from_fn(|_, _| draw.normal()));
    let share = draw.between(0.15, 0.35);
    let act = in_block(move |_, run, size| {
        let step = run.step_s();
        let warmed = |of: fn([f64; 3]) -> f64| {
            let own = run.clone();
            let taken: Signal = Arc::new(move |t| of(scenes::sun(&own, t)));
            beside::lags(&taken, &run.times, [(1.0 - share, 0.4 * step), (share, 4.0 * step)], 20.0 * step)
        };
        let lit = |s: [f64; 3]| s.iter().map(|x| x * x).sum::<f64>();
        let courses = [warmed(lit), warmed(|s| s[0]), warmed(|s| s[1]), warmed(|s| s[2])];
        let of = |row: usize| {
            courses.iter().zip(&parts).map(|(course, part)| part * course[row]).sum::<Vector3<f64>>()
        };
        (0..run.times.len()).map(|row| of(row) * size).collect()
    });
    let accepted = vec!["sun_thermoelectric".into(), "sun_thermoelectric_harmonics".into()];
    Effect::new("skin and body that the Sun warms", accepted, act)
}

/// What a glossy plate takes in of the Sun at a cosine of its incidence: less of what comes flat than
/// Lambert's law has.
fn glossy(cosine: f64) -> f64 {
    cosine.max(0.0).powf(1.5)
}

/// Twelve glossy plates, warm within a part of a step.
pub fn glossy_plates(_: &Campaign, draw: &mut Draw) -> Effect {
    let plates = sun_warmed(draw);
    let act = in_block(move |_, run, size| {
        let tau = 0.5 * run.step_s();
        let mut sum = vec![Vector3::zeros(); run.times.len()];
        for plate in &plates {
            let (own, normal) = (run.clone(), Vector3::from(plate.normal));
            let taken: Signal = Arc::new(move |t| glossy(normal.dot(&Vector3::from(scenes::sun(&own, t)))));
            let warm = bodies::last(&taken, &run.times, [tau], 20.0 * tau);
            sum.iter_mut().zip(warm).for_each(|(sum, w)| *sum += Vector3::from(plate.field_nt) * (w * size));
        }
        sum
    });
    let accepted = vec!["sun_thermoelectric_harmonics".into(), "sun_thermoelectric".into()];
    Effect::new("twelve glossy plates that the Sun warms", accepted, act)
}

/// The wheel's turns at the rows of a run, in rad: 2π ∫ f dt.
fn turned(run: &Run) -> Vec<f64> {
    let Some(speed) = run.column(WHEEL) else { return vec![0.0; run.times.len()] };
    let first = run.times.first().copied().unwrap_or(0.0);
    let states = ode::march(first, [0.0], &run.times, run.step_s(), |t, _| [TAU * speed(t)]);
    states.iter().map(|phase| phase[0]).collect()
}

fn rotor(draw: &mut Draw) -> Rotor {
    let mut unit = || Vector3::from_fn(|_, _| draw.normal()).normalize();
    let (place, axle) = (unit(), unit());
    let first = axle.cross(&unit()).normalize();
    Rotor { place, across: [first, axle.cross(&first)], radius: draw.between(0.05, 0.12) }
}

/// A magnet on the rim of a wheel.
pub fn magnet_on_a_wheel(_: &Campaign, draw: &mut Draw) -> Effect {
    let (rotor, begin) = (rotor(draw), draw.between(0.0, TAU));
    let act = in_block(move |_, run, size| {
        turned(run).into_iter().map(|phase| rotor.one(begin + phase) * size).collect()
    });
    Effect::new("magnet on the rim of a wheel", vec![format!("reaction_wheel {WHEEL}")], act)
}

/// Two magnets on the rim of a wheel, opposite each other.
pub fn two_magnets_on_a_wheel(_: &Campaign, draw: &mut Draw) -> Effect {
    let (rotor, begin) = (rotor(draw), draw.between(0.0, TAU));
    let act = in_block(move |_, run, size| {
        turned(run).into_iter().map(|phase| rotor.two(begin + phase) * (10.0 * size)).collect()
    });
    Effect::new("two magnets on the rim of a wheel", vec![format!("reaction_wheel_harmonic {WHEEL}")], act)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SceneKind;
    use crate::scenes::Length;

    /// A plate is glossy as Fresnel has it at least in this: what comes straight is taken in whole, and what
    /// comes flat less than its cosine.
    #[test]
    fn a_glossy_plate_takes_less_of_what_comes_flat() {
        assert_eq!([glossy(1.0), glossy(0.0), glossy(-0.4)], [1.0, 0.0, 0.0]);
        assert!((glossy(0.25) - 0.125).abs() < 1e-12);
    }

    /// The phase grows by the wheel's speed: its derivative is 2π f.
    #[test]
    fn a_wheel_turns_at_its_speed() {
        let campaign =
            scenes::campaign(SceneKind::Craft, Length::Short, true, Some(0.5), &mut Draw::new("wheel", 1));
        let run = &campaign.runs[0];
        let speed = run.column(WHEEL).expect("a wheel");
        let phase = turned(run);
        for row in 1..phase.len() - 1 {
            let rate = (phase[row + 1] - phase[row - 1]) / (run.times[row + 1] - run.times[row - 1]);
            assert!((rate / (TAU * speed(run.times[row])) - 1.0).abs() < 1e-3);
        }
    }
}
