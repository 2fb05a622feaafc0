//! The Earth's main field, by the models that the field's institutions publish.

mod frames;
mod harmonics;

pub use frames::{Celestial, itrf_to_geo, leap_s};
pub use harmonics::{RADIUS_KM, synthesis};

use nalgebra::Vector3;
use std::fmt;

/// Equatorial radius of the ellipsoid WGS 84, km; with f = 1/298.257223563.
pub const EQUATOR_KM: f64 = 6378.137;
/// Square of its eccentricity.
const E2: f64 = (2.0 - 1.0 / 298.257_223_563) / 298.257_223_563;

/// The normal of the ellipsoid at a geodetic latitude, rad, down to the axis, km.
fn normal_km(latitude: f64) -> f64 {
    EQUATOR_KM / (1.0 - E2 * latitude.sin().powi(2)).sqrt()
}

/// A published model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Model {
    /// International Geomagnetic Reference Field, 14th generation: 1900 to 2030.
    #[default]
    Igrf14,
    /// World Magnetic Model 2025: 2025 to 2030.
    Wmm2025,
}

/// A place on the ellipsoid WGS 84.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Geodetic latitude, degrees.
    pub latitude_deg: f64,
    /// Longitude, degrees east.
    pub longitude_deg: f64,
    /// Height above the ellipsoid, m.
    pub height_m: f64,
}

/// A model at one moment.
#[derive(Clone, Debug)]
pub struct AtYear(Vec<f64>);

/// Coefficients in the order of [`synthesis`], nT, at some years; between them they are on straight lines.
struct Coefficients {
    years: Vec<f64>,
    /// For each coefficient its values at the years.
    values: Vec<Vec<f64>>,
}

impl Model {
    /// All models.
    pub const ALL: [Self; 2] = [Self::Igrf14, Self::Wmm2025];

    /// Its name, as options have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Igrf14 => "igrf14",
            Self::Wmm2025 => "wmm2025",
        }
    }

    /// Standard uncertainty of the magnitude at the surface, nT: what the crust and currents above add, in the mean
    /// over the Earth.
    ///
    /// Source: Chulliat et al., The US/UK World Magnetic Model for 2025-2030, table of the global average errors. It
    /// serves for both models: crust and currents are missing from both.
    pub const MAGNITUDE_STD_NT: f64 = 138.0;

    /// The years in which it holds.
    pub fn years(self) -> [f64; 2] {
        match self {
            Self::Igrf14 => [1900.0, 2030.0],
            Self::Wmm2025 => [2025.0, 2030.0],
        }
    }

    /// The field north, east and down (geodetic) at a place in a decimal year, nT; None outside its years.
    pub fn field_nt(self, place: &Place, year: f64) -> Option<[f64; 3]> {
        Some(self.at(year)?.field_nt(place))
    }

    /// The model in a decimal year; None outside its years.
    pub fn at(self, year: f64) -> Option<AtYear> {
        let [from, to] = self.years();
        (year >= from && year <= to).then(|| AtYear(self.coefficients().at(year)))
    }

    fn coefficients(self) -> Coefficients {
        match self {
            Self::Igrf14 => igrf(include_str!("../models/igrf14.shc")),
            Self::Wmm2025 => wmm(include_str!("../models/wmm2025.cof")),
        }
    }
}

impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Igrf14 => "IGRF-14",
            Self::Wmm2025 => "WMM2025",
        })
    }
}

impl Place {
    /// Of a vector from the centre in ITRF, km.
    pub fn of_itrf(vector_km: &Vector3<f64>) -> Self {
        let across = vector_km.xy().norm();
        let mut latitude = vector_km.z.atan2((1.0 - E2) * across);
        for _ in 0..6 {
            latitude = (vector_km.z + E2 * normal_km(latitude) * latitude.sin()).atan2(across);
        }
        let (sin, cos) = latitude.sin_cos();
        let height_km = across * cos + vector_km.z * sin - EQUATOR_KM * EQUATOR_KM / normal_km(latitude);
        let longitude_deg = vector_km.y.atan2(vector_km.x).to_degrees();
        Self { latitude_deg: latitude.to_degrees(), longitude_deg, height_m: 1000.0 * height_km }
    }

    /// Geocentric latitude, rad, and distance from the centre, km.
    fn geocentric(&self) -> (f64, f64) {
        let latitude = self.latitude_deg.to_radians();
        let ((sin, cos), normal_km) = (latitude.sin_cos(), normal_km(latitude));
        let height_km = self.height_m / 1000.0;
        let (across, up) = ((normal_km + height_km) * cos, (normal_km * (1.0 - E2) + height_km) * sin);
        (up.atan2(across), across.hypot(up))
    }
}

impl AtYear {
    /// The field north, east and down (geodetic) at a place, nT.
    pub fn field_nt(&self, place: &Place) -> [f64; 3] {
        let (latitude, radius_km) = place.geocentric();
        let [north, east, down] = synthesis(&self.0, latitude, place.longitude_deg.to_radians(), radius_km);
        // From the vertical of the sphere to that of the ellipsoid.
        let (sin, cos) = (latitude - place.latitude_deg.to_radians()).sin_cos();
        [north * cos - down * sin, east, north * sin + down * cos]
    }
}

