//! What is flown.

use common::number::bare;
use common::time::Start;
use common::{AttitudeFrame, Error, Versioned, parse};
use serde::{Deserialize, Serialize};

/// A flight in a circular orbit. All of it has defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct FlightPlan {
    /// Version of the format.
    pub fluxcal: u64,
    /// Of all that is drawn.
    pub seed: u64,
    /// RFC 3339.
    pub start: String,
    /// How long.
    pub days: f64,
    /// From one row to the next, s.
    pub step_s: f64,
    /// Height above the sphere of 6371.2 km, m.
    pub height_m: f64,
    /// Inclination, degrees.
    pub inclination_deg: f64,
    /// Right ascension of the ascending node at the start, degrees; it drifts as the Earth's flattening makes it.
    pub node_deg: f64,
    /// The frame from which the quaternions turn.
    pub attitude_frame: AttitudeFrame,
    /// Heads of star cameras, one to three.
    pub cameras: Vec<CameraPlan>,
    /// By how much each head is mounted off `turn_deg`, about each axis, standard deviation, arcsec.
    pub turn_std_arcsec: f64,
    /// The magnetometer.
    pub sensors: SensorsPlan,
    /// The field beside that of IGRF-14.
    pub field: FieldPlan,
    /// Between the magnetometer and all heads.
    pub bench: BenchPlan,
    /// What the Sun does.
    pub sun: SunPlan,
    /// What the current of the panels does.
    pub current: CurrentPlan,
    /// What is late.
    pub latency: LatencyPlan,
    /// Whether the field of IGRF-14 is written, `ambient_*_nt`.
    pub write_model: bool,
}

/// A head of a star camera; its boresight is its z axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct CameraPlan {
    /// SEN -> head: the frame turned about x, then about its new y, then about its new z, degrees.
    pub turn_deg: [f64; 3],
    /// Noise about the axes of the head, standard deviation, arcsec.
    pub std_arcsec: [f64; 3],
    /// Share of the time in which it is blinded, some minutes at a time.
    pub gap_share: f64,
}

/// The magnetometer; standard deviations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SensorsPlan {
    /// Of the scale factors, ppm.
    pub scale_std_ppm: f64,
    /// Of each sensor's direction, about both axes across it, arcsec.
    pub angle_std_arcsec: f64,
    /// Of the offsets, nT.
    pub offset_std_nt: f64,
    /// Of a reading, nT.
    pub noise_nt: f64,
    /// What a kelvin of `sensor_temperature_c` adds to the offsets.
    pub offset_nt_per_k: [f64; 3],
}

/// Field that the model does not have; standard deviations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct FieldPlan {
    /// Of each component, GEO: smooth over the Earth, different after half a day to 60 days, nT.
    pub model_std_nt: f64,
    /// Of each component across the field, beyond 60 degrees of dip latitude, on scales of 40 to 240 s, nT.
    pub auroral_nt: f64,
    /// Of a field along the dipole's axis that changes over days, nT.
    pub ring_nt: f64,
}

/// The bench between the magnetometer and all heads.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct BenchPlan {
    /// By what a kelvin of `bench_temperature_c` turns the heads about the axes of SEN.
    pub turn_arcsec_per_k: [f64; 3],
}

/// A field of the effect `sun_thermoelectric`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SunPlan {
    /// Standard deviation of each of its parameters, nT.
    pub lit_nt: f64,
}

/// The field of a current.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct CurrentPlan {
    /// Of `panel_current_a`, SEN.
    pub nt_per_a: [f64; 3],
}

/// How much earlier than its row something was, s.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct LatencyPlan {
    /// The reading of the magnetometer.
    pub readings_s: f64,
    /// The quaternions.
    pub attitude_s: f64,
}

impl Default for FlightPlan {
    fn default() -> Self {
        Self {
            fluxcal: 1,
            seed: 1,
            start: "2025-03-01T00:00:00Z".into(),
            days: 1.0,
            step_s: 10.0,
            height_m: 460_000.0,
            inclination_deg: 87.4,
            node_deg: 0.0,
            attitude_frame: AttitudeFrame::Icrf,
            cameras: vec![CameraPlan::default()],
            turn_std_arcsec: 600.0,
            sensors: SensorsPlan::default(),
            field: FieldPlan::default(),
            bench: BenchPlan::default(),
            sun: SunPlan::default(),
            current: CurrentPlan::default(),
            latency: LatencyPlan::default(),
            write_model: false,
        }
    }
}

