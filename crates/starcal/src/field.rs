//! The field that a model gives, in the frame from which attitudes turn.

use common::AttitudeFrame;
use common::time::Start;
use mainfield::{AtYear, Celestial, Model, Place, itrf_to_geo};
use nalgebra::{Matrix3, Vector3};

use crate::layout::Row;

/// The Earth turns by this, rad/s.
///
/// Source: IERS Conventions (2010), table 1.1.
const EARTH_RAD_PER_S: f64 = 7.292_115e-5;
/// The coefficients of a model are those of the nearest day.
const DAY_S: f64 = 86_400.0;

#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// North, east and down, nT.
    pub geo: Vector3<f64>,
    pub itrf: Vector3<f64>,
    pub icrf: Vector3<f64>,
    /// What a second of the Earth's rotation adds to it in ICRF, nT/s.
    pub turning: Vector3<f64>,
}

/// Makes it row by row.
pub struct Fields {
    model: Model,
    day: Option<(i64, AtYear)>,
    celestial: Celestial,
    is_celestial: bool,
}

impl Fields {
    pub fn new(model: Model, ut1_utc_s: f64, frame: AttitudeFrame) -> Self {
        let is_celestial = frame == AttitudeFrame::Icrf;
        Self { model, day: None, celestial: Celestial::new(ut1_utc_s), is_celestial }
    }

    /// The field of a row, of which time counts since 1970, UTC. Errors: what was found, and what was expected.
    pub fn known(&mut self, row: &Row) -> Result<Known, [String; 2]> {
        let geo = match (row.ambient_nt, row.place) {
            (Some(ambient), _) => ambient,
            (None, Some([latitude_deg, longitude_deg, height_m])) => {
                self.of_model(row.time_s, &Place { latitude_deg, longitude_deg, height_m })?
            }
            (None, None) => Vector3::zeros(),
        };
        let Some([latitude, longitude, _]) = row.place else {
            return Ok(Known { geo, itrf: geo, icrf: geo, turning: Vector3::zeros() });
        };
        let itrf = itrf_to_geo(latitude.to_radians(), longitude.to_radians()).transpose() * geo;
        let to_earth = match self.celestial.to_earth(row.time_s) {
            Some(to_earth) => to_earth,
            None if self.is_celestial => {
                let expected = "UTC since 1972 beside attitudes from icrf: give `start`, or times since 1970";
                return Err([format!("a time of {} s since 1970", row.time_s), expected.into()]);
            }
            None => Matrix3::identity(),
        };
        let icrf = to_earth.transpose() * itrf;
        let axis = to_earth.row(2).transpose();
        Ok(Known { geo, itrf, icrf, turning: EARTH_RAD_PER_S * axis.cross(&icrf) })
    }

    fn of_model(&mut self, time_s: f64, place: &Place) -> Result<Vector3<f64>, [String; 2]> {
        let day = (time_s / DAY_S).round() as i64;
        if self.day.as_ref().is_none_or(|(kept, _)| *kept != day) {
            let year = Start { unix_s: day as f64 * DAY_S, offset_s: 0.0 }.year();
            let at = year.and_then(|year| self.model.at(year));
            let [from, to] = self.model.years();
            let at = at.ok_or_else(|| {
                let model = self.model;
                let years =
                    format!("one of {from} to {to}, for which {model} is: give `start`, or times since 1970");
                [format!("a time of {time_s} s since 1970"), years]
            })?;
            self.day = Some((day, at));
        }
        Ok(self.day.as_ref().map_or_else(Vector3::zeros, |(_, at)| at.field_nt(place).into()))
    }
}

impl Known {
    pub fn of(&self, frame: AttitudeFrame) -> Vector3<f64> {
        match frame {
            AttitudeFrame::Geo => self.geo,
            AttitudeFrame::Itrf => self.itrf,
            AttitudeFrame::Icrf => self.icrf,
        }
    }

    /// Whether the dip latitude, of which the tangent is half that of the inclination, is beyond 55°: there currents
    /// along the field disturb it.
    pub fn is_polar(&self) -> bool {
        const TWICE_TANGENT: f64 = 2.0 * 1.428_148;
        self.geo.z.abs() > TWICE_TANGENT * self.geo.x.hypot(self.geo.y)
    }
}
