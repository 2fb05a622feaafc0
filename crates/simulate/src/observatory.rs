//! Absolute measurements and a variometer at an observatory, with the errors that observers make.

mod field;
mod sheet;

use common::number::bare;
use common::time::Start;
use common::{Conditions, Document, Error, Recording, Versioned, parse, procedure};
use noise::Stream;
use physics::Components;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::bench::{MOST_ROWS, deviation};
use crate::planned::columns;
use field::Field;

/// What an observatory does in a number of weeks. All of it has defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ObservatoryPlan {
    /// Version of the format.
    pub fluxcal: u64,
    /// Of all that is drawn.
    pub seed: u64,
    /// RFC 3339, midnight.
    pub start: String,
    /// How long.
    pub weeks: usize,
    /// Measurements a week, all on one day.
    pub sets_a_week: usize,
    /// The field in the mean, north, east and down, nT.
    pub main_field_nt: [f64; 3],
    /// `hez` or `xyz`.
    pub components: String,
    /// Interval of the variometer, s.
    pub variometer_step_s: f64,
    /// Hours about noon at which the variometer is written on days of measurements; absent: all hours of all days.
    pub variometer_hours: Option<f64>,
    /// `null` or `residual`.
    pub method: String,
    /// Azimuth of the mark, degrees.
    pub mark_azimuth_deg: f64,
    /// The theodolite and its observer.
    pub theodolite: TheodolitePlan,
    /// What the baselines do.
    pub baseline: BaselinePlan,
}

/// Errors of the theodolite, its magnetometer, and the observer. Standard deviations unless it is said otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct TheodolitePlan {
    /// Of a circle reading, arcsec.
    pub circle_arcsec: f64,
    /// Of the levelling, about each horizontal axis, one for each set, arcsec.
    pub levelling_arcsec: f64,
    /// Of the magnetometer's axis to the telescope, about each axis; drawn once, arcsec.
    pub collimation_arcsec: f64,
    /// Of what the magnetometer reads in no field; drawn once, nT.
    pub offset_nt: f64,
    /// By how much that changes from measurement to measurement, nT.
    pub offset_changes_nt: f64,
    /// Of the magnetometer's reading, nT.
    pub residual_nt: f64,
    /// Of the stated time of a reading, s.
    pub time_s: f64,
    /// Of the scalar magnetometer, the same at all times, nT.
    pub scalar_nt: f64,
    /// The difference of F between the pillars, nT.
    pub pillar_difference_nt: f64,
    /// Share of measurements with something magnetic about the observer.
    pub magnetic_share: f64,
    /// Its field, of each component, nT.
    pub magnetic_nt: f64,
    /// Share of measurements with one circle misread.
    pub misread_share: f64,
    /// By how much, arcmin.
    pub misread_arcmin: f64,
}

/// What the baselines do, as field along the three sensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct BaselinePlan {
    /// Straight drift, standard deviation for each component, nT a year.
    pub drift_nt_per_year: f64,
    /// Random walk, nT after a year.
    pub walk_nt: f64,
    /// Of each annual wave, nT.
    pub annual_nt: f64,
    /// Days after the start at which all three step.
    pub step_days: Vec<f64>,
    /// Standard deviation of a step, nT.
    pub step_nt: f64,
    /// What a kelvin of the variometer's temperature adds to each component, nT.
    pub nt_per_k: [f64; 3],
}

impl Default for ObservatoryPlan {
    fn default() -> Self {
        Self {
            fluxcal: 1,
            seed: 1,
            start: "2025-01-06T00:00:00Z".into(),
            weeks: 52,
            sets_a_week: 2,
            main_field_nt: [20_900.0, 1_590.0, 43_840.0],
            components: "hez".into(),
            variometer_step_s: 10.0,
            variometer_hours: Some(1.0),
            method: "residual".into(),
            mark_azimuth_deg: 267.36,
            theodolite: TheodolitePlan::default(),
            baseline: BaselinePlan::default(),
        }
    }
}

impl Default for TheodolitePlan {
    fn default() -> Self {
        Self {
            circle_arcsec: 2.0,
            levelling_arcsec: 1.0,
            collimation_arcsec: 60.0,
            offset_nt: 5.0,
            offset_changes_nt: 0.3,
            residual_nt: 0.1,
            time_s: 2.0,
            scalar_nt: 0.1,
            pillar_difference_nt: 0.0,
            magnetic_share: 0.0,
            magnetic_nt: 3.0,
            misread_share: 0.0,
            misread_arcmin: 1.0,
        }
    }
}

