//! One measurement with a theodolite, as an observer makes it.

use common::Columns;
use nalgebra::{Rotation3, Vector3};
use noise::Stream;
use physics::frames::ARCSEC;
use physics::theodolite::{Mounting, sighting};
use std::f64::consts::{FRAC_PI_2, PI};

use super::ObservatoryPlan;
use super::field::Field;
use crate::planned::columns;

/// From one position to the next, s.
const POSITION_S: f64 = 100.0;
/// From the first to the second reading of a position, s.
const AGAIN_S: f64 = 30.0;
/// How near to null an observer sets the telescope with the residual method, rad.
const NEAR: f64 = 5e-5;
/// Circles are read to this, degrees.
const RESOLUTION_DEG: f64 = 1.0 / 3600.0;

pub struct Observer<'a> {
    plan: &'a ObservatoryPlan,
    mounting: Mounting,
    mark_collimation: f64,
}

/// The views in the order of a sheet: quarter turns from magnetic north, and the face.
const POSITIONS: [(f64, bool, bool); 8] = [
    (1.0, true, true),
    (3.0, true, true),
    (1.0, false, true),
    (3.0, false, true),
    (0.0, true, false),
    (2.0, false, false),
    (0.0, false, false),
    (2.0, true, false),
];

impl<'a> Observer<'a> {
    pub fn new(plan: &'a ObservatoryPlan) -> Self {
        let of = &plan.theodolite;
        let mut stream = Stream::new(plan.seed, "theodolite");
        let mut collimation = || ARCSEC * of.collimation_arcsec * stream.normal();
        let (horizontal_rad, vertical_rad, mark_collimation) =
            (collimation(), collimation(), 0.1 * collimation());
        let offset_nt = of.offset_nt * stream.normal();
        Self { plan, mounting: Mounting { offset_nt, horizontal_rad, vertical_rad }, mark_collimation }
    }

    /// The columns of a set that begins at a time, and the mean time of its readings of the field.
    pub fn set(&self, field: &Field, begin: f64, name: &str) -> (Columns, f64) {
        let of = &self.plan.theodolite;
        let mut stream = Stream::new(self.plan.seed, name);
        let mut normal = |std: f64| std * stream.normal();
        let north = normal(1.0);
        let tilt = Rotation3::new(Vector3::new(
            ARCSEC * normal(of.levelling_arcsec),
            ARCSEC * normal(of.levelling_arcsec),
            0.0,
        ));
        // The squared length of two normal numbers gives a uniform one.
        let mut uniform = || (-0.5 * (normal(1.0).powi(2) + normal(1.0).powi(2))).exp();
        let (is_magnetic, is_misread) = (uniform() < of.magnetic_share, uniform() < of.misread_share);
        let misread = is_misread.then_some((8.0 * uniform()) as usize);
        let magnetic_nt = if is_magnetic { of.magnetic_nt } else { 0.0 };
        let magnetic = Vector3::from_fn(|_, _| normal(magnetic_nt));
        let mounting =
            Mounting { offset_nt: self.mounting.offset_nt + normal(of.offset_changes_nt), ..self.mounting };
        let mut rows: Vec<[f64; 5]> = Vec::new();
        let degrees = |angle: f64| {
            let degrees = angle.to_degrees().rem_euclid(360.0);
            ((degrees / RESOLUTION_DEG).round() * RESOLUTION_DEG).rem_euclid(360.0)
        };
        let mark = self.plan.mark_azimuth_deg.to_radians();
        let marks = |rows: &mut Vec<[f64; 5]>, time: f64, normal: &mut dyn FnMut(f64) -> f64| {
            for above in [true, false] {
                let face = if above { self.mark_collimation } else { PI - self.mark_collimation };
                let read = north + mark + face + ARCSEC * normal(of.circle_arcsec);
                let zenith = if above { 90.0 } else { 270.0 };
                rows.push([time, degrees(read), zenith, f64::NAN, f64::NAN]);
            }
        };
        marks(&mut rows, 0.0, &mut normal);
        let (mut sum, mut count) = (0.0, 0.0);
        for (position, (quarter, above, level)) in POSITIONS.into_iter().enumerate() {
            for again in [0.0, AGAIN_S] {
                let stated = POSITION_S * (1.0 + position as f64) + again;
                let time = begin + stated + normal(of.time_s);
                let total = field.total(time);
                let felt = tilt * (total + magnetic);
                let meridian = felt.y.atan2(felt.x);
                let turned = if above { 0.0 } else { PI };
                let azimuth = meridian + quarter * FRAC_PI_2 + turned;
                let dip = felt.z.atan2(felt.x.hypot(felt.y));
                // With the telescope turned over zenith angles are beyond 180°.
                let inclined = if (quarter == 0.0) == above { dip } else { -dip };
                let zenith = if level { FRAC_PI_2 } else { inclined.rem_euclid(PI) } + turned;
                // The circle at which the magnetometer reads nothing, or is near to it. The other one is set as it is read.
                let set_off = ARCSEC * normal(of.circle_arcsec);
                let (mut a, mut v) =
                    if level { (azimuth, zenith + set_off) } else { (azimuth + set_off, zenith) };
                for _ in 0..4 {
                    let seen = sighting(&felt, a, v, &mounting);
                    if level {
                        a -= seen.reading_nt / seen.by_azimuth;
                    } else {
                        v -= seen.reading_nt / seen.by_zenith;
                    }
                }
                let near = if self.plan.method == "residual" { normal(NEAR) } else { 0.0 };
                let is_misread = misread == Some(position) && again == 0.0;
                let wrong = if is_misread { 60.0 * ARCSEC * of.misread_arcmin } else { 0.0 };
                let error = ARCSEC * normal(of.circle_arcsec) + wrong;
                let (a, v) = if level { (a + near, v) } else { (a, v + near) };
                let reading = sighting(&felt, a, v, &mounting).reading_nt + normal(of.residual_nt);
                let residual =
                    if self.plan.method == "residual" { (reading * 10.0).round() / 10.0 } else { 0.0 };
                let (horizontal, direction) =
                    if level { (degrees(north + a + error), f64::NAN) } else { (f64::NAN, 90.0 * quarter) };
                let vertical = if level { if above { 90.0 } else { 270.0 } } else { degrees(v + error) };
                rows.push([stated, horizontal, vertical, residual, direction]);
                (sum, count) = (sum + stated, count + 1.0);
            }
        }
        marks(&mut rows, POSITION_S * 10.0, &mut normal);
        let names = ["time_s", "horizontal_deg", "vertical_deg", "residual_nt", "direction_deg"];
        (columns(names, &rows), begin + sum / count)
    }
}
