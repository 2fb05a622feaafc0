//! The columns of a flight, and what each row of them says of the coefficients that are found.

use common::{AttitudeFrame, Axis};
use nalgebra::Vector3;
use physics::{SUN_HARMONICS, sun_harmonics};
use serde::{Deserialize, Serialize};

/// Readings count in this, nT, and temperatures as (T − [`WARM_C`]) / [`WARM_K`], so that all signals are near one.
pub const FIELD_NT: f64 = 50_000.0;
pub const WARM_C: f64 = 20.0;
pub const WARM_K: f64 = 10.0;
/// Harmonics of the Sun's direction that are looked at: to the second degree.
pub const SUN: usize = 9;
pub const CAMERAS: usize = 3;
/// Most temperatures and currents that are looked at.
const MOST: usize = 6;
pub const PARTS: [&str; 4] = ["w", "x", "y", "z"];

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Layout {
    /// The frame from which attitudes turn.
    pub frame: AttitudeFrame,
    /// Where the field is from: a model, or columns.
    pub field: String,
    /// Star cameras, by their numbers.
    pub cameras: Vec<usize>,
    pub temperatures: Vec<String>,
    pub currents: Vec<String>,
    /// Whether the Sun's direction, `sunlit` or `eclipse`, `kp`, the field of a model and the place are there.
    pub sun: bool,
    pub sunlit: Option<String>,
    pub kp: bool,
    pub ambient: bool,
    pub place: bool,
}

/// A signal in the readings; each has a vector of coefficients in the frame of a camera.
#[derive(Clone, Debug, PartialEq)]
pub enum Signal {
    Reading(usize),
    One,
    /// A temperature, and a sensor's reading times it.
    Warmth(usize),
    WarmReading(usize, usize),
    Current(usize),
    Sun(usize),
}

impl Layout {
    /// What of the columns that there are is used. Errors: what is missing, in words.
    pub fn of(there: &[String], frame: AttitudeFrame, model: &str) -> Result<Self, String> {
        let has = |name: &str| there.iter().any(|one| one == name);
        let all = |names: &[&str]| names.iter().all(|name| has(name));
        if !has("time_s") {
            return Err("`time_s`".into());
        }
        if !all(&["sensor_x_nt", "sensor_y_nt", "sensor_z_nt"]) {
            return Err("`sensor_x_nt`, `sensor_y_nt`, `sensor_z_nt`".into());
        }
        let camera = |number: &usize| PARTS.iter().all(|part| has(&format!("camera_{number}_{part}")));
        let cameras: Vec<usize> = (1..=CAMERAS).filter(camera).collect();
        if cameras.is_empty() {
            let expected =
                "the attitude by a star camera, `camera_1_w`, `camera_1_x`, `camera_1_y`, `camera_1_z`";
            return Err(expected.into());
        }
        let ambient = all(&["ambient_x_nt", "ambient_y_nt", "ambient_z_nt"]);
        let place = all(&["latitude_deg", "longitude_deg", "height_m"]);
        if !(place || ambient && frame == AttitudeFrame::Geo) {
            let expected = if frame == AttitudeFrame::Geo {
                "`ambient_x_nt`, `ambient_y_nt`, `ambient_z_nt`, or the place, `latitude_deg`, `longitude_deg`, `height_m`"
            } else {
                "the place, `latitude_deg`, `longitude_deg`, `height_m`: attitudes are not from north, east and down"
            };
            return Err(expected.into());
        }
        let named = |ends: fn(&str) -> bool| {
            let mut names: Vec<String> = there.iter().filter(|name| ends(name)).cloned().collect();
            // Those of the sensors and the electronics first, for which there are effects.
            let is_other = |name: &str| !["sensor_", "electronics_"].iter().any(|own| name.starts_with(own));
            names.sort_by(|a, b| is_other(a).cmp(&is_other(b)).then(a.cmp(b)));
            names.truncate(MOST);
            names
        };
        let lit = ["sunlit", "eclipse"].into_iter().find(|name| has(name));
        Ok(Self {
            frame,
            field: if ambient { "ambient_*_nt" } else { model }.into(),
            cameras,
            temperatures: named(|name| name.ends_with("_temperature_c")),
            currents: named(|name| name.ends_with("_a") && !name.starts_with("coil_")),
            sun: all(&["sun_azimuth_rad", "sun_elevation_rad"]),
            sunlit: lit.map(String::from),
            kp: has("kp"),
            ambient,
            place,
        })
    }

