//! The orbit, the Earth's field, the Sun and the shadow.

use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Mean radius of the field's model, and of the orbit, km.
const EARTH_KM: f64 = 6371.2;
const ORBIT_KM: f64 = EARTH_KM + 460.0;
const INCLINATION_DEG: f64 = 87.35;
/// Time of one orbit: 2π √(r³/μ), s.
pub const PERIOD_S: f64 = 5628.0;
/// Drift of the node against the stars, deg a day.
const NODE_DEG_PER_DAY: f64 = -0.31;
const SIDEREAL_DAY_S: f64 = 86_164.1;
/// Day of the year at the beginning: 10 January, counted from the spring equinox before.
const DAYS_FROM_EQUINOX: f64 = 295.5;

/// Gauss coefficients (degree, order, g, h) in nT, to degree 3. Source: Alken et al. 2021, International
/// Geomagnetic Reference Field: the thirteenth generation, Earth Planets Space 73, 49 (epoch 2020).
const GAUSS: [(i32, i32, f64, f64); 9] = [
    (1, 0, -29404.8, 0.0),
    (1, 1, -1450.9, 4652.5),
    (2, 0, -2499.6, 0.0),
    (2, 1, 2982.0, -2991.6),
    (2, 2, 1677.0, -734.6),
    (3, 0, 1363.2, 0.0),
    (3, 1, -2381.2, -82.1),
    (3, 2, 1236.2, 241.9),
    (3, 3, 525.7, -543.4),
];

/// One moment of the orbit.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Time from the beginning, s.
    pub time_s: f64,
    /// The Earth's field, body frame, nT.
    pub field: Vector3<f64>,
    /// The Sun's direction, body frame.
    pub sun: Vector3<f64>,
    /// Whether the Earth hides the Sun.
    pub eclipse: bool,
}

impl Moment {
    /// At a time, for a node that began at a right ascension.
    pub fn at(time_s: f64, node_deg: f64) -> Self {
        let node = (node_deg + NODE_DEG_PER_DAY * time_s / 86_400.0).to_radians();
        let inclination = INCLINATION_DEG.to_radians();
        let argument = TAU * time_s / PERIOD_S;
        let toward_node = Vector3::new(node.cos(), node.sin(), 0.0);
        let normal =
            Vector3::new(inclination.sin() * node.sin(), -inclination.sin() * node.cos(), inclination.cos());
        let across = normal.cross(&toward_node);
        let place = toward_node * argument.cos() + across * argument.sin();
        let velocity = across * argument.cos() - toward_node * argument.sin();
        // Body: x along the velocity, z down, y to the right.
        let body = Matrix3::from_rows(&[
            velocity.transpose(),
            (-place).cross(&velocity).transpose(),
            (-place).transpose(),
        ]);
        let turned = TAU * time_s / SIDEREAL_DAY_S;
        let to_earth =
            Matrix3::new(turned.cos(), turned.sin(), 0.0, -turned.sin(), turned.cos(), 0.0, 0.0, 0.0, 1.0);
        let field = to_earth.transpose() * field_nt(&(to_earth * place * ORBIT_KM));
        let sun = sun(time_s);
        let behind = place.dot(&sun);
        let off_axis_km = (place - sun * behind).norm() * ORBIT_KM;
        Self { time_s, field: body * field, sun: body * sun, eclipse: behind < 0.0 && off_axis_km < EARTH_KM }
    }
}

/// Direction of the Sun among the stars, from its mean longitude along the ecliptic.
fn sun(time_s: f64) -> Vector3<f64> {
    let longitude = TAU * (DAYS_FROM_EQUINOX + time_s / 86_400.0) / 365.2422;
    let tilt = 23.44_f64.to_radians();
    Vector3::new(longitude.cos(), longitude.sin() * tilt.cos(), longitude.sin() * tilt.sin())
}

/// The field at a place fixed to the Earth, nT: B = −∇V by differences over 0.2 km.
fn field_nt(place_km: &Vector3<f64>) -> Vector3<f64> {
    const HALF_KM: f64 = 0.1;
    Vector3::from_fn(|k, _| {
        let mut step = Vector3::zeros();
        step[k] = HALF_KM;
        (potential(&(place_km - step)) - potential(&(place_km + step))) / (2.0 * HALF_KM)
    })
}

/// V = a Σ (a/r)^(n+1) (g cos mφ + h sin mφ) P_n^m(cos θ), Schmidt's quasi-normalisation, nT km.
fn potential(place_km: &Vector3<f64>) -> f64 {
    let r = place_km.norm();
    let (c, longitude) = (place_km.z / r, place_km.y.atan2(place_km.x));
    let s = (1.0 - c * c).sqrt();
    let legendre = |degree: i32, order: i32| match (degree, order) {
        (1, 0) => c,
        (1, 1) => s,
        (2, 0) => (3.0 * c * c - 1.0) / 2.0,
        (2, 1) => 3.0_f64.sqrt() * c * s,
        (2, 2) => 3.0_f64.sqrt() / 2.0 * s * s,
        (3, 0) => c * (5.0 * c * c - 3.0) / 2.0,
        (3, 1) => (3.0_f64 / 8.0).sqrt() * s * (5.0 * c * c - 1.0),
        (3, 2) => (15.0_f64 / 4.0).sqrt() * c * s * s,
        _ => (5.0_f64 / 8.0).sqrt() * s * s * s,
    };
    let term = |(degree, order, g, h): &(i32, i32, f64, f64)| {
        let angle = f64::from(*order) * longitude;
        (EARTH_KM / r).powi(degree + 1) * (g * angle.cos() + h * angle.sin()) * legendre(*degree, *order)
    };
    EARTH_KM * GAUSS.iter().map(term).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the dipole along the axis alone: 2 |g| (a/r)³ down at the pole. With all terms the field has no
    /// sources.
    #[test]
    fn the_field_has_the_size_of_the_dipole_and_no_sources() {
        let pole = field_nt(&Vector3::new(1e-6, 0.0, EARTH_KM));
        let along: f64 = GAUSS.iter().filter(|g| g.1 == 0).map(|(n, _, g, _)| f64::from(n + 1) * g).sum();
        assert!((pole.z / along - 1.0).abs() < 1e-6, "{pole}");
        let place = Vector3::new(3000.0, -4500.0, 4200.0);
        let divergence: f64 = (0..3)
            .map(|k| {
                let mut step = Vector3::zeros();
                step[k] = 5.0;
                (field_nt(&(place + step)) - field_nt(&(place - step)))[k] / 10.0
            })
            .sum();
        assert!(divergence.abs() < 1e-4, "{divergence}");
    }

    #[test]
    fn the_body_looks_down_and_the_period_is_keplers() {
        let kepler = TAU * (ORBIT_KM.powi(3) / 398_600.44).sqrt();
        assert!((PERIOD_S / kepler - 1.0).abs() < 2e-3, "{kepler}");
        let moment = Moment::at(1234.0, 40.0);
        assert!((moment.sun.norm() - 1.0).abs() < 1e-12);
        assert!((20_000.0..60_000.0).contains(&moment.field.norm()));
    }
}
