//! Runs at several temperatures, and whose temperature moved in them.

use common::Axis;
use common::number::significant;
use faer::Mat;
use physics::{Kind, Thermometer};

use crate::Error;
use crate::departure::{beside, visible_share};
use crate::readings::{Run, span};

/// A temperature that moves by less than this in a recording is held, K.
const MOVED_K: f64 = 0.5;
/// Share of a temperature's changes that the other one's must leave.
const APART: f64 = 0.1;

/// A part whose temperature moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    Sensor,
    Electronics,
}

impl Part {
    pub const ALL: [Part; 2] = [Part::Sensor, Part::Electronics];

    /// The effects on sensitivity and offset, at once and with a lag.
    pub fn kinds(self) -> [[Kind; 2]; 2] {
        match self {
            Part::Sensor => [
                [Kind::SensitivityTemperature, Kind::SensitivityTemperatureLag],
                [Kind::OffsetTemperature, Kind::OffsetTemperatureLag],
            ],
            Part::Electronics => [
                [Kind::SensitivityElectronicsTemperature, Kind::SensitivityElectronicsTemperatureLag],
                [Kind::OffsetElectronicsTemperature, Kind::OffsetElectronicsTemperatureLag],
            ],
        }
    }

    /// Temperature less its reference in a run, K, by row.
    pub fn warmer(self, run: &Run<'_>) -> Result<Vec<f64>, Error> {
        let thermometer = match self {
            Part::Sensor => Thermometer::Sensor,
            Part::Electronics => Thermometer::Electronics,
        };
        let (column, reference) = run
            .context
            .temperature(thermometer, "a `temperature_run`")
            .map_err(|error| error.at(&format!("{}.columns", run.path)))?;
        Ok(column.iter().map(|t| t - reference).collect())
    }
}

/// The runs with the temperatures of each, and which moved.
pub struct Heated<'a> {
    pub runs: Vec<Run<'a>>,
    /// Temperature less reference of sensor and electronics for each run, K.
    pub warmer: Vec<[Vec<f64>; 2]>,
    /// Which parts moved and can be told apart.
    pub parts: Vec<Part>,
}

/// Which temperatures moved, and whether they can be told apart.
pub fn parts(
    sensor: Axis,
    runs: &[Run<'_>],
    warmer: &[[Vec<f64>; 2]],
    findings: &mut Vec<String>,
) -> Result<Vec<Part>, Error> {
    let moved = |at: usize| {
        runs.iter().zip(warmer).any(|(run, both)| span(run.rows.iter().map(|row| both[at][*row])) > MOVED_K)
    };
    let parts: Vec<Part> = Part::ALL.into_iter().filter(|part| moved(*part as usize)).collect();
    if parts.is_empty() {
        return Err(Error::Unanswerable(format!(
            "sensor {sensor}: neither temperature varies by more than {MOVED_K} K in any `temperature_run`; a coefficient needs at least two temperatures, a curvature three"
        )));
    }
    if parts.len() == 2 {
        // Each temperature against the other, both about their mean in each run.
        let rows: usize = runs.iter().map(|run| run.rows.len()).sum();
        let column = |at: usize| -> Vec<f64> {
            let each = runs.iter().zip(warmer);
            each.flat_map(|(run, both)| run.rows.iter().map(|row| both[at][*row]).collect::<Vec<_>>())
                .collect()
        };
        let columns = [column(0), column(1)];
        let number: Vec<usize> =
            runs.iter().enumerate().flat_map(|(number, run)| vec![number; run.rows.len()]).collect();
        let share = |of: usize, other: usize| {
            let means = Mat::from_fn(rows, runs.len(), |i, j| f64::from(u8::from(number[i] == j)));
            let with = beside(&means, &columns[other]);
            visible_share(&with, &columns[of]) / visible_share(&means, &columns[of])
        };
        let apart = share(0, 1).min(share(1, 0));
        if apart < APART {
            findings.push(format!(
                "the temperatures of sensor and electronics varied together (only {} % of the variance is independent), so no slope is assigned to either; heat one and hold the other constant",
                significant(100.0 * apart, 2)
            ));
            return Ok(Vec::new());
        }
    }
    Ok(parts)
}

/// How many temperatures there were, a kelvin apart: in all readings, or in those that show the sensitivity,
/// with at least half the largest drive.
pub fn distinct(heated: &Heated<'_>, part: Part, driven: bool) -> usize {
    let of_run = |(run, both): (&Run<'_>, &[Vec<f64>; 2])| {
        let drive = |row: usize| run.context.current_a[row][run.coil.index()].abs();
        let largest = run.rows.iter().map(|row| drive(*row)).fold(0.0, f64::max);
        let rows = run.rows.iter().filter(|row| !driven || drive(**row) >= 0.5 * largest);
        rows.map(|row| both[part as usize][*row]).collect::<Vec<_>>()
    };
    let mut all: Vec<f64> = heated.runs.iter().zip(&heated.warmer).flat_map(of_run).collect();
    all.sort_by(f64::total_cmp);
    let (mut levels, mut begin) = (1, all.first().copied().unwrap_or(0.0));
    for temperature in all {
        if temperature - begin > 1.0 {
            (levels, begin) = (levels + 1, temperature);
        }
    }
    levels
}
