//! The motion of a spacecraft: its place, its attitude, and the Sun.

use common::AttitudeFrame;
use common::time::Start;
use mainfield::{Celestial, EQUATOR_KM, Place, RADIUS_KM, itrf_to_geo};
use nalgebra::{Matrix3, Rotation3, Vector3};
use noise::Stream;
use std::f64::consts::TAU;

use super::FlightPlan;
use super::errors::{Waves, uniform};
use crate::orbit::Orbit;

pub const DAY_S: f64 = 86_400.0;
const EQUATOR_M: f64 = 1000.0 * EQUATOR_KM;
/// Second zonal coefficient of the Earth's gravity (IERS Conventions 2010).
const J2: f64 = 1.082_635_9e-3;
/// Length of a slew, s.
const SLEW_S: f64 = 1800.0;

/// The orbit and the attitude as functions of the time since the start.
pub struct Motion<'a> {
    plan: &'a FlightPlan,
    start: Start,
    pub orbit: Orbit,
    node_rate: f64,
    swings: Waves,
    /// When the slew of each day begins, s.
    slews: Vec<f64>,
}

/// All that motion determines at one moment.
pub struct Moment {
    pub time_s: f64,
    pub year: f64,
    pub place: Place,
    /// From the centre of the Earth to the spacecraft, ITRF, a unit vector.
    pub up: Vector3<f64>,
    /// ITRF -> GEO.
    pub geo: Matrix3<f64>,
    /// ICRF -> SEN, and GEO -> SEN.
    pub celestial_to_sen: Matrix3<f64>,
    pub sen: Matrix3<f64>,
    /// The direction of the Sun, SEN, and whether it shines, 1 or 0.
    pub sun: Vector3<f64>,
    pub lit: f64,
}

impl<'a> Motion<'a> {
    pub fn new(plan: &'a FlightPlan, start: Start) -> Self {
        let orbit = Orbit::new(plan.height_m / 1000.0, plan.inclination_deg, 0.0);
        let flattening = J2 * (EQUATOR_M / (1000.0 * RADIUS_KM + plan.height_m)).powi(2);
        let node_rate = -1.5 * flattening * TAU / orbit.period_s() * plan.inclination_deg.to_radians().cos();
        let mut stream = Stream::new(plan.seed, "slews");
        let days = 0..=plan.days as usize;
        let slews = days.map(|day| (day as f64 + 0.97 * uniform(&mut stream)) * DAY_S).collect();
        let swings = Waves::new(plan, "swings", 1.2, [2000.0, 20_000.0], 0.0);
        Self { plan, start, orbit, node_rate, swings, slews }
    }

    pub fn at(&self, time_s: f64, celestial: &mut Celestial) -> Moment {
        let moment = Start { offset_s: 0.0, ..self.start.after(time_s) };
        let earth = celestial.to_earth(moment.unix_s).expect("a flight is after 1972");
        let node = self.plan.node_deg.to_radians() + self.node_rate * time_s;
        // From outwards, along the track and across to ICRF.
        let plane = Rotation3::from_axis_angle(&Vector3::z_axis(), node)
            * Rotation3::from_axis_angle(&Vector3::x_axis(), self.plan.inclination_deg.to_radians())
            * Rotation3::from_axis_angle(&Vector3::z_axis(), self.orbit.angle(time_s));
        let outwards = plane * Vector3::x();
        let up = earth * outwards;
        let radius_m = 1000.0 * RADIUS_KM + self.plan.height_m;
        let place = Place::of_itrf(&(up * (radius_m / 1000.0)));
        let geo = itrf_to_geo(place.latitude_deg.to_radians(), place.longitude_deg.to_radians());
        let mut swing = self.swings.at(time_s, &Vector3::zeros());
        let share = (time_s - self.slews[(time_s / DAY_S) as usize]) / SLEW_S;
        if (0.0..1.0).contains(&share) {
            swing.z += 90.0 * (TAU * share - (TAU * share).sin()).sin();
        }
        let forward = Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, -1.0, -1.0, 0.0, 0.0);
        let celestial_to_sen = turned(swing.into()) * forward * plane.inverse().matrix();
        let sun = sun(moment.unix_s);
        let height = sun.dot(&outwards);
        let in_shadow = height < 0.0 && radius_m * (1.0 - height * height).sqrt() < EQUATOR_M;
        Moment {
            time_s,
            year: moment.year().unwrap_or_default(),
            place,
            up,
            geo,
            celestial_to_sen,
            sen: celestial_to_sen * (geo * earth).transpose(),
            sun: celestial_to_sen * sun,
            lit: f64::from(u8::from(!in_shadow)),
        }
    }
}

impl Moment {
    /// From the frame of reference to SEN.
    pub fn attitude(&self, frame: AttitudeFrame) -> Matrix3<f64> {
        match frame {
            AttitudeFrame::Geo => self.sen,
            AttitudeFrame::Itrf => self.sen * self.geo,
            AttitudeFrame::Icrf => self.celestial_to_sen,
        }
    }
}

/// The rotation into a frame that was turned about its x axis, then about its new y axis, then about its new z axis.
pub fn turned(degrees: [f64; 3]) -> Matrix3<f64> {
    let [x, y, z] = degrees.map(|angle| -angle.to_radians());
    Rotation3::from_euler_angles(x, y, z).into_inner()
}

/// The direction of the Sun in the frame of the date, to 0.01 degrees; the precession since 2000 is left out.
///
/// Source: The Astronomical Almanac, low-precision formulas for the Sun.
fn sun(unix_s: f64) -> Vector3<f64> {
    let days = (unix_s - 946_728_000.0) / DAY_S;
    let anomaly = (357.528 + 0.985_600_3 * days).to_radians();
    let mean = 280.460 + 0.985_647_4 * days;
    let (sin, cos) = (mean + 1.915 * anomaly.sin() + 0.020 * (2.0 * anomaly).sin()).to_radians().sin_cos();
    let (sin_obliquity, cos_obliquity) = (23.439 - 4e-7 * days).to_radians().sin_cos();
    Vector3::new(cos, cos_obliquity * sin, sin_obliquity * sin)
}
