use common::number::{bare, duration};
use common::{Axis, Column, Columns, Conditions, Error, Recording, procedure};
use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

use super::{MONTH_S, Sequence, whole};
use crate::aboard::{KnownField, attitude_columns};
use crate::bench::{Bench, deviation, exponent, positive, samples_up_to};
use crate::orbit::{Orbit, main_field_nt};
use crate::planned::{Begins, Planned, Reads, Step};

/// Samples at most: a recording in orbit has some fifteen columns.
const MOST_ROWS: f64 = 5e6;

/// A recording with columns of its own; the readings are added.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FreeRun {
    /// The recording's id.
    pub id: String,
    /// What holds throughout.
    #[serde(default)]
    pub conditions: Conditions,
    /// Times, drive, temperatures.
    pub columns: Columns,
    /// Record the natural field outside beside.
    #[serde(default)]
    pub outside: bool,
}

impl Sequence for FreeRun {
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error> {
        let readings = |name: &&String| name.starts_with("sensor_") && !name.contains("temperature");
        let refused = |name: &str, found: &str, expected: &str| {
            Err(Error::document(format!("{path}.columns{name}"), found, expected))
        };
        if let Some(name) = self.columns.keys().find(readings) {
            let expected = "drive, times and temperatures only; the readings are simulated";
            return refused(&format!(".{name}"), "a column of readings", expected);
        }
        if self.columns.values().all(|column| column.is_empty()) {
            return refused("", "no rows", "at least one row of times or drive");
        }
        for axis in Axis::ALL {
            if self.columns.contains_key(&format!("coil_{axis}_v")) {
                let expected = format!("`coil_{axis}_a`, the current that flows");
                return refused(&format!(".coil_{axis}_v"), "a drive in V", &expected);
            }
            let Some(column) = self.columns.get(&format!("coil_{axis}_a")) else { continue };
            let largest = column.iter().map(|current| current.abs()).fold(0.0, f64::max);
            let constant = bench.stated.coils[axis.index()].constant_nt_per_a;
            let field = if constant == 0.0 { largest } else { largest * constant.abs() };
            bench.within(axis, field, &format!("{path}.columns.coil_{axis}_a"))?;
        }
        Ok(self.columns.values().map(|column| column.len()).max().unwrap_or(0) as f64)
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let recording = Recording {
            id: self.id.clone(),
            procedure: procedure::FREE_RUN.into(),
            conditions: self.conditions.clone(),
            columns: self.columns.clone(),
            ..Recording::default()
        };
        let rotation = physics::orientation(bench.document, &recording)
            .map_err(|error| error.at(&format!("{path}.conditions.orientation")))?
            .rotation;
        let times = recording.column("time_s").unwrap_or_default();
        let last = times.iter().copied().filter(|t| t.is_finite()).fold(0.0, f64::max);
        let step = Step::still("as the columns say".into(), 0.0, recording.rows(), last);
        Ok(vec![Planned {
            rotation,
            nominal: rotation,
            reads: Reads::Sensors(bench.sensors(&None, path)?),
            outside: self.outside,
            begins: Begins::AsItSays,
            ..Planned::of(recording, path, vec![step])
        }])
    }
}

/// A free run aboard a satellite in a circular orbit. GEO is north, east and down below the satellite; SEN is
/// along the track, across it and down where yaw and libration are zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct OrbitProcedure {
    /// The recording's id.
    pub id: String,
    /// What holds throughout.
    #[serde(default)]
    pub conditions: Conditions,
    /// Length, s.
    #[serde(default = "whole::<MONTH_S>")]
    pub length_s: f64,
    /// From one sample to the next, s.
    #[serde(default = "whole::<60>")]
    pub step_s: f64,
    /// Height, km.
    #[serde(default = "whole::<450>")]
    pub altitude_km: f64,
    /// Inclination, deg.
    #[serde(default = "inclination")]
    pub inclination_deg: f64,
    /// Longitude of the ascending node at the beginning, deg.
    #[serde(default)]
    pub node_deg: f64,
    /// Time of a turn about the vertical, s; absent: no yaw.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw_period_s: Option<f64>,
    /// Amplitude of the libration in pitch and in roll, deg; its frequencies are √3 and 2 times that of the
    /// orbit, those of gravity-gradient stabilisation.
    #[serde(default)]
    pub libration_deg: f64,
    /// Temperature of the sensors; absent: no such column.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature: Option<OrbitTemperature>,
    /// A scalar magnetometer reads beside, with the noise `facility.reference_std_nt`.
    #[serde(default = "yes")]
    pub scalar: bool,
    /// The field of a model and the attitude are written beside; absent: neither is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub known_field: Option<KnownField>,
}