impl Default for CameraPlan {
    fn default() -> Self {
        Self { turn_deg: [140.0, 0.0, 0.0], std_arcsec: [5.0, 5.0, 20.0], gap_share: 0.05 }
    }
}

impl Default for SensorsPlan {
    fn default() -> Self {
        Self {
            scale_std_ppm: 200.0,
            angle_std_arcsec: 60.0,
            offset_std_nt: 3.0,
            noise_nt: 0.1,
            offset_nt_per_k: [0.0; 3],
        }
    }
}

impl Default for FieldPlan {
    fn default() -> Self {
        Self { model_std_nt: 3.0, auroral_nt: 60.0, ring_nt: 5.0 }
    }
}

impl Versioned for FlightPlan {
    fn format_version(&self) -> Option<u64> {
        Some(self.fluxcal)
    }
}

/// Rows at most: a recording has some twenty columns.
const MOST_ROWS: f64 = 5e6;
/// Latencies are at most so long, s.
const MOST_LATE_S: f64 = 60.0;

impl FlightPlan {
    /// Reads a plan. Errors: as of every document; values that cannot be.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let plan: Self = parse(text)?;
        plan.check().map(|_| plan)
    }

    pub(super) fn rows(&self) -> usize {
        (self.days * 86_400.0 / self.step_s).round() as usize
    }

    /// Refuses values that cannot be; else the start, and the years between which the field is needed.
    pub(super) fn check(&self) -> Result<(Start, [f64; 2]), Error> {
        const MOST: f64 = 1e5;
        let Self { sensors, field, latency, .. } = self;
        let ranges = [
            ("days", self.days, 1e-3, 1000.0),
            ("step_s", self.step_s, 1e-3, 3600.0),
            ("height_m", self.height_m, 1e5, 1e7),
            ("cameras", self.cameras.len() as f64, 1.0, 3.0),
            ("turn_std_arcsec", self.turn_std_arcsec, 0.0, MOST),
            ("sensors.scale_std_ppm", sensors.scale_std_ppm, 0.0, MOST),
            ("sensors.angle_std_arcsec", sensors.angle_std_arcsec, 0.0, MOST),
            ("sensors.offset_std_nt", sensors.offset_std_nt, 0.0, MOST),
            ("sensors.noise_nt", sensors.noise_nt, 0.0, MOST),
            ("field.model_std_nt", field.model_std_nt, 0.0, MOST),
            ("field.auroral_nt", field.auroral_nt, 0.0, MOST),
            ("field.ring_nt", field.ring_nt, 0.0, MOST),
            ("sun.lit_nt", self.sun.lit_nt, 0.0, MOST),
            ("latency.readings_s", latency.readings_s, 0.0, MOST_LATE_S),
            ("latency.attitude_s", latency.attitude_s, 0.0, MOST_LATE_S),
        ];
        let ranges = ranges.map(|(path, value, from, to)| (path.to_string(), value, from, to)).into_iter();
        let of_cameras = self.cameras.iter().enumerate().flat_map(|(at, camera)| {
            let std = camera.std_arcsec.map(|std| (format!("cameras[{at}].std_arcsec"), std, 0.0, MOST));
            std.into_iter().chain([(format!("cameras[{at}].gap_share"), camera.gap_share, 0.0, 1.0)])
        });
        for (path, value, from, to) in ranges.chain(of_cameras) {
            if !(from..=to).contains(&value) {
                return Err(Error::document(path, bare(value), format!("{} to {}", bare(from), bare(to))));
            }
        }
        if !(10.0..=MOST_ROWS).contains(&(self.rows() as f64)) {
            let found = format!("{} rows", bare(self.rows() as f64));
            return Err(Error::document("step_s", found, format!("10 to {} in all", bare(MOST_ROWS))));
        }
        let start = Start::parse(&self.start);
        let year = |after_s: f64| start?.after(after_s).year();
        match (start, year(-MOST_LATE_S), year(self.days * 86_400.0)) {
            (Some(start), Some(from), Some(to)) if from > 1973.0 && to < 2030.0 => Ok((start, [from, to])),
            _ => {
                let expected = "a moment such as 2025-03-01T00:00:00Z, for a flight between 1973 and 2030";
                Err(Error::document("start", format!("\"{}\"", self.start), expected))
            }
        }
    }
}
