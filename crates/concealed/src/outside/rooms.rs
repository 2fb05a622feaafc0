//! Doors, cranes and wind.

use nalgebra::{Rotation3, Vector3};

use super::means::{direction, moments, span};
use super::walk;
use crate::draw::Draw;
use crate::effect::{Effect, in_geo};
use crate::finer::dipole;
use crate::scene::Campaign;
use crate::signal::wandering;

const ARCSEC: f64 = 4.848e-6;

/// A steel door that people leave at some angle: its moment turns about the vertical with it.
///
/// ```text
/// dB_geo = s dipole(R_z(θ_k) m), t_k <= t < t_(k+1), θ between 0 and 110 degrees
/// ```
///
/// dB and s in nT; it is moved once for every 30 readings.
pub fn door(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let mut moved = moments(campaign, 30, draw);
    moved.sort_by(f64::total_cmp);
    let angles: Vec<f64> = (0..=moved.len()).map(|_| draw.between(0.0, 1.92)).collect();
    let (moment, place) = (direction(draw), direction(draw));
    let act = in_geo(move |_, run, size| {
        let field = |t: &f64| {
            let angle = angles[moved.partition_point(|at| at <= t)];
            dipole::field(&(Rotation3::from_axis_angle(&Vector3::z_axis(), angle) * moment), &place) * size
        };
        run.times.iter().map(field).collect()
    });
    Effect::new("steel door left at some angle", Vec::new(), act)
}

/// A crane that goes to and fro on its rails above the sensors.
///
/// ```text
/// dB_geo = s d³ dipole(m, (x(t), d/2, d)), x a wandering of 2 d rms
/// ```
///
/// dB and s in nT, in units of the distance d; periods of 2 to 15 % of the campaign.
pub fn crane(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let span = span(campaign);
    let (moment, way) = (direction(draw), wandering(draw, 2.0, [0.02 * span, 0.15 * span], 5));
    let act = in_geo(move |_, run, size| {
        let field = |t: &f64| dipole::field(&moment, &Vector3::new(way(*t), 0.5, 1.0)) * size;
        run.times.iter().map(field).collect()
    });
    Effect::new("crane that goes to and fro", Vec::new(), act)
}

/// Wind that leans on the building: the coils' frame turns with the square of its speed.
///
/// ```text
/// dB_geo = s w² n × B_geo, w of mean 0 and variance 1 with the correlation exp(−|t| / tau)
/// ```
///
/// s in seconds of arc, n a horizontal direction, tau between 5 and 20 readings.
///
/// Source: Davenport 1961, The spectrum of horizontal gustiness near the ground, Q. J. R. Meteorol. Soc. 87,
/// 194.
pub fn wind(_: &Campaign, draw: &mut Draw) -> Effect {
    let (rows, seed, angle) =
        (draw.between(5.0, 20.0), draw.below(1 << 20) as u64, draw.between(0.0, std::f64::consts::TAU));
    let about = Vector3::new(angle.cos(), angle.sin(), 0.0);
    let act = in_geo(move |campaign, run, size| {
        let mut gusts = Draw::new(&format!("gusts/{}", run.id), seed);
        let speed = walk::walk(run.times.iter().map(|_| 1.0 / rows), &mut gusts);
        let turned =
            |(t, w): (&f64, f64)| about.cross(&run.field_geo(&campaign.bench, *t)) * (ARCSEC * size * w * w);
        run.times.iter().zip(speed).map(turned).collect()
    });
    Effect::new("wind that leans on the building", Vec::new(), act)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{campaign, field_of};
    use super::*;

    /// A door stands still between two moves.
    #[test]
    fn a_door_stands_between_its_moves() {
        let campaign = campaign(1);
        let added = field_of(&campaign, &door(&campaign, &mut Draw::new("door", 1)));
        let changes = added.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!((10..=added.len() / 30 + 3).contains(&changes), "{changes}");
    }

    /// A crane is never nearer than its rails: within twice the field of a dipole at that distance.
    #[test]
    fn a_crane_stays_on_its_rails() {
        let campaign = campaign(2);
        let most = 2.0 / 1.25_f64.powf(1.5);
        for field in field_of(&campaign, &crane(&campaign, &mut Draw::new("crane", 1))) {
            assert!(Vector3::from(field).norm() <= 1.1 * most);
        }
    }

    /// What the wind adds stands across the field: along it nothing.
    #[test]
    fn wind_turns_and_does_not_stretch() {
        let campaign = campaign(3);
        let effect = wind(&campaign, &mut Draw::new("wind", 1));
        let added = (effect.act)(&campaign, &campaign.plain(), 1.0);
        for (run, added) in campaign.runs.iter().zip(&added) {
            for (row, t) in run.times.iter().enumerate() {
                let turned = Vector3::from_fn(|k, _| added[k][row]);
                let felt = Vector3::from(run.geo_to_sensors(
                    &campaign.bench,
                    *t,
                    &run.field_geo(&campaign.bench, *t),
                ));
                // The sensors' own axes are off a right angle by up to a degree.
                assert!(turned.dot(&felt).abs() <= 0.1 * turned.norm() * felt.norm());
            }
        }
    }
}
