//! What is known of the sensors beforehand, as rows of the fit, and how its errors enter the parameters.

use common::uncertainty::{self, By};
use common::{Axis, Document, Uncertainty};
use faer::{Mat, Side};
use physics::{Basic, Unit};

use crate::Error;
use crate::design::Scales;
use crate::fit::PriorRows;
use crate::model::{Model, NINE, PAIRS};
use crate::start;

/// A combination of which the variance is less than this share of the largest is not known beforehand but
/// fixed; it is left out.
const FIXED: f64 = 1e-12;

/// What a document states of the nine parameters with an uncertainty.
#[derive(Clone, Debug, Default)]
pub struct Beforehand {
    /// Values.
    pub nine: [f64; NINE],
    /// Parameters of the document, with the derivatives of the nine by each.
    pub by: By,
    /// As rows of the fit: combinations over their standard deviations.
    pub rows: PriorRows,
}

/// Of a document, for a model whose first parameters are the nine.
///
/// # Errors
///
/// A stated covariance that none can be.
pub fn beforehand(
    document: &Document,
    unit: Unit,
    scales: &Scales,
    model: &Model,
) -> Result<Beforehand, Error> {
    let joint = Uncertainty::of(document)?;
    let nine = start::stated(document, unit, scales);
    let by = derivatives(document, &Basic::found(document, unit), unit, scales);
    let covariance = joint.covariance_by(&by);
    let std = |place: usize| covariance[(place, place)].max(0.0).sqrt();
    let there: Vec<usize> = (0..NINE).filter(|place| std(*place) > 0.0).collect();
    if there.is_empty() {
        return Ok(Beforehand { nine, ..Beforehand::default() });
    }
    // Scaled to a correlation, so that the units of the parameters do not decide what is fixed.
    let correlation = Mat::from_fn(there.len(), there.len(), |a, b| {
        covariance[(there[a], there[b])] / (std(there[a]) * std(there[b]))
    });
    let mut rows = PriorRows::new();
    if let Ok(own) = correlation.self_adjoint_eigen(Side::Lower) {
        for k in 0..there.len() {
            let value = own.S()[k];
            if value <= FIXED {
                continue;
            }
            let mut weights = vec![0.0; model.parameters.len()];
            for (a, place) in there.iter().enumerate() {
                weights[*place] = own.U()[(a, k)] / (std(*place) * value.sqrt());
            }
            let at: f64 = weights.iter().zip(&nine).map(|(weight, value)| weight * value).sum();
            rows.push((weights, at));
        }
    }
    Ok(Beforehand { nine, by, rows })
}

/// The derivatives of the nine by the parameters of the document.
fn derivatives(document: &Document, basic: &Basic, unit: Unit, scales: &Scales) -> By {
    let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    let added = |axis: Axis| axes.and_then(|axes| axes.offsets_nt.as_ref()?.get(axis)).is_some();
    let mut by = By::new();
    let single = |place: usize, value: f64| {
        let mut column = vec![0.0; NINE];
        column[place] = value;
        column
    };
    for axis in Axis::ALL {
        let k = axis.index();
        by.push((uncertainty::sensitivity(axis, unit.suffix()), single(k, 1.0 / scales.sensitivity[k])));
        // What axescal adds stands for the sum, where it is there.
        let path =
            if added(axis) { uncertainty::added_offset(axis) } else { uncertainty::sensor_offset(axis) };
        by.push((path, single(3 + k, 1.0 / scales.magnitude_nt)));
    }
    // The paths run over the cosines column by column: of column c, row r.
    for (number, path) in uncertainty::directions("sensors").into_iter().enumerate() {
        let (row, column) = (number % 3, number / 3);
        let mut moved = vec![0.0; NINE];
        for (place, [a, b]) in PAIRS.iter().enumerate() {
            if *a == column {
                moved[6 + place] += basic.mu[(row, *b)];
            }
            if *b == column {
                moved[6 + place] += basic.mu[(row, *a)];
            }
        }
        by.push((path, moved));
    }
    by
}