impl Default for BaselinePlan {
    fn default() -> Self {
        Self {
            drift_nt_per_year: 2.0,
            walk_nt: 0.5,
            annual_nt: 0.5,
            step_days: Vec::new(),
            step_nt: 3.0,
            nt_per_k: [0.0; 3],
        }
    }
}

/// The document of an observatory, and what is true behind it.
#[derive(Clone, Debug)]
pub struct Observatory {
    /// The variometer and the measurements.
    pub document: Document,
    /// Unix time, s, and the baseline values then, in nT and rad: at every measurement, and every day at noon.
    pub truth: Vec<(f64, [f64; 3])>,
}

impl Versioned for ObservatoryPlan {
    fn format_version(&self) -> Option<u64> {
        Some(self.fluxcal)
    }
}

impl ObservatoryPlan {
    /// Reads a plan. Errors: as of every document; values that cannot be.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let plan: Self = parse(text)?;
        let check = |holds: bool, path: &str, found: String, expected: &str| {
            if holds { Ok(()) } else { Err(Error::document(path, found, expected)) }
        };
        let quoted = |text: &str| format!("\"{text}\"");
        let start = Start::parse(&plan.start);
        check(start.is_some(), "start", quoted(&plan.start), "a moment such as 2025-01-06T00:00:00Z")?;
        let is_midnight = start.is_some_and(|start| start.unix_s.rem_euclid(DAY_S) == 0.0);
        check(is_midnight, "start", quoted(&plan.start), "midnight in UTC")?;
        let along = Components::of(&plan.components);
        check(along.is_some(), "components", quoted(&plan.components), "\"hez\" or \"xyz\"")?;
        let is_method = ["null", "residual"].contains(&plan.method.as_str());
        check(is_method, "method", quoted(&plan.method), "\"null\" or \"residual\"")?;
        check((1..=1000).contains(&plan.weeks), "weeks", plan.weeks.to_string(), "1 to 1000")?;
        let hours = plan.variometer_hours.unwrap_or(24.0);
        let covered = 2.0 * hours * 3600.0 >= SET_S * (plan.sets_a_week as f64 + 0.5);
        let expected = "hours on either side of noon that cover the measurements, half an hour each";
        check(covered, "variometer_hours", hours.to_string(), expected)?;
        let sets = plan.sets_a_week;
        check(sets <= 20, "sets_a_week", sets.to_string(), "at most 20, half an hour each")?;
        let step_s = plan.variometer_step_s;
        check((1.0..=60.0).contains(&step_s), "variometer_step_s", step_s.to_string(), "1 to 60 s")?;
        let rows = (plan.weeks as f64) * plan.rows_a_week();
        let found = format!("{} rows of the variometer", bare(rows));
        check(rows <= MOST_ROWS, "variometer_step_s", found, &format!("at most {}", bare(MOST_ROWS)))?;
        let Self { theodolite: of, baseline, .. } = &plan;
        for (key, value) in [
            ("circle_arcsec", of.circle_arcsec),
            ("levelling_arcsec", of.levelling_arcsec),
            ("collimation_arcsec", of.collimation_arcsec),
            ("offset_nt", of.offset_nt),
            ("offset_changes_nt", of.offset_changes_nt),
            ("residual_nt", of.residual_nt),
            ("time_s", of.time_s),
            ("scalar_nt", of.scalar_nt),
            ("magnetic_nt", of.magnetic_nt),
        ] {
            deviation("theodolite", key, value)?;
        }
        for (key, value) in [
            ("drift_nt_per_year", baseline.drift_nt_per_year),
            ("walk_nt", baseline.walk_nt),
            ("annual_nt", baseline.annual_nt),
            ("step_nt", baseline.step_nt),
        ] {
            deviation("baseline", key, value)?;
        }
        for (key, share) in [("magnetic_share", of.magnetic_share), ("misread_share", of.misread_share)] {
            let is_share = (0.0..=1.0).contains(&share);
            check(is_share, &format!("theodolite.{key}"), share.to_string(), "a share from 0 to 1")?;
        }
        let [north, east, down] = plan.main_field_nt;
        let points_north = (100.0..=1e5).contains(&north.hypot(east)) && north > 0.0 && down.abs() <= 1e5;
        let found = format!("{:?}", plan.main_field_nt);
        check(points_north, "main_field_nt", found, "a field that points north, in nT")?;
        Ok(plan)
    }

    /// Rows of the variometer: on the day of measurements alone, or on every day.
    fn rows_a_week(&self) -> f64 {
        self.variometer_hours.map_or(7.0 * DAY_S, |hours| 7200.0 * hours.min(12.0)) / self.variometer_step_s
    }
}

