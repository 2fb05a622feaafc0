//! Where the iteration begins: the stated calibration, and the ellipsoid of linear least squares.

use common::{Axis, Document};
use estimate::Svd;
use faer::Mat;
use nalgebra::{Matrix3, Vector3};
use physics::Unit;

use crate::Error;
use crate::design::Scales;
use crate::given::Given;
use crate::model::{Model, NINE, PAIRS, State};
use crate::read::{Series, Source, sensitivity};
use crate::terms::{Factor, ONE};

/// Singular values of the linear fit below this share of the largest count as zero.
const RANK_TOLERANCE: f64 = 1e-10;
/// The ellipsoid's axes differ by less than this factor.
const MOST_UNLIKE: f64 = 1e3;

/// The units: the mean magnitude, or the largest swing by the stated sensitivities where it is not known; and
/// those sensitivities, or such that the largest swing of a sensor is one.
pub fn scales(document: &Document, unit: Unit, series: &[Series]) -> Scales {
    let known = series.iter().filter(|one| one.source != Source::Constant);
    let (sum, count) = known
        .flat_map(|one| &one.magnitude_nt)
        .fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    let swing = (0..3)
        .map(|axis| {
            let all = || series.iter().flat_map(|one| &one.readings[axis]).copied();
            0.5 * (all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min))
        })
        .fold(0.0, f64::max);
    scales_of(document, unit, (count > 0.0).then_some(sum / count), swing)
}

/// The same of the mean magnitude, where it is known, and the largest swing of a sensor.
pub fn scales_of(document: &Document, unit: Unit, mean_nt: Option<f64>, swing: f64) -> Scales {
    let stated = Axis::ALL.map(|axis| sensitivity(document, unit, axis));
    let magnitude_nt = mean_nt
        .unwrap_or_else(|| swing * stated.iter().flatten().map(|value| value.abs()).fold(0.0, f64::max));
    let nominal = magnitude_nt / swing.max(f64::MIN_POSITIVE);
    Scales { magnitude_nt, sensitivity: stated.map(|stated| stated.unwrap_or(nominal)) }
}

pub fn starts(given: &Given, model: &Model, factor: &Factor) -> Result<Vec<State>, Error> {
    let all = std::iter::once(given.nine).chain(ellipsoid(model, factor)?);
    Ok(all.map(|nine| model.with(&nine)).collect())
}

/// The ellipsoid vᵀAv + bᵀv + c = m² F² with trace A = 3 by linear least squares, in the nine parameters;
/// None where the form is that of no ellipsoid. Where the magnitude does not vary c and m² are one unknown,
/// which the solution of least norm shares out.
fn ellipsoid(model: &Model, factor: &Factor) -> Result<Option<[f64; NINE]>, Error> {
    let upper = factor.upper();
    let rows = upper.nrows();
    let trace = model.terms.product(0, 0);
    let pairs = [[1, 1], [2, 2], [0, 1], [0, 2], [1, 2], [0, ONE], [1, ONE], [2, ONE], [ONE, ONE]];
    let mut others = pairs.map(|[f, g]| model.terms.product(f, g)).to_vec();
    others.push(model.terms.count() - 1);
    let design = Mat::from_fn(rows, others.len(), |i, j| {
        if j < 2 { upper[(i, others[j])] - upper[(i, trace)] } else { upper[(i, others[j])] }
    });
    let right: Vec<f64> = (0..rows).map(|i| -3.0 * upper[(i, trace)]).collect();
    let x = Svd::of(design.as_ref(), RANK_TOLERANCE)?.solve(&right);
    let [xy, xz, yz] = [0.5 * x[2], 0.5 * x[3], 0.5 * x[4]];
    let form = Matrix3::new(3.0 - x[0] - x[1], xy, xz, xy, x[0], yz, xz, yz, x[1]);
    let own = form.symmetric_eigenvalues();
    if own.min().is_nan() || own.min() <= own.max() / MOST_UNLIKE {
        return Ok(None);
    }
    let Some(inverse) = form.try_inverse() else { return Ok(None) };
    let centre = -0.5 * inverse * Vector3::new(x[5], x[6], x[7]);
    // The typical magnitude is one.
    let size = centre.dot(&(form * centre)) - x[8] - x[9];
    if size.is_nan() || size <= 0.0 {
        return Ok(None);
    }
    let inverse = inverse * size;
    let k: [f64; 3] = std::array::from_fn(|axis| 1.0 / inverse[(axis, axis)].sqrt());
    let mut nine = [0.0; NINE];
    for axis in 0..3 {
        nine[axis] = k[axis];
        nine[3 + axis] = -k[axis] * centre[axis];
    }
    for (place, [a, b]) in PAIRS.iter().enumerate() {
        nine[6 + place] = k[*a] * inverse[(*a, *b)] * k[*b];
    }
    Ok(nine.iter().all(|value| value.is_finite()).then_some(nine))
}
