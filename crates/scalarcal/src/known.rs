//! What is known of the sensors beforehand, as rows of the fit, and how its errors enter the parameters.

use common::uncertainty::{self, By};
use common::{Axis, Document, Uncertainty};
use faer::{ColRef, Mat};
use physics::{Basic, Unit};

use crate::Error;
use crate::design::Scales;
use crate::linear::{Linear, root_of_free, unit as one};
use crate::model::{Model, NINE, PAIRS};
use crate::start;

/// A combination of which the variance is less than this share of the largest is not known beforehand but
/// fixed; it is left out.
const FIXED: f64 = 1e-12;

/// What a document states of the nine parameters with an uncertainty.
#[derive(Clone, Debug)]
pub struct Beforehand {
    pub nine: [f64; NINE],
    /// Parameters of the document, with the derivatives of the nine by each.
    pub by: By,
    /// As rows of the fit: combinations over their standard deviations.
    pub rows: Linear,
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
    let count = model.parameters.len();
    if there.is_empty() {
        return Ok(Beforehand { nine, by: By::new(), rows: Linear::none(count) });
    }
    let own = Mat::from_fn(there.len(), there.len(), |a, b| covariance[(there[a], there[b])]);
    let free = root_of_free(&own, FIXED);
    let at = |place: usize| there.iter().position(|other| *other == place);
    let jacobian = Mat::from_fn(free.nrows(), count, |i, place| at(place).map_or(0.0, |a| free[(i, a)]));
    let right = (jacobian.subcols(0, NINE) * ColRef::from_slice(&nine)).iter().copied().collect();
    Ok(Beforehand { nine, by, rows: Linear { jacobian, right } })
}

/// The derivatives of the nine by the parameters of the document.
fn derivatives(document: &Document, basic: &Basic, unit: Unit, scales: &Scales) -> By {
    let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    let added = |axis: Axis| axes.and_then(|axes| axes.offsets_nt.as_ref()?.get(axis)).is_some();
    let mut by = By::new();
    let single = |place: usize, value: f64| one(place, NINE).iter().map(|one| one * value).collect();
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
