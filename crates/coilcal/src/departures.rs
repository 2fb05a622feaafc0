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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DepartureKind {
    /// c I²: a curvature, opposite in the two ranges.
    Quadratic,
    /// d I³: a curvature, alike in both ranges.
    Cubic,
    /// A field across the coil that is not nulled: |B| = √((kI + B0)² + B⊥²) ≈ |kI + B0| + B⊥²/(2 |kI + B0|).
    Transverse,
    /// The negative range is moved against the positive one.
    Jump,
    /// The constant of the negative range differs from that of the positive one.
    RangeConstant,
    /// The constant changes through the run, as when the coil heats.
    ConstantDrift,
    /// The offset changes through the run.
    OffsetDrift,
}

impl DepartureKind {
    /// All that are looked for.
    pub const ALL: [DepartureKind; 7] = [
        DepartureKind::Quadratic,
        DepartureKind::Cubic,
        DepartureKind::Transverse,
        DepartureKind::Jump,
        DepartureKind::RangeConstant,
        DepartureKind::ConstantDrift,
        DepartureKind::OffsetDrift,
    ];

    /// Its name in documents.
    pub fn name(self) -> &'static str {
        match self {
            DepartureKind::Quadratic => "quadratic",
            DepartureKind::Cubic => "cubic",
            DepartureKind::Transverse => "transverse_field",
            DepartureKind::Jump => "jump_between_ranges",
            DepartureKind::RangeConstant => "constant_between_ranges",
            DepartureKind::ConstantDrift => "constant_drift",
            DepartureKind::OffsetDrift => "offset_drift",
        }
    }

    fn parameter(self) -> &'static str {
        match self {
            DepartureKind::Quadratic => "curvature_nt_per_a2",
            DepartureKind::Cubic => "curvature_nt_per_a3",
            DepartureKind::Transverse => "transverse_squared_nt2",
            DepartureKind::Jump => "negative_less_positive_nt",
            DepartureKind::RangeConstant => "negative_less_positive_nt_per_a",
            DepartureKind::ConstantDrift => "rate_nt_per_a_per_s",
            DepartureKind::OffsetDrift => "rate_nt_per_s",
        }
    }

    /// Its column; times count from the middle of the run.
    fn column(self, reading: &Reading, middle_s: f64) -> f64 {
        let current = reading.current_a;
        match self {
            DepartureKind::Quadratic => current * current,
            DepartureKind::Cubic => current.powi(3),
            DepartureKind::Transverse => 0.5 / reading.field_nt,
            DepartureKind::Jump => f64::from(u8::from(current < 0.0)),
            DepartureKind::RangeConstant => current.min(0.0),
            DepartureKind::ConstantDrift => current * (reading.time_s - middle_s),
            DepartureKind::OffsetDrift => reading.time_s - middle_s,
        }
    }
}

/// Fits offset, constant and the departures of `kinds` to the readings, weighted by their relative standard
/// deviations.
pub fn fit(readings: &[Reading], kinds: &[DepartureKind], relative_std: &[f64]) -> Result<LinearFit, Error> {
    let middle_s = readings.iter().map(|reading| reading.time_s).sum::<f64>() / readings.len() as f64;
    let design = Mat::from_fn(readings.len(), 2 + kinds.len(), |row, column| match column {
        0 => 1.0,
        1 => readings[row].current_a,
        _ => kinds[column - 2].column(&readings[row], middle_s),
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
) -> Result<Vec<(DepartureKind, Departure)>, Error> {
    let mut found = Vec::new();
    let both = readings.iter().any(|r| r.current_a < 0.0) && readings.iter().any(|r| r.current_a > 0.0);
    for kind in DepartureKind::ALL {
        if matches!(kind, DepartureKind::Jump | DepartureKind::RangeConstant) && !both {
            continue;
        }
        let fit = fit(readings, &[kind], relative_std)?;
        if fit.rank < 3 || fit.freedom < 1.0 {
            continue;
        }
        let scatter = scatter(levels, &fit, declared);
        let std = fit.covariance[(2, 2)].sqrt() * scatter.std_nt;
        let size = fit.coefficients[2];
        // A field across the coil can only add to the magnitude.
        let two_sided = stats::two_sided_p(size / std, scatter.freedom);
        let p_value = match kind {
            DepartureKind::Transverse if size < 0.0 => 1.0 - two_sided / 2.0,
            DepartureKind::Transverse => two_sided / 2.0,
            _ => two_sided,
        };
        let parameter = [(kind.parameter().to_string(), Quantity::new(size, std))].into_iter().collect();
        let name = kind.name().to_string();
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
