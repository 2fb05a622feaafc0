//! What the rotations show least, and the rotation that would show it.

use common::WeakestDirection;
use common::covariance::between;
use common::number::{significant, vector};
use estimate::positive::Positive;
use faer::{Mat, RowRef, Side};
use indexmap::IndexMap;
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::design::Rows;
use crate::directions::unmixed;
use crate::model::{AXES, Model, State, own};
use crate::terms::ONE;

/// Rows that stand for all when further rotations are tried.
const SAMPLE: usize = 400;
/// Parameters with a smaller share of the weakest combination, of the largest one, are not named.
const NAMED: f64 = 0.3;
/// A combination more uncertain than this share of the magnitude is not determined: the fit is not linear.
pub const UNDETERMINED: f64 = 0.1;
/// Directions lie on a cone where they scatter about it by less than this share of how they scatter along it.
const ON_A_CONE: f64 = 0.02;
const ANGLES_DEG: [f64; 2] = [90.0, 45.0];

/// The direction of the field in SEN in some of the rows.
pub fn directions(
    rows: &Rows<'_>,
    model: &Model,
    state: &State,
    mu: &Matrix3<f64>,
) -> Vec<(usize, usize, Vector3<f64>)> {
    let all: Vec<(usize, usize)> = rows.places().collect();
    let step = all.len().div_ceil(SAMPLE).max(1);
    let (unmix, along) = (unmixed(mu), model.along(state));
    let of = |(number, row): (usize, usize)| {
        (number, row, unmix * Vector3::from(own(&along, &rows.z(number, row))))
    };
    all.into_iter().step_by(step).map(of).collect()
}

/// The weakest combination by the readings alone; `jacobian` is a factor of the whitened derivatives.
pub fn weakest(
    model: &Model,
    state: &State,
    jacobian: &Mat<f64>,
    (directions, magnitude_nt): (&[Vector3<f64>], f64),
    mu: &Matrix3<f64>,
) -> Option<WeakestDirection> {
    let information = jacobian.transpose() * jacobian;
    let (value, weakest) = least(&information)?;
    let named = named(model, &weakest);
    let std = (value > 0.0).then(|| magnitude_nt / value.sqrt());
    // The readings again, with the block turned.
    // Offsets: what is held is of others.
    let trace = |matrix: &Mat<f64>| (3..6).map(|k| matrix[(k, k)]).sum::<f64>();
    let weight = trace(&information) / trace(&information_of(model, state, directions, mu)?);
    let mut best: Option<(f64, f64, String)> = None;
    for angle in ANGLES_DEG {
        for (axis, name) in AXES.iter().enumerate() {
            let turn = Rotation3::from_axis_angle(&Vector3::ith_axis(axis), angle.to_radians());
            let turned: Vec<Vector3<f64>> = directions.iter().map(|field| turn * field).collect();
            let more = information_of(model, state, &turned, mu)?;
            let total = &information + more * faer::Scale(weight);
            let Some((after, _)) = least(&total) else { continue };
            // vᵀ I⁻¹ v.
            let along = |all: Positive| between(&all.inverse, &weakest, &weakest);
            let variance = Positive::of(&total).map_or(f64::INFINITY, along);
            if best.as_ref().is_none_or(|(before, ..)| after > *before * 1.1) {
                let words = format!("turned by {angle}° about its {name} axis");
                best = Some((after, variance.sqrt() * magnitude_nt, words));
            }
        }
    }
    let list: Vec<&str> = named.iter().map(|(name, _)| name.as_str()).collect();
    let together = match list.as_slice() {
        [] => "the calibration is least determined".into(),
        [one] => format!("{one} is least determined"),
        [rest @ .., last] => format!("{} and {last} cannot be separated well", rest.join(", ")),
    };
    let words = match cone(directions) {
        Some(axis) => format!("rotated only about {axis}: {together}"),
        None => together,
    };
    let (_, after, how) = best?;
    let remedy = format!(
        "record the same rotations again with the block {how}: this would determine the combination to {} nT",
        significant(after, 2)
    );
    Some(WeakestDirection {
        shares: named.into_iter().collect::<IndexMap<_, _>>(),
        std_nt: std.filter(|std| std.is_finite()),
        words,
        remedy,
        std_after_nt: Some(after).filter(|after| after.is_finite()),
    })
}

/// The parameters that make up most of a combination, the largest first, each with its share of the largest.
pub fn named(model: &Model, combination: &[f64]) -> Vec<(String, f64)> {
    let largest = combination.iter().map(|share| share.abs()).fold(0.0, f64::max);
    let counts = |(_, share): &(usize, &f64)| share.abs() >= NAMED * largest;
    let of = |(place, share): (usize, &f64)| (model.parameters[place].name(), share / largest);
    let mut named: Vec<(String, f64)> = combination.iter().enumerate().filter(counts).map(of).collect();
    named.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    named
}

/// The smallest eigenvalue of an information matrix, and its vector.
pub fn least(information: &Mat<f64>) -> Option<(f64, Vec<f64>)> {
    let own = information.self_adjoint_eigen(Side::Lower).ok()?;
    let values = own.S().column_vector();
    let place = (0..values.nrows()).min_by(|a, b| values[*a].total_cmp(&values[*b]))?;
    let largest = values.iter().copied().fold(0.0, f64::max);
    let value = if values[place] > 1e-15 * largest { values[place] } else { 0.0 };
    Some((value, (0..values.nrows()).map(|i| own.U()[(i, place)]).collect()))
}

/// Derivatives of |B| by the parameters at some fields, unweighted, as information; effects do not act there.
fn information_of(
    model: &Model,
    state: &State,
    fields: &[Vector3<f64>],
    mu: &Matrix3<f64>,
) -> Option<Mat<f64>> {
    let slopes = model.slopes(state)?;
    let columns = model.terms.columns;
    let (mut z, mut products) = (vec![0.0; columns + 1], vec![0.0; model.terms.count()]);
    let mut information = Mat::zeros(slopes.ncols(), slopes.ncols());
    for field in fields {
        for axis in 0..3 {
            z[axis] = (mu.column(axis).dot(field) - state[3 + axis]) / state[axis];
        }
        z[ONE] = 1.0;
        z[columns] = field.norm();
        model.terms.fill(&z, &mut products);
        let row = RowRef::from_slice(&products) * &slopes;
        information += row.transpose() * &row;
    }
    Some(information)
}

/// The axis about which directions turn, where they lie on a cone about it.
fn cone(directions: &[Vector3<f64>]) -> Option<String> {
    let units: Vec<Vector3<f64>> = directions.iter().map(Vector3::normalize).collect();
    let mean = units.iter().sum::<Vector3<f64>>() / units.len() as f64;
    let scatter: Matrix3<f64> = units.iter().map(|unit| (unit - mean) * (unit - mean).transpose()).sum();
    let own = scatter.symmetric_eigen();
    let mut sorted: [f64; 3] = own.eigenvalues.into();
    sorted.sort_by(f64::total_cmp);
    if sorted[0] > ON_A_CONE * sorted[1] || sorted[1] <= 0.0 {
        return None;
    }
    let axis: Vector3<f64> = own.eigenvectors.column(own.eigenvalues.imin()).into_owned();
    let nearest = axis.iamax();
    Some(if axis[nearest].abs() > 0.985 {
        AXES[nearest].to_string()
    } else {
        format!("the direction {} of SEN", vector(axis.into(), 0.01))
    })
}
