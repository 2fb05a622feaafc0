//! A theodolite with a single-axis magnetometer on its telescope.
//!
//! Source: E. Kring Lauridsen, Experiences with the DI-fluxgate magnetometer, Danish Meteorological Institute
//! R-71 (1985); the directions as H. Matzka and T. Hansen, Publs. Inst. Geophys. Pol. Acad. Sci. C-99 (2007) 298.

use nalgebra::Vector3;

/// How the magnetometer sits on the telescope.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mounting {
    /// What it reads in no field, nT.
    pub offset_nt: f64,
    /// Angle of its axis to the telescope's across, towards rising azimuth, rad.
    pub horizontal_rad: f64,
    /// The same towards rising zenith angle, rad.
    pub vertical_rad: f64,
}

/// What the magnetometer reads, and how that changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// S = S0 + n·B, nT.
    pub reading_nt: f64,
    /// n, the derivative by the field, north, east and down.
    pub by_field: Vector3<f64>,
    /// By the azimuth, nT/rad.
    pub by_azimuth: f64,
    /// By the zenith angle, nT/rad.
    pub by_zenith: f64,
    /// By the two angles of the mounting, nT/rad.
    pub by_mounting: [f64; 2],
}

/// S = S0 + n·B with n = t + δ h + ε w: the view t = (sin v cos a, sin v sin a, −cos v) north, east and down,
/// the horizontal axis h = ∂t/∂a / sin v, and w = ∂t/∂v. The azimuth a is that of the circle, and the zenith angle v
/// runs to 2π: beyond π the telescope has been turned over, and the magnetometer is below it.
pub fn sighting(field_nt: &Vector3<f64>, azimuth_rad: f64, zenith_rad: f64, mounting: &Mounting) -> Sighting {
    let ((sin_a, cos_a), (sin_v, cos_v)) = (azimuth_rad.sin_cos(), zenith_rad.sin_cos());
    let view = Vector3::new(sin_v * cos_a, sin_v * sin_a, -cos_v);
    let across = Vector3::new(-sin_a, cos_a, 0.0);
    let upward = Vector3::new(cos_v * cos_a, cos_v * sin_a, sin_v);
    let Mounting { offset_nt, horizontal_rad, vertical_rad } = mounting;
    let n = view + across * *horizontal_rad + upward * *vertical_rad;
    Sighting {
        reading_nt: offset_nt + n.dot(field_nt),
        by_field: n,
        by_azimuth: n.x * field_nt.y - n.y * field_nt.x,
        by_zenith: (upward - view * *vertical_rad).dot(field_nt),
        by_mounting: [across.dot(field_nt), upward.dot(field_nt)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_differences() {
        let field = Vector3::new(20_900.0, 1_500.0, 43_800.0);
        let mounting = Mounting { offset_nt: 5.0, horizontal_rad: 1e-3, vertical_rad: -2e-3 };
        let (a, v, step) = (1.3, 4.2, 1e-6);
        let found = sighting(&field, a, v, &mounting);
        let at = |a: f64, v: f64, h: f64, w: f64| {
            let mounting = Mounting { offset_nt: 5.0, horizontal_rad: 1e-3 + h, vertical_rad: -2e-3 + w };
            sighting(&field, a, v, &mounting).reading_nt
        };
        let slopes = [
            at(a + step, v, 0.0, 0.0) - at(a - step, v, 0.0, 0.0),
            at(a, v + step, 0.0, 0.0) - at(a, v - step, 0.0, 0.0),
            at(a, v, step, 0.0) - at(a, v, -step, 0.0),
            at(a, v, 0.0, step) - at(a, v, 0.0, -step),
        ];
        let [h, w] = found.by_mounting;
        for (slope, found) in slopes.iter().zip([found.by_azimuth, found.by_zenith, h, w]) {
            assert!((slope / (2.0 * step) - found).abs() < 1e-3, "{slope} {found}");
        }
    }
}
