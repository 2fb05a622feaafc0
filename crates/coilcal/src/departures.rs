//! What a straight line may leave out, each as one further column of the fit.

use common::{Departure, Quantity};
use estimate::linear::{self, LinearFit};
use estimate::stats;
use faer::Mat;

use crate::Error;
use crate::levels::Level;
use crate::readings::Reading;
use crate::scatter::scatter;

/// A departure is claimed below this probability, adjusted for all that were looked for.
pub const FOUND_BELOW: f64 = 0.01;

/// A departure from B = k I + B0 (fields signed by the current).
pub struct DepartureKind {
    /// Its name in documents.
    pub name: &'static str,
    parameter: &'static str,
    /// Its column, by a reading and its time from the middle of the run.
    column: fn(&Reading, f64) -> f64,
    /// Whether it can only add to the magnitude.
    pub adds: bool,
}

/// All that are looked for.
pub static ALL: [DepartureKind; 7] = [
    // c I²: a curvature, opposite in the two ranges.
    kind("quadratic", "curvature_nt_per_a2", |reading, _| reading.current_a * reading.current_a),
    // d I³: a curvature, alike in both ranges.
    kind("cubic", "curvature_nt_per_a3", |reading, _| reading.current_a.powi(3)),
    // A field across the coil that is not nulled: |B| = √((kI + B0)² + B⊥²) ≈ |kI + B0| + B⊥²/(2 |kI + B0|).
    DepartureKind {
        adds: true,
        ..kind("transverse_field", "transverse_squared_nt2", |reading, _| 0.5 / reading.field_nt)
    },
    // The negative range is moved against the positive one.
    kind("jump_between_ranges", "negative_less_positive_nt", |reading, _| {
        f64::from(u8::from(reading.current_a < 0.0))
    }),
    // The constant of the negative range differs from that of the positive one.
    kind("constant_between_ranges", "negative_less_positive_nt_per_a", |reading, _| {
        reading.current_a.min(0.0)
    }),
    // The constant changes through the run, as when the coil heats.
    kind("constant_drift", "rate_nt_per_a_per_s", |reading, time_s| reading.current_a * time_s),
    // The offset changes through the run.
    kind("offset_drift", "rate_nt_per_s", |_, time_s| time_s),
];

const fn kind(
    name: &'static str,
    parameter: &'static str,
    column: fn(&Reading, f64) -> f64,
) -> DepartureKind {
    DepartureKind { name, parameter, column, adds: false }
}

impl PartialEq for DepartureKind {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// Fits offset, constant and the departures of `kinds` to the readings, weighted by their relative standard
/// deviations.
pub fn fit(readings: &[Reading], kinds: &[&DepartureKind], relative_std: &[f64]) -> Result<LinearFit, Error> {
    let middle_s = readings.iter().map(|reading| reading.time_s).sum::<f64>() / readings.len() as f64;
    let design = Mat::from_fn(readings.len(), 2 + kinds.len(), |row, column| match column {
        0 => 1.0,
        1 => readings[row].current_a,
        _ => (kinds[column - 2].column)(&readings[row], readings[row].time_s - middle_s),
    });
    let y: Vec<f64> = readings.iter().map(|reading| reading.field_nt).collect();
    Ok(linear::fit(design.as_ref(), &y, Some(relative_std))?)
}

/// Looks for each departure beside the line, by Student's t of its size in a common fit. The scatter is that
/// of the fit with the departure.
pub fn look(
    readings: &[Reading],
    levels: &[Level],
    relative_std: &[f64],
    declared: Option<f64>,
) -> Result<Vec<(&'static DepartureKind, Departure)>, Error> {
    let mut found = Vec::new();
    for kind in &ALL {
        let fit = fit(readings, &[kind], relative_std)?;
        // What belongs to one range alone is no further column where there is only one.
        if fit.rank < 3 || fit.freedom < 1.0 {
            continue;
        }
        let scatter = scatter(levels, &fit, declared);
        let std = fit.covariance[(2, 2)].sqrt() * scatter.std_nt;
        let size = fit.coefficients[2];
        let two_sided = stats::two_sided_p(size / std, scatter.freedom);
        let p_value = match kind.adds {
            true if size < 0.0 => 1.0 - two_sided / 2.0,
            true => two_sided / 2.0,
            false => two_sided,
        };
        let parameter = [(kind.parameter.to_string(), Quantity::new(size, std))].into_iter().collect();
        let name = kind.name.to_string();
        found.push((
            kind,
            Departure { departure: name, parameter, p_value, p_adjusted: p_value, found: false },
        ));
    }
    let count = found.len() as f64;
    for (_, departure) in &mut found {
        departure.p_adjusted = (departure.p_value * count).min(1.0);
    }
    Ok(found)
}