    /// The columns in the order in which rows have them, times first.
    pub fn names(&self) -> Vec<String> {
        let mut names = vec!["time_s".to_string()];
        names.extend(Axis::ALL.map(|axis| format!("sensor_{axis}_nt")));
        for camera in &self.cameras {
            names.extend(PARTS.map(|part| format!("camera_{camera}_{part}")));
        }
        names.extend(self.temperatures.iter().chain(&self.currents).cloned());
        let mut optional = |is: bool, more: &[&str]| {
            names.extend(more.iter().filter(|_| is).map(|name| name.to_string()));
        };
        optional(self.sun, &["sun_azimuth_rad", "sun_elevation_rad"]);
        optional(self.sunlit.is_some(), &[self.sunlit.as_deref().unwrap_or_default()]);
        optional(self.kp, &["kp"]);
        optional(self.ambient, &["ambient_x_nt", "ambient_y_nt", "ambient_z_nt"]);
        optional(self.place, &["latitude_deg", "longitude_deg", "height_m"]);
        names
    }

    /// The signals of a camera, in the order of their coefficients: of the first all that is in the readings, of another
    /// the field as the first sees it, in place of the readings.
    pub fn signals(&self, camera: usize) -> Vec<Signal> {
        let mut all: Vec<Signal> = (0..3).map(Signal::Reading).collect();
        let warm = (0..self.temperatures.len())
            .flat_map(|number| (0..3).map(move |axis| Signal::WarmReading(number, axis)));
        if camera > 0 {
            return all.into_iter().chain(warm).collect();
        }
        all.push(Signal::One);
        all.extend((0..self.temperatures.len()).map(Signal::Warmth).chain(warm));
        all.extend((0..self.currents.len()).map(Signal::Current));
        if self.sun {
            all.extend((0..SUN).map(Signal::Sun));
        }
        all
    }

    /// Takes a row apart; None where a value is missing that is not a camera's.
    pub fn row(&self, values: &[f64]) -> Option<Row> {
        let mut rest = values;
        let mut next = || {
            let (first, others) = rest.split_first()?;
            rest = others;
            Some(*first)
        };
        let time_s = next()?;
        let readings = Vector3::new(next()?, next()?, next()?);
        let mut attitudes = [None; CAMERAS];
        for attitude in attitudes.iter_mut().take(self.cameras.len()) {
            let parts = [next()?, next()?, next()?, next()?];
            *attitude = parts.iter().all(|part| part.is_finite()).then_some(parts);
        }
        let z = readings / FIELD_NT;
        let mut signals = vec![z.x, z.y, z.z, 1.0];
        let mut warmth = Vec::new();
        for _ in &self.temperatures {
            warmth.push((next()? - WARM_C) / WARM_K);
        }
        signals.extend(&warmth);
        signals.extend(warmth.iter().flat_map(|warmth| (z * *warmth).data.0[0]));
        for _ in &self.currents {
            signals.push(next()?);
        }
        let sun = if self.sun { Some([next()?, next()?]) } else { None };
        let lit = match self.sunlit.as_deref() {
            None => 1.0,
            Some("sunlit") => next()?,
            Some(_) => 1.0 - next()?,
        };
        if let Some(direction) = sun {
            let seen = if lit == 0.0 { [0.0; SUN_HARMONICS] } else { sun_harmonics(direction) };
            signals.extend(seen[..SUN].iter().map(|seen| seen * lit));
        }
        let kp = if self.kp { next()? } else { 0.0 };
        let ambient_nt = if self.ambient { Some(Vector3::new(next()?, next()?, next()?)) } else { None };
        let place = if self.place { Some([next()?, next()?, next()?]) } else { None };
        let known = ambient_nt.iter().flatten().chain(place.iter().flatten());
        let is_whole = known.chain(&signals).all(|value| value.is_finite());
        let kp = if kp.is_nan() { 0.0 } else { kp };
        is_whole.then_some(Row { time_s, readings, attitudes, signals, warmth, kp, ambient_nt, place })
    }
}

#[derive(Clone, Debug)]
pub struct Row {
    pub time_s: f64,
    /// nT.
    pub readings: Vector3<f64>,
    /// Quaternions w, x, y, z of the cameras that see stars.
    pub attitudes: [Option<[f64; 4]>; CAMERAS],
    pub signals: Vec<f64>,
    /// Of each temperature.
    pub warmth: Vec<f64>,
    pub kp: f64,
    /// GEO.
    pub ambient_nt: Option<Vector3<f64>>,
    /// Latitude and longitude, degrees, and height, m.
    pub place: Option<[f64; 3]>,
}
