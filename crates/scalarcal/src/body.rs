//! The iron of the body on which the sensors are mounted, apart from the sensors' own calibration.
//!
//! Iron that turns with the sensors makes HB + h of the field B: h the field of what is magnetised, H − 1 of
//! what the field magnetises. The sensors read kV + O = μᵀ(HB + h), so that by themselves the recordings show
//! only both together: K = k/n, with n the lengths of the rows of μᵀH, offsets (O − μᵀh)/n, and the cosines
//! of those rows. With the sensors' own k, O and μ known, h = μ⁻ᵀ(O − n O') and HHᵀ = μ⁻ᵀ n G' n μ⁻¹. The
//! magnitude does not show a turn within H, of which the symmetric part is given.
//!
//! Source: P. Leliak, Identification and evaluation of magnetic-field sources of magnetic airborne detector
//! equipped aircraft, IRE Trans. ANE-8 (1961) 95.

use common::{Axis, BodyIron, Document, Quantity, Recording};
use estimate::{Svd, stats};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

use crate::Error;
use crate::directions::{frame, unmixed};
use crate::model::{NINE, cosines};
use crate::solved::Solved;

/// What is said of sensors on a body whose own calibration is not known.
pub const INCLUDED: &str = "offsets, sensitivities and angles include the iron of the body on which the sensors are mounted: to separate the two, also record the sensors away from it (conditions.mounted: false), or give --known with their own calibration";
/// Elements of the symmetric matrix, and their names.
const ELEMENTS: [(usize, usize, &str); 6] =
    [(0, 0, "xx"), (1, 1, "yy"), (2, 2, "zz"), (0, 1, "xy"), (1, 2, "yz"), (0, 2, "xz")];
/// Step of the derivatives.
const STEP: f64 = 1e-6;
/// Singular values of the covariance below this share of the largest are those of what is known exactly.
const EXACT: f64 = 1e-14;

/// What recordings say of where the sensors are: whether some are on a body, and some away from it.
pub fn mounted(document: &Document) -> [bool; 2] {
    let says = |mounted: bool| {
        document.recordings.iter().any(|recording| recording.conditions.mounted == Some(mounted))
    };
    [says(true), says(false)]
}

/// The recordings on the body, or those away from it. What does not say belongs to the body.
pub fn part(document: &Document, mounted: bool) -> Document {
    let mine = |recording: &&Recording| (recording.conditions.mounted != Some(false)) == mounted;
    Document { recordings: document.recordings.iter().filter(mine).cloned().collect(), ..document.clone() }
}

/// Refuses a document without the sensors' own calibration.
pub fn stated(document: &Document) -> Result<(), Error> {
    let calibration = document.calibration.as_ref();
    if Axis::ALL.iter().all(|axis| calibration.is_some_and(|calibration| calibration.sensor(*axis).is_some()))
    {
        return Ok(());
    }
    let expected = "the calibration of the sensors alone, as scalarcal writes it from recordings away from the body, or those recordings with conditions.mounted: false";
    Err(Error::document("calibration.sensors", "no calibration of all three sensors for --known", expected))
}

/// h over the magnitude, and the six elements of H − 1.
fn iron((own, both): (&[f64], &[f64]), like: &Matrix3<f64>) -> [f64; NINE] {
    let mu = frame(&own.to_vec(), like);
    let unmix = unmixed(&mu);
    let lengths = Vector3::from_fn(|axis, _| own[axis] / both[axis]);
    let offsets = Vector3::from_fn(|axis, _| own[3 + axis] - lengths[axis] * both[3 + axis]);
    let hard = unmix * offsets;
    let lengths = Matrix3::from_diagonal(&lengths);
    let square = unmix * lengths * cosines(&both.to_vec()) * lengths * unmix.transpose();
    let parts = square.symmetric_eigen();
    let roots = Matrix3::from_diagonal(&parts.eigenvalues.map(|value| value.max(0.0).sqrt()));
    let soft = parts.eigenvectors * roots * parts.eigenvectors.transpose() - Matrix3::identity();
    std::array::from_fn(|k| match k {
        0..3 => hard[k],
        _ => soft[(ELEMENTS[k - 3].0, ELEMENTS[k - 3].1)],
    })
}

/// The body's iron by a calibration on it and the sensors' own, in SEN.
pub fn of(solved: &Solved) -> Result<BodyIron, Error> {
    let given = &solved.given;
    let all = [&given.nine, &solved.found.state[..NINE]].concat();
    let moved = |place: usize, by: f64| {
        let mut all = all.clone();
        all[place] += by;
        iron(all.split_at(NINE), &given.mu)
    };
    let at = moved(0, 0.0);
    let by = |place: usize| (moved(place, STEP), moved(place, -STEP));
    let by: Vec<_> = (0..2 * NINE).map(by).collect();
    let slope = |k: usize, (up, down): &([f64; NINE], [f64; NINE])| (up[k] - down[k]) / (2.0 * STEP);
    let [by_own, by_both] = [0, NINE].map(|first| Mat::from_fn(NINE, NINE, |k, i| slope(k, &by[first + i])));
    let mut covariance = &by_both * solved.found.covariance.submatrix(0, 0, NINE, NINE) * by_both.transpose();
    covariance += &by_own * &given.covariance * by_own.transpose();
    let svd = Svd::of(covariance.as_ref(), EXACT)?;
    let chi_squared: f64 = svd.solve(&at).iter().zip(&at).map(|(a, b)| a * b).sum();
    let quantity = |place: usize, scale: f64| {
        Quantity::new(at[place] * scale, covariance[(place, place)].max(0.0).sqrt() * scale)
    };
    let hard = |axis: Axis| (axis, quantity(axis.index(), given.scales.magnitude_nt));
    let soft = |(place, (_, _, name)): (usize, (_, _, &str))| (name.to_string(), quantity(3 + place, 1e6));
    Ok(BodyIron {
        hard_iron_nt: Axis::ALL.into_iter().map(hard).collect(),
        soft_iron_ppm: ELEMENTS.into_iter().enumerate().map(soft).collect(),
        chi_squared,
        degrees_of_freedom: svd.rank() as f64,
        p_value: stats::chi_squared_p(chi_squared, svd.rank() as f64),
    })
}
