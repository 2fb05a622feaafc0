//! A circular orbit about the Earth: place, main field, and the frame along the track.

use mainfield::RADIUS_KM;
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Gravitational parameter of the Earth, km³/s² (IERS Conventions 2010).
const GRAVITATION: f64 = 398_600.441_8;
/// Rotation of the Earth, rad/s (IERS Conventions 2010).
const ROTATION: f64 = 7.292_115e-5;
/// Gauss coefficients g₁⁰, g₁¹, h₁¹, g₂⁰, g₂¹, h₂¹, g₂², h₂², nT.
///
/// Source: IGRF-13, epoch 2020.0 (Alken et al., Earth Planets Space 73, 49, 2021), degrees 1 and 2.
const COEFFICIENTS: [f64; 8] = [-29_404.8, -1450.9, 4652.5, -2499.6, 2982.0, -2991.6, 1677.0, -734.6];

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

/// The main field at a place, north, east and down, nT, up to degree 2.
pub fn main_field_nt(place: &Place) -> Vector3<f64> {
    mainfield::synthesis(&COEFFICIENTS, place.latitude, place.longitude, place.radius_km).into()
}

#[cfg(test)]
mod tests {
    use super::*;

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
