//! The directions of the sensors, and what is required of them.

use common::covariance::between;
use common::number::{bare, counted};
use common::{Axis, Document, Quantity, uncertainty};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};
use physics::frames::{ARCSEC, angle, matrix};

use crate::conformity::joint::{Joint, adopted, axes};
use crate::conformity::spec::Requirement;
use crate::conformity::temperature::{Part, asked};
use crate::conformity::verdict::{Shown, ShownValue, shown};

/// μ with its covariance, as the document has them.
pub struct Directions {
    /// Columns = unit vectors of the sensors in SEN.
    pub mu: Matrix3<f64>,
    /// Covariance of the nine cosines, column by column, rad², scaled so that standard uncertainties are
    /// normal.
    covariance: Mat<f64>,
    /// Degrees of freedom behind it, where they are known.
    pub freedom: Option<f64>,
}

impl Directions {
    /// From `calibration.axes.sensors`. What is missing otherwise, in words.
    pub fn of(document: &Document, joint: &Joint) -> Result<Self, &'static str> {
        let axes = axes(document);
        let rows = axes.and_then(|axes| axes.sensors.as_ref()?.matrix.as_ref()).ok_or(
            "the document holds no directions of three sensors; axescal finds them from `axes_orientation`",
        )?;
        let mut mu = matrix(rows);
        mu.column_iter_mut().for_each(|mut column| _ = column.normalize_mut());
        let fit = axes.and_then(|axes| axes.fit.as_ref());
        let freedom = fit.map(|fit| fit.degrees_of_freedom).filter(|freedom| *freedom > 0.0);
        let covariance = joint.covariance(&uncertainty::directions("sensors"));
        if (0..3).any(|i| (0..3).all(|r| covariance[(3 * i + r, 3 * i + r)] == 0.0)) {
            return Err("the directions have no uncertainty; axescal gives one, or state `std_arcsec`");
        }
        Ok(Self { mu, covariance, freedom })
    }

    pub fn column(&self, axis: Axis) -> Vector3<f64> {
        self.mu.column(axis.index()).into_owned()
    }

    /// Largest standard uncertainty of a direction over all ways that it may turn, rad.
    pub fn largest_std(&self, axis: Axis) -> f64 {
        let first = 3 * axis.index();
        let own = Matrix3::from_fn(|r, s| self.covariance[(first + r, first + s)]);
        (0.5 * (own + own.transpose())).symmetric_eigenvalues().max().max(0.0).sqrt()
    }

    /// Variance of Σ g_i · m_i (delta method), for weights of one vector a sensor.
    pub fn variance(&self, weights: &[Vector3<f64>; 3]) -> f64 {
        let weights: Vec<f64> = weights.iter().flatten().copied().collect();
        between(&self.covariance, &weights, &weights).max(0.0)
    }
}

const PAIRS: [(Axis, Axis); 3] = [(Axis::X, Axis::Y), (Axis::Y, Axis::Z), (Axis::X, Axis::Z)];

/// What is shown of each pair of sensors, or each sensor: of what, value, standard uncertainty and how.
fn each<T>(
    document: &Document,
    joint: &Joint,
    all: [T; 3],
    one: impl Fn(&Directions, T) -> (String, f64, f64, String),
) -> Vec<Shown> {
    match Directions::of(document, joint) {
        Err(why) => vec![shown("axes", Err(why.into()))],
        Ok(directions) => all
            .map(|of| {
                let (of, value, std, how) = one(&directions, of);
                Ok(ShownValue { of, value, std, how, ..ShownValue::default() })
            })
            .into(),
    }
}

/// 90° less the angle between two sensors, deg: δ = asin(m_i · m_j). u(δ) = √(gᵀ C g)/cos δ, where g is m_j
/// for the elements of m_i and m_i for those of m_j.
pub fn orthogonality(document: &Document, joint: &Joint) -> Vec<Shown> {
    each(document, joint, PAIRS, |directions, (i, j)| {
        let (own, other) = (directions.column(i), directions.column(j));
        let sine = own.dot(&other).clamp(-1.0, 1.0);
        let mut weights = [Vector3::zeros(); 3];
        (weights[i.index()], weights[j.index()]) = (other, own);
        let std = directions.variance(&weights).sqrt() / (1.0 - sine * sine).sqrt().max(f64::EPSILON);
        (format!("sensors {i} and {j}"), sine.asin().to_degrees(), std.to_degrees(), String::new())
    })
}

/// Largest standard uncertainty σ of a direction, arcsec, over all ways that it may turn. σ itself is
/// uncertain by σ/√(2ν), ν the degrees of freedom of the fit (JCGM 100, E.4.3).
pub fn known(document: &Document, joint: &Joint) -> Vec<Shown> {
    each(document, joint, Axis::ALL, |directions, axis| {
        let value = directions.largest_std(axis) / ARCSEC;
        let std = directions.freedom.map_or(0.0, |freedom| value / (2.0 * freedom).sqrt());
        let how = match directions.freedom {
            Some(freedom) => format!("{} of freedom", counted(freedom.round() as usize, "degree")),
            None => "as stated, without degrees of freedom".into(),
        };
        (format!("sensor {axis}"), value, std, how)
    })
}

/// Angle between a sensor and its direction in `nominal_matrix`, arcsec. u² = the largest variance of the
/// direction over all ways that it may turn, and that of the nominal direction.
pub fn from_nominal(document: &Document, joint: &Joint, requirement: &Requirement) -> Vec<Shown> {
    let Some(rows) = &requirement.nominal_matrix else {
        let why = "the specification gives no `nominal_matrix`; put in the directions that were found before, and this document \
                   shows how far the sensors have turned since";
        return vec![shown("axes", Err(why.into()))];
    };
    let nominal = matrix(rows);
    each(document, joint, Axis::ALL, |directions, axis| {
        let meant = nominal.column(axis.index()).normalize();
        let own = directions.largest_std(axis) / ARCSEC;
        let std = own.hypot(requirement.nominal_std_arcsec.unwrap_or(0.0));
        let turned = angle(&directions.column(axis), &meant) / ARCSEC;
        (format!("sensor {axis}"), turned, std, String::new())
    })
}

/// How far a sensor turns between the reference and the farther end of the temperatures, arcsec: √(a² + b²)
/// |ΔT|, with a and b of `axis_temperature` in the model. u is the larger of u(a) and u(b), times |ΔT|.
pub fn over_temperature(
    document: &Document,
    requirement: &Requirement,
    axis: Axis,
) -> Result<ShownValue, String> {
    let [a, b] = turn_per_k(document, axis).ok_or(
            "the document's model has no `axis_temperature`; record `axes_orientation` at several temperatures, and \
             diagnose shows whether the axes turn",
        )?;
    let range = asked(document, axis, Part::Sensor, requirement)?;
    let far = range.warmer.map(f64::abs).into_iter().fold(0.0, f64::max);
    let std = a.std().zip(b.std()).map(|(a, b)| a.max(b));
    let std = std.ok_or("`axis_temperature` of the model has no uncertainty; state one")?;
    Ok(ShownValue {
        value: a.value().hypot(b.value()) * far,
        std: std * far,
        gaps: range.gap.into_iter().collect(),
        how: format!("{} K from the reference", bare(far)),
        ..ShownValue::default()
    })
}

/// The parameters of `axis_temperature` of a sensor, arcsec/K.
pub fn turn_per_k(document: &Document, axis: Axis) -> Option<[&Quantity; 2]> {
    let effect = adopted(document, "axis_temperature", axis)?;
    Some([effect.parameters.get("first_arcsec_per_k")?, effect.parameters.get("second_arcsec_per_k")?])
}
