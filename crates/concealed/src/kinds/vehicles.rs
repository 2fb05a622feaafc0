//! Vehicles that are not one dipole on a straight line.

use nalgebra::{Rotation3, Vector3};

use super::environment::direction;
use crate::draw::Draw;
use crate::effect::{Effect, in_geo};
use crate::finer::dipole;
use crate::scene::Campaign;

/// When it is nearest, s, how far away, m, its speed, m/s, and how high above the sensors, m.
fn pass(campaign: &Campaign, draw: &mut Draw) -> (f64, f64, f64, f64) {
    let times = &campaign.runs[0].times;
    let at = times[(times.len() as f64 * draw.between(0.3, 0.7)) as usize];
    (at, draw.between(40.0, 90.0), draw.between(1.5, 3.0), draw.between(-2.0, 2.0))
}

/// A lorry on a straight road: engine and axle are dipoles of their own.
pub fn two_dipoles(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (at, distance, speed, height) = pass(campaign, draw);
    let (half, moments) = (draw.between(4.0, 9.0), [direction(draw), direction(draw)]);
    let act = in_geo(move |_, run, size| {
        let field = |t: &f64| -> Vector3<f64> {
            let way = speed * (t - at);
            let place = |along: f64| Vector3::new(way + along, distance, height);
            let both = dipole::field(&moments[0], &place(half)) + dipole::field(&moments[1], &place(-half));
            // Moments whose field at the nearest point is of the order of 1 nT.
            both * size * distance.powi(3)
        };
        run.times.iter().map(field).collect()
    });
    Effect::new("two dipoles on a straight road", vec!["vehicle_pass".into()], act)
}

/// Where a vehicle is that drives round a bend of a radian, and its heading, rad: the bend's radius and the
/// way from its middle, m.
fn bend(radius: f64, way: f64) -> (f64, f64, f64) {
    let heading = (way / radius).clamp(-0.5, 0.5);
    let beyond = way - radius * heading;
    let (sin, cos) = heading.sin_cos();
    (radius * sin + beyond * cos, radius * (1.0 - cos) + beyond * sin, heading)
}

/// A car that drives round a bend: its moment turns with it.
pub fn round_a_bend(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (at, distance, speed, height) = pass(campaign, draw);
    let (radius, moment) = (draw.between(40.0, 120.0), direction(draw));
    let act = in_geo(move |_, run, size| {
        let field = |t: &f64| -> Vector3<f64> {
            let (along, away, heading) = bend(radius, speed * (t - at));
            let moment = Rotation3::from_axis_angle(&Vector3::z_axis(), heading) * moment;
            let place = Vector3::new(along, distance + away, height);
            dipole::field(&moment, &place) * size * distance.powi(3)
        };
        run.times.iter().map(field).collect()
    });
    Effect::new("dipole that turns as it drives round a bend", vec!["vehicle_pass".into()], act)
}

/// A short train: five magnetised wagons behind each other, each with its own moment beside the common one.
pub fn wagons(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (at, distance, speed, height) = pass(campaign, draw);
    let (length, common) = (draw.between(3.0, 6.0), direction(draw));
    let wagons: Vec<(f64, Vector3<f64>)> =
        (-2..=2).map(|k| (length * f64::from(k), (common + 0.5 * direction(draw)) / 5.0)).collect();
    let act = in_geo(move |_, run, size| {
        let field = |t: &f64| -> Vector3<f64> {
            let way = speed * (t - at);
            let one = |(along, moment): &(f64, Vector3<f64>)| {
                dipole::field(moment, &Vector3::new(way + along, distance, height))
            };
            wagons.iter().map(one).sum::<Vector3<f64>>() * size * distance.powi(3)
        };
        run.times.iter().map(field).collect()
    });
    Effect::new("five wagons on a straight line", vec!["vehicle_pass".into()], act)
}

/// Way of a vehicle that slows down about a moment and goes on, m: v (t − a w tanh(t/w)), its least speed (1
/// − a) v.
fn slowed(since: f64, speed: f64, slower: f64, width: f64) -> f64 {
    speed * (since - slower * width * (since / width).tanh())
}

/// A lorry that slows down at a crossing, somewhere near the sensors, and goes on.
pub fn at_a_crossing(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (at, distance, speed, height) = pass(campaign, draw);
    let (slower, moment) = (draw.between(0.3, 0.6), direction(draw));
    let width = distance / speed * draw.between(0.3, 0.8);
    let crossing = distance / speed * draw.between(-0.6, 0.6);
    let act = in_geo(move |_, run, size| {
        let field = |t: &f64| -> Vector3<f64> {
            let way = slowed(t - at - crossing, speed, slower, width) + speed * crossing;
            dipole::field(&moment, &Vector3::new(way, distance, height)) * size * distance.powi(3)
        };
        run.times.iter().map(field).collect()
    });
    Effect::new("dipole that slows down at a crossing", vec!["vehicle_pass".into()], act)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The way goes on without a jump or a kink, and its length is that of the way.
    #[test]
    fn a_bend_is_driven_at_an_even_speed() {
        for way in [-200.0, -30.0, -5.0, 0.0, 29.99, 30.01, 80.0] {
            let ((x, y, _), (next_x, next_y, heading)) = (bend(60.0, way), bend(60.0, way + 1e-3));
            let (dx, dy) = (next_x - x, next_y - y);
            assert!((dx.hypot(dy) / 1e-3 - 1.0).abs() < 1e-6, "{way}");
            assert!((dy.atan2(dx) - heading).abs() < 1e-3, "{way}");
        }
    }

    /// Far from the crossing it goes at its speed, at it at the least one.
    #[test]
    fn a_vehicle_slows_down_and_goes_on() {
        let speed = |t: f64| (slowed(t + 1e-3, 3.0, 0.4, 20.0) - slowed(t - 1e-3, 3.0, 0.4, 20.0)) / 2e-3;
        assert!((speed(0.0) - 1.8).abs() < 1e-6);
        assert!((speed(300.0) - 3.0).abs() < 1e-6 && (speed(-300.0) - 3.0).abs() < 1e-6);
    }
}