/// Noise of a reading of the scalar magnetometer, nT.
const SCALAR_NOISE_NT: f64 = 0.05;
const DAY_S: f64 = 86_400.0;
/// One measurement takes so long with its pause, s.
const SET_S: f64 = 1_800.0;

/// Carries out a plan. Errors: a plan that [`ObservatoryPlan::parse`] refuses.
pub fn observatory(plan: &ObservatoryPlan) -> Result<Observatory, Error> {
    let start_s = Start::parse(&plan.start).map_or(0.0, |start| start.unix_s);
    let field = Field::new(plan);
    let mut document = Document {
        fluxcal: 1,
        title: Some("Absolute measurements, simulated".into()),
        ..Document::default()
    };
    let facility = document.facility.get_or_insert_default();
    facility.reference_std_nt = Some(plan.theodolite.scalar_nt);
    let days = plan.weeks * 7;
    let first = DAY_S / 2.0 - 0.5 * SET_S * plan.sets_a_week as f64;
    document.recordings.push(variometer(plan, &field, days));
    let mut truth: Vec<(f64, [f64; 3])> = Vec::new();
    let observer = sheet::Observer::new(plan);
    for week in 0..plan.weeks {
        for number in 0..plan.sets_a_week {
            // The third day of the week.
            let begin = (7 * week + 2) as f64 * DAY_S + first + number as f64 * SET_S;
            let name = format!("week-{:03}-{}", week + 1, number + 1);
            let (columns, middle) = observer.set(&field, begin, &name);
            let start = Start { unix_s: start_s + begin, offset_s: 0.0 }.text();
            let pillar = plan.theodolite.pillar_difference_nt;
            let stated = [("mark_azimuth_deg", plan.mark_azimuth_deg), ("pillar_difference_nt", pillar)];
            let extra = stated.map(|(name, value)| (name.to_string(), json!(value)));
            document.recordings.push(Recording {
                id: name,
                procedure: procedure::ABSOLUTE.into(),
                start,
                conditions: Conditions { extra: extra.into_iter().collect(), ..Conditions::default() },
                columns,
                ..Recording::default()
            });
            truth.push((start_s + middle, field.baseline(middle).into()));
        }
    }
    truth.extend((0..=days).map(|day| {
        let noon = (day as f64 + 0.5) * DAY_S;
        (start_s + noon, field.baseline(noon).into())
    }));
    Ok(Observatory { document, truth })
}

fn variometer(plan: &ObservatoryPlan, field: &Field, days: usize) -> Recording {
    let names =
        ["time_s", "sensor_x_nt", "sensor_y_nt", "sensor_z_nt", "reference_nt", "sensor_temperature_c"];
    let mut rows = Vec::new();
    let steps = (days as f64 * DAY_S / plan.variometer_step_s) as usize;
    let mut stream = Stream::new(plan.seed, "scalar");
    let scalar_off = plan.theodolite.scalar_nt * stream.normal() - plan.theodolite.pillar_difference_nt;
    for step in 0..steps {
        let time = step as f64 * plan.variometer_step_s;
        let of_day = time.rem_euclid(DAY_S) - DAY_S / 2.0;
        let hours = plan.variometer_hours.unwrap_or(24.0) * 3600.0;
        if of_day.abs() > hours || (plan.variometer_hours.is_some() && ((time / DAY_S) as usize) % 7 != 2) {
            continue;
        }
        let (reading, total) = field.read(time);
        let scalar = total.norm() + scalar_off + SCALAR_NOISE_NT * stream.normal();
        // Written to a hundredth of a nT, as variometers do.
        let rounded = |value: f64| (value * 100.0).round() / 100.0;
        let values = [reading.x, reading.y, reading.z, scalar, field.temperature_c(time)].map(rounded);
        let [x, y, z, scalar, temperature] = values;
        rows.push([time, x, y, z, scalar, temperature]);
    }
    let extra = [("components".to_string(), json!(plan.components))];
    Recording {
        id: "variometer".into(),
        procedure: procedure::VARIOMETER.into(),
        start: Some(plan.start.clone()),
        conditions: Conditions { extra: extra.into_iter().collect(), ..Conditions::default() },
        columns: columns(names, &rows),
        ..Recording::default()
    }
}
