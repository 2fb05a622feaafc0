//! A circular orbit about the Earth: place, main field, and the frame along the track.

use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Mean radius of the Earth to which the coefficients refer, km.
const RADIUS_KM: f64 = 6371.2;
/// Gravitational parameter of the Earth, km³/s² (IERS Conventions 2010).
const GRAVITATION: f64 = 398_600.441_8;
/// Rotation of the Earth, rad/s (IERS Conventions 2010).
const ROTATION: f64 = 7.292_115e-5;
/// Gauss coefficients g₁⁰, g₁¹, h₁¹ and g₂⁰, g₂¹, h₂¹, g₂², h₂², nT.
///
/// Source: IGRF-13, epoch 2020.0 (Alken et al., Earth Planets Space 73, 49, 2021), degrees 1 and 2.
const FIRST: [f64; 3] = [-29_404.8, -1450.9, 4652.5];
const SECOND: [f64; 5] = [-2499.6, 2982.0, -2991.6, 1677.0, -734.6];

/// A circular orbit without precession.
#[derive(Clone, Copy, Debug)]
pub struct Orbit {
    /// Distance from the centre of the Earth, km.
    radius_km: f64,
    /// Inclination, rad.
    inclination: f64,
    /// Longitude of the ascending node at time zero, rad.
    node: f64,
}

/// Where a satellite is.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Geocentric latitude, rad.
    pub latitude: f64,
    /// Longitude, rad.
    pub longitude: f64,
    /// Distance from the centre of the Earth, km.
    pub radius_km: f64,
    /// Course from north to east, in the frame that does not rotate, rad.
    pub course: f64,
}

impl Orbit {
    /// From height above the mean radius and angles.
    pub fn new(altitude_km: f64, inclination_deg: f64, node_deg: f64) -> Self {
        Self {
            radius_km: RADIUS_KM + altitude_km,
            inclination: inclination_deg.to_radians(),
            node: node_deg.to_radians(),
        }
    }

    /// Time of one revolution, s: 2π √(r³/GM).
    pub fn period_s(&self) -> f64 {
        TAU * (self.radius_km.powi(3) / GRAVITATION).sqrt()
    }

    /// Angle from the ascending node, rad.
    pub fn angle(&self, time_s: f64) -> f64 {
        TAU * time_s / self.period_s()
    }

    /// The place at a time.
    pub fn place(&self, time_s: f64) -> Place {
        let (sin, cos) = self.angle(time_s).sin_cos();
        let (sin_i, cos_i) = self.inclination.sin_cos();
        Place {
            latitude: (sin_i * sin).asin(),
            longitude: self.node + (cos_i * sin).atan2(cos) - ROTATION * time_s,
            radius_km: self.radius_km,
            course: cos_i.atan2(sin_i * cos),
        }
    }
}

/// The main field at a place, north, east and down, nT: −∇V, V = a Σₙ (a/r)ⁿ⁺¹ Σₘ (gₙᵐ cos mλ + hₙᵐ sin mλ)
/// Pₙᵐ(cos θ) with Schmidt's functions up to n = 2.
pub fn main_field_nt(place: &Place) -> Vector3<f64> {
    let (cos, sin) = place.latitude.sin_cos();
    let ((s1, c1), (s2, c2)) = (place.longitude.sin_cos(), (2.0 * place.longitude).sin_cos());
    let root = 3.0_f64.sqrt();
    // For each term g cos mλ + h sin mλ, its derivative by λ, Pₙᵐ, dPₙᵐ/dθ and Pₙᵐ/sin θ.
    let [g10, g11, h11] = FIRST;
    let first = [(g10, 0.0, cos, -sin, 0.0), (g11 * c1 + h11 * s1, h11 * c1 - g11 * s1, sin, cos, 1.0)];
    let [g20, g21, h21, g22, h22] = SECOND;
    let (v21, l21) = (g21 * c1 + h21 * s1, h21 * c1 - g21 * s1);
    let (v22, l22) = (g22 * c2 + h22 * s2, 2.0 * (h22 * c2 - g22 * s2));
    let second = [
        (g20, 0.0, 1.5 * cos * cos - 0.5, -3.0 * sin * cos, 0.0),
        (v21, l21, root * sin * cos, root * (cos * cos - sin * sin), root * cos),
        (v22, l22, 0.5 * root * sin * sin, root * sin * cos, 0.5 * root * sin),
    ];
    let ratio = RADIUS_KM / place.radius_km;
    let of = |n: i32, terms: &[(f64, f64, f64, f64, f64)]| -> Vector3<f64> {
        // North is −θ, down is −r.
        let term = |(value, slope, p, by_angle, over_sine): &(f64, f64, f64, f64, f64)| {
            Vector3::new(value * by_angle, -slope * over_sine, -f64::from(n + 1) * value * p)
        };
        terms.iter().map(term).sum::<Vector3<f64>>() * ratio.powi(n + 2)
    };
    of(1, &first) + of(2, &second)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// V over a at a place.
    fn potential(latitude: f64, longitude: f64, radius_km: f64) -> f64 {
        let (z, s) = latitude.sin_cos();
        let (x, y) = (s * longitude.cos(), s * longitude.sin());
        let ratio = RADIUS_KM / radius_km;
        let root = 3.0_f64.sqrt();
        let [g10, g11, h11] = FIRST;
        let [g20, g21, h21, g22, h22] = SECOND;
        let first = g10 * z + g11 * x + h11 * y;
        let second = g20 * (1.5 * z * z - 0.5)
            + root * z * (g21 * x + h21 * y)
            + 0.5 * root * (g22 * (x * x - y * y) + 2.0 * h22 * x * y);
        ratio.powi(2) * first + ratio.powi(3) * second
    }

    #[test]
    fn the_field_is_the_gradient_of_its_potential() {
        for (latitude, longitude) in [(0.3, 1.1), (-1.2, 4.0), (1.5, -2.0)] {
            let radius_km = 6821.0;
            let place = Place { latitude, longitude, radius_km, course: 0.0 };
            let slope = |dl: f64, dm: f64, dr: f64| {
                let at =
                    |sign: f64| potential(latitude + sign * dl, longitude + sign * dm, radius_km + sign * dr);
                -RADIUS_KM * (at(1.0) - at(-1.0)) / (2.0 * (dl + dm + dr))
            };
            let north = slope(1e-4, 0.0, 0.0) / radius_km;
            let east = slope(0.0, 1e-4, 0.0) / (radius_km * latitude.cos());
            let down = -slope(0.0, 0.0, 0.1);
            let expected = Vector3::new(north, east, down);
            assert!((main_field_nt(&place) - expected).norm() < 1e-3, "{expected}");
        }
    }

    #[test]
    fn the_orbit_closes_and_follows_its_course() {
        let orbit = Orbit::new(450.0, 87.4, 20.0);
        assert!((orbit.period_s() / 60.0 - 93.6).abs() < 0.2, "{}", orbit.period_s());
        for time in [0.0, 700.0, 2000.0, 4100.0] {
            let (a, b) = (orbit.place(time), orbit.place(time + 1.0));
            // The course is that of the track without the rotation of the Earth.
            let east = (b.longitude - a.longitude + ROTATION) * a.latitude.cos();
            let north = b.latitude - a.latitude;
            assert!((east.atan2(north) - a.course).sin().abs() < 0.02, "{time}");
        }
    }
}
