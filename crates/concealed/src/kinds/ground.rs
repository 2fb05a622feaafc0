//! Ground and pillars that tilt.

use nalgebra::{Rotation3, Vector3};

use super::age::{self, DAY_S};
use super::electronics::span;
use super::lagging;
use super::sensor::ARCSEC;
use crate::draw::Draw;
use crate::effect::{Effect, in_block};
use crate::finer::bodies;
use crate::scene::{Campaign, Run};

/// What the sensors gain when the block turns by angles about x and y, rad: the whole rotation, whose first
/// order is −ω × B.
fn turned(campaign: &Campaign, run: &Run, t: f64, angles: [f64; 2]) -> Vector3<f64> {
    let field = run.field_sen(&campaign.bench, t);
    Rotation3::new(-Vector3::new(angles[0], angles[1], 0.0)) * field - field
}

/// A block on a foundation whose tiltmeters are mounted a few degrees askew, and which follows them within
/// two steps of time.
pub fn measured_tilt(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (askew, tau) =
        (draw.sign() * draw.between(0.02, 0.06), campaign.runs[0].step_s() * draw.between(0.5, 2.0));
    let act = in_block(move |campaign, run, size| {
        let tilt = |name: &str| match run.column(name) {
            Some(signal) => bodies::last(signal, &run.times, [tau], 10.0 * tau),
            None => vec![0.0; run.times.len()],
        };
        let (x, y) = (tilt("tilt_x_rad"), tilt("tilt_y_rad"));
        let (sin, cos) = askew.sin_cos();
        let of = |row: usize| {
            let angles = [cos * x[row] - sin * y[row], sin * x[row] + cos * y[row]];
            turned(campaign, run, run.times[row], angles.map(|angle| size * angle))
        };
        (0..run.times.len()).map(of).collect()
    });
    Effect::new("block that tilts beside tiltmeters mounted askew", vec!["measured_tilt".into()], act)
        .with(move |size| vec![("gain_ppm", 1e6 * size * askew.cos())])
}

/// A pillar into which the heat diffuses.
pub fn pillar_tilt(campaign: &Campaign, draw: &mut Draw) -> Effect {
    tilted_by(campaign, draw, "pillar into which the heat diffuses", lagging::diffusion)
}

fn tilted_by(campaign: &Campaign, draw: &mut Draw, physics: &'static str, law: lagging::Law) -> Effect {
    let tilts = [draw.sign() * draw.between(0.4, 1.0), draw.sign() * draw.between(0.4, 1.0)];
    let heat = law(campaign, draw, 0);
    let (course, lag) = (heat.course, heat.lag_s.unwrap_or_default());
    let act = in_block(move |campaign, run, size| {
        let warm = course(campaign, run);
        let angles = |warm: f64| tilts.map(|tilt| ARCSEC * size * tilt * warm);
        run.times.iter().zip(warm).map(|(t, warm)| turned(campaign, run, *t, angles(warm))).collect()
    });
    Effect::new(physics, vec!["pillar_tilt".into()], act).with(move |size| {
        let [x, y] = tilts.map(|tilt| size * tilt);
        vec![("about_x_arcsec_per_k", x), ("about_y_arcsec_per_k", y), ("lag_s", lag)]
    })
}

/// A foundation that settles with the logarithm of its age, as clay does.
pub fn pillar_settling(campaign: &Campaign, draw: &mut Draw) -> Effect {
    settled(campaign, draw, "foundation that settles with the logarithm of its age", age::logarithm)
}

fn settled(
    campaign: &Campaign,
    draw: &mut Draw,
    physics: &'static str,
    law: fn(f64, &mut Draw) -> age::Course,
) -> Effect {
    let tilts = [draw.sign() * draw.between(2.0, 5.0), draw.sign() * draw.between(2.0, 5.0)];
    let span = span(campaign);
    let course = law(span, draw);
    let act = in_block(move |campaign, run, size| {
        let angles = |t: f64| tilts.map(|tilt| ARCSEC * size * tilt * course(t));
        run.times.iter().map(|t| turned(campaign, run, *t, angles(*t))).collect()
    });
    Effect::new(physics, vec!["pillar_settling".into()], act).with(move |size| {
        let [x, y] = tilts.map(|tilt| size * tilt * DAY_S / span);
        vec![("about_x_arcsec_per_day", x), ("about_y_arcsec_per_day", y)]
    })
}

/// Tilt that a bubble reads as θ_0 tanh(θ / θ_0), undone.
fn straightened(read: f64, range: f64) -> f64 {
    range * (read / range).clamp(-0.99, 0.99).atanh()
}

/// A block whose tiltmeters are bubbles that come to their ends.
pub fn bubbles(_: &Campaign, draw: &mut Draw) -> Effect {
    let range = draw.between(6e-5, 1e-4);
    let act = in_block(move |campaign, run, size| {
        let tilt = |name: &str, t: f64| run.column(name).map_or(0.0, |signal| straightened(signal(t), range));
        let of = |t: &f64| {
            let angles = [tilt("tilt_x_rad", *t), tilt("tilt_y_rad", *t)].map(|angle| size * angle);
            turned(campaign, run, *t, angles)
        };
        run.times.iter().map(of).collect()
    });
    Effect::new("block that tilts beside bubbles that come to their ends", vec!["measured_tilt".into()], act)
}

/// A round pillar into which the heat diffuses.
pub fn round_pillar(campaign: &Campaign, draw: &mut Draw) -> Effect {
    tilted_by(campaign, draw, "round pillar into which the heat diffuses", lagging::rod)
}

/// Clay that is pressed out below a foundation: in the beginning with the root of time (Terzaghi).
pub fn consolidation(campaign: &Campaign, draw: &mut Draw) -> Effect {
    settled(campaign, draw, "clay that is pressed out below a foundation", age::root)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bubble_is_straightened() {
        for tilt in [-1.5e-4, -1e-5, 0.0, 3e-5] {
            let read = 8e-5 * f64::tanh(tilt / 8e-5);
            assert!((straightened(read, 8e-5) - tilt).abs() < 1e-15);
        }
    }
}
