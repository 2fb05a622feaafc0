//! Smooth random variations, and the field that a spacecraft meets.

use mainfield::{AtYear, Model};
use nalgebra::Vector3;
use noise::Stream;
use std::f64::consts::TAU;

use super::FlightPlan;
use super::orbit::{DAY_S, Moment};

const WAVES: usize = 30;
/// The axis of the Earth's dipole, ITRF: −(g₁¹, h₁¹, g₁⁰) of IGRF-14 in 2025, nT.
const DIPOLE: Vector3<f64> = Vector3::new(1410.3, -4545.5, 29_350.0);

/// A vector that varies smoothly, nearly as a normal process: a sum of waves in time and place.
pub struct Waves(Vec<Wave>);

struct Wave {
    size: Vector3<f64>,
    rate: f64,
    across: Vector3<f64>,
    phase: f64,
}

impl Waves {
    /// With the standard deviation of each component, the range of periods, s, and the standard deviation of the wave
    /// numbers, rad of phase for each rad on the sphere.
    pub fn new(plan: &FlightPlan, name: &str, std: f64, [from, to]: [f64; 2], number: f64) -> Self {
        let mut stream = Stream::new(plan.seed, name);
        let wave = |_| Wave {
            size: normal(&mut stream) * std * (2.0 / WAVES as f64).sqrt(),
            rate: TAU / (from * (to / from).powf(uniform(&mut stream))),
            across: normal(&mut stream) * number,
            phase: TAU * uniform(&mut stream),
        };
        Self((0..WAVES).map(wave).collect())
    }

    /// At a time, s, and a place on the unit sphere.
    pub fn at(&self, time_s: f64, place: &Vector3<f64>) -> Vector3<f64> {
        let wave = |wave: &Wave| wave.size * (wave.rate * time_s + wave.across.dot(place) + wave.phase).cos();
        self.0.iter().map(wave).sum()
    }
}

pub fn normal(stream: &mut Stream) -> Vector3<f64> {
    Vector3::from_fn(|_, _| stream.normal())
}

/// A number from 0 to 1: a normal number wound up many times.
pub fn uniform(stream: &mut Stream) -> f64 {
    (10.0 * stream.normal()).rem_euclid(1.0)
}

/// The field of the Earth, GEO, nT.
pub struct Field {
    /// IGRF-14 at the beginning of each year from the first; between them it changes on straight lines.
    years: Vec<AtYear>,
    first: f64,
    model: Waves,
    auroral: Waves,
    ring: Waves,
}

impl Field {
    /// Of a flight that lasts from one year to another.
    pub fn new(plan: &FlightPlan, [from, to]: [f64; 2]) -> Self {
        let of = &plan.field;
        let years = from as u32..=to as u32 + 1;
        Self {
            years: years.filter_map(|year| Model::Igrf14.at(f64::from(year))).collect(),
            first: from.floor(),
            model: Waves::new(plan, "model", of.model_std_nt, [0.5 * DAY_S, 60.0 * DAY_S], 2.5),
            auroral: Waves::new(plan, "auroral", of.auroral_nt, [40.0, 240.0], 0.0),
            ring: Waves::new(plan, "ring", of.ring_nt, [0.5 * DAY_S, 60.0 * DAY_S], 0.0),
        }
    }

    /// As IGRF-14 has it.
    pub fn main(&self, moment: &Moment) -> Vector3<f64> {
        let at = (moment.year - self.first) as usize;
        let [before, after] = [at, at + 1].map(|at| Vector3::from(self.years[at].field_nt(&moment.place)));
        before.lerp(&after, moment.year.fract())
    }

    /// What there is besides.
    pub fn besides(&self, moment: &Moment, main: &Vector3<f64>) -> Vector3<f64> {
        let (time_s, along) = (moment.time_s, main.normalize());
        // tan(dip latitude) = tan(inclination)/2; the disturbance grows within 5 degrees.
        let dip_latitude = (0.5 * main.z / main.xy().norm()).atan().to_degrees().abs();
        let auroral =
            self.auroral.at(time_s, &Vector3::zeros()) * ((dip_latitude - 60.0) / 5.0).clamp(0.0, 1.0);
        let ring = DIPOLE.normalize() * self.ring.at(time_s, &Vector3::zeros()).x;
        self.model.at(time_s, &moment.up) + auroral - along * along.dot(&auroral) + moment.geo * ring
    }
}