impl Coefficients {
    fn at(&self, year: f64) -> Vec<f64> {
        let after = self.years.partition_point(|known| *known <= year).clamp(1, self.years.len() - 1);
        let (from, to) = (self.years[after - 1], self.years[after]);
        let share = (year - from) / (to - from);
        let between = |values: &Vec<f64>| values[after - 1] + share * (values[after] - values[after - 1]);
        self.values.iter().map(between).collect()
    }
}

fn numbers(text: &str) -> impl Iterator<Item = Vec<f64>> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| line.split_whitespace().filter_map(|word| word.parse().ok()).collect())
}

/// IAGA's file: a line of what it holds, one of its years, then n, m (negative: h) and the values at each year.
fn igrf(text: &str) -> Coefficients {
    let mut lines = numbers(text).skip(1);
    let years = lines.next().unwrap_or_default();
    Coefficients { years, values: lines.map(|line| line[2..].to_vec()).collect() }
}

/// NOAA's file: the epoch, then n, m, g, h and their changes in a year; a line of nines ends it.
fn wmm(text: &str) -> Coefficients {
    let years = Model::Wmm2025.years();
    let mut values = Vec::new();
    for line in numbers(text).filter(|line| line.len() == 6) {
        let [_, m, g, h, g_per_year, h_per_year] = line[..] else { continue };
        let span = years[1] - years[0];
        values.push(vec![g, g + span * g_per_year]);
        if m > 0.0 {
            values.push(vec![h, h + span * h_per_year]);
        }
    }
    Coefficients { years: years.to_vec(), values }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: [f64; 3], expected: [f64; 3], within: f64) -> bool {
        found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= within)
    }

    /// The test values that NOAA publishes with the coefficients: year, height km, latitude, longitude; X, Y, Z.
    #[test]
    fn wmm_is_that_of_its_published_test_values() {
        let published = [
            ([2025.0, 0.0, 80.0, 0.0], [6521.6, 145.9, 54_791.5]),
            ([2025.0, 0.0, 0.0, 120.0], [39_677.8, -109.6, -10_580.2]),
            ([2025.0, 0.0, -80.0, 240.0], [6117.5, 15_751.9, -52_022.5]),
            ([2025.0, 100.0, 80.0, 0.0], [6216.0, 92.4, 52_598.8]),
            ([2025.0, 100.0, 0.0, 120.0], [37_688.6, -96.2, -10_152.1]),
            ([2025.0, 100.0, -80.0, 240.0], [5907.6, 14_780.3, -49_540.7]),
            ([2027.5, 0.0, 80.0, 0.0], [6500.8, 294.5, 54_869.4]),
            ([2027.5, 0.0, 0.0, 120.0], [39_701.6, -167.4, -10_381.8]),
            ([2027.5, 0.0, -80.0, 240.0], [6200.7, 15_730.3, -51_783.7]),
            ([2027.5, 100.0, 80.0, 0.0], [6196.7, 233.8, 52_670.5]),
            ([2027.5, 100.0, 0.0, 120.0], [37_711.5, -148.7, -9969.8]),
            ([2027.5, 100.0, -80.0, 240.0], [5984.0, 14_760.1, -49_317.7]),
        ];
        for ([year, height_km, latitude_deg, longitude_deg], expected) in published {
            let place = Place { latitude_deg, longitude_deg, height_m: 1000.0 * height_km };
            let found = Model::Wmm2025.field_nt(&place, year).expect("within its years");
            assert!(near(found, expected, 0.051), "{year} {place:?}: {found:?}");
        }
    }

    /// Made by fixtures/reference/igrf.py, which counts days where decimal years are counted here.
    #[test]
    fn igrf_is_that_of_another_program() {
        let other = [
            ([1905.0, 1.087, 47.93, 15.865], [20_740.433, -2938.146, 40_685.778]),
            ([1979.5, 0.35, 33.0, -110.0], [24_808.846, 5379.930, 43_833.821]),
            ([2014.25, 0.01, -65.25, -64.25], [19_895.977, 5797.783, -32_616.011]),
            ([2022.75, 0.0, 89.9, 30.0], [1427.134, 1159.520, 56_786.300]),
            ([2027.5, 500.0, 0.0, 179.5], [26_367.549, 4534.589, -3105.286]),
        ];
        for ([year, height_km, latitude_deg, longitude_deg], expected) in other {
            let place = Place { latitude_deg, longitude_deg, height_m: 1000.0 * height_km };
            let found = Model::Igrf14.field_nt(&place, year).expect("within its years");
            assert!(near(found, expected, 0.05), "{year} {place:?}: {found:?}");
        }
        let pole = Place { latitude_deg: 90.0, longitude_deg: 0.0, height_m: 0.0 };
        assert!(
            Model::Igrf14.field_nt(&pole, 2030.0).is_some_and(|field| field.iter().all(|b| b.is_finite()))
        );
        assert_eq!(Model::Igrf14.field_nt(&pole, 2030.1), None);
    }
}