/// Temperature aboard: mean + orbit_k sin(angle from the node) + slow_k sin(2π t/slow_s).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct OrbitTemperature {
    /// Mean, degC.
    pub mean_c: f64,
    /// Amplitude of the change with the orbit, K.
    #[serde(default)]
    pub orbit_k: f64,
    /// Amplitude of a slow change, K.
    #[serde(default)]
    pub slow_k: f64,
    /// Its period, s.
    #[serde(default = "whole::<MONTH_S>")]
    pub slow_s: f64,
}

fn inclination() -> f64 {
    87.4
}

fn yes() -> bool {
    true
}

impl OrbitProcedure {
    /// Times, field, attitude and temperature as they are true.
    fn columns(&self) -> Columns {
        let orbit = Orbit::new(self.altitude_km, self.inclination_deg, self.node_deg);
        let rows = (self.length_s / self.step_s).round() as usize;
        let time: Vec<f64> = (0..rows).map(|row| row as f64 * self.step_s).collect();
        let field: Vec<Vector3<f64>> = time.iter().map(|t| main_field_nt(&orbit.place(*t))).collect();
        let attitude: Vec<UnitQuaternion<f64>> = time.iter().map(|t| self.attitude(&orbit, *t)).collect();
        let mut columns = Columns::from_iter([("time_s".to_string(), Column::from(time.clone()))]);
        for axis in Axis::ALL {
            let along = field.iter().map(|field| field[axis.index()]);
            columns.insert(format!("ambient_{axis}_nt"), along.collect());
        }
        columns.extend(attitude_columns(&attitude));
        if let Some(temperature) = &self.temperature {
            let at = |t: &f64| {
                let with_orbit = temperature.orbit_k * orbit.angle(*t).sin();
                temperature.mean_c + with_orbit + temperature.slow_k * (TAU * t / temperature.slow_s).sin()
            };
            columns.insert("sensor_temperature_c".into(), time.iter().map(at).collect());
        }
        columns
    }

    /// R, GEO -> SEN: the course about down, then yaw, pitch and roll.
    fn attitude(&self, orbit: &Orbit, time_s: f64) -> UnitQuaternion<f64> {
        let place = orbit.place(time_s);
        let yaw = self.yaw_period_s.map_or(0.0, |period| TAU * time_s / period);
        let (amplitude, angle) = (self.libration_deg.to_radians(), orbit.angle(time_s));
        let about = |axis, angle: f64| UnitQuaternion::from_axis_angle(&axis, -angle);
        about(Vector3::x_axis(), amplitude * (2.0 * angle).sin())
            * about(Vector3::y_axis(), amplitude * (3.0_f64.sqrt() * angle).sin())
            * about(Vector3::z_axis(), place.course + yaw)
    }
}

impl Sequence for OrbitProcedure {
    fn rows(&self, _: &Bench<'_>, path: &str) -> Result<f64, Error> {
        positive(
            path,
            [("length_s", self.length_s), ("step_s", self.step_s), ("altitude_km", self.altitude_km)],
        )?;
        deviation(path, "libration_deg", self.libration_deg)?;
        if let Some(period) = self.yaw_period_s {
            positive(path, [("yaw_period_s", period)])?;
        }
        if let Some(temperature) = &self.temperature {
            positive(&format!("{path}.temperature"), [("slow_s", temperature.slow_s)])?;
        }
        if let Some(known) = &self.known_field {
            let path = format!("{path}.known_field");
            deviation(&path, "attitude_std_arcsec", known.attitude_std_arcsec)?;
            exponent(&format!("{path}.noise"), &known.noise)?;
        }
        samples_up_to(MOST_ROWS, path, self.length_s / self.step_s, 5.0)
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let recording = Recording {
            id: self.id.clone(),
            procedure: procedure::FREE_RUN.into(),
            conditions: self.conditions.clone(),
            columns: self.columns(),
            ..Recording::default()
        };
        let action = format!("record {} in orbit at {} s", duration(self.length_s), bare(self.step_s));
        let step = Step::still(action, 0.0, recording.rows(), self.length_s);
        let sensors = bench.sensors(&None, path)?;
        let known = self.known_field.clone().map(Box::new);
        let reads = Reads::Aboard { sensors, scalar: self.scalar, known };
        Ok(vec![Planned { reads, ..Planned::of(recording, path, vec![step]) }])
    }
}
