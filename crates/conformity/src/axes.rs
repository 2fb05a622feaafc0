use common::number::{bare, counted};
use common::{Axis, Document, Quantity};
use nalgebra::Vector3;
use physics::frames::{ARCSEC, angle, matrix};

use crate::directions::Directions;
use crate::joint::Joint;
use crate::temperature::{Part, asked};
use crate::verdict::{Missing, Shown, ShownValue};
use crate::{Requirement, each_sensor, sensor_name};

const PAIRS: [(Axis, Axis); 3] = [(Axis::X, Axis::Y), (Axis::Y, Axis::Z), (Axis::X, Axis::Z)];

/// 90° less the angle between two sensors, deg: δ = asin(m_i · m_j). u(δ) = √(gᵀ C g)/cos δ, where g is m_j
/// for the elements of m_i and m_i for those of m_j.
pub fn orthogonality(document: &Document, joint: &Joint) -> Vec<Shown> {
    let directions = match Directions::of(document, joint) {
        Ok(directions) => directions,
        Err(why) => return vec![Err(Missing { of: "axes".into(), why: why.into() })],
    };
    let one = |(i, j): (Axis, Axis)| {
        let (own, other) = (directions.column(i), directions.column(j));
        let sine = own.dot(&other).clamp(-1.0, 1.0);
        let mut weights = [Vector3::zeros(); 3];
        (weights[i.index()], weights[j.index()]) = (other, own);
        let std = directions.variance(&weights).sqrt() / (1.0 - sine * sine).sqrt().max(f64::EPSILON);
        Ok(ShownValue {
            of: format!("sensors {i} and {j}"),
            value: sine.asin().to_degrees(),
            std: std.to_degrees(),
            gaps: Vec::new(),
            how: String::new(),
        })
    };
    PAIRS.map(one).into()
}

/// Largest standard uncertainty σ of a direction, arcsec, over all ways that it may turn. σ itself is
/// uncertain by σ/√(2ν), ν the degrees of freedom of the fit (JCGM 100, E.4.3).
pub fn known(document: &Document, joint: &Joint) -> Vec<Shown> {
    each_direction(document, joint, |directions, axis| {
        let value = directions.largest_std(axis) / ARCSEC;
        let std = directions.freedom.map_or(0.0, |freedom| value / (2.0 * freedom).sqrt());
        let how = match directions.freedom {
            Some(freedom) => format!("{} of freedom", counted(freedom.round() as usize, "degree")),
            None => "as stated, without degrees of freedom".into(),
        };
        (value, std, how)
    })
}

/// Angle between a sensor and its direction in `nominal_matrix`, arcsec. u² = the largest variance of the
/// direction over all ways that it may turn, and that of the nominal direction.
pub fn from_nominal(document: &Document, joint: &Joint, requirement: &Requirement) -> Vec<Shown> {
    let Some(rows) = &requirement.nominal_matrix else {
        let why = "the specification gives no `nominal_matrix`; put in the directions that were found before, and this document \
                   shows how far the sensors have turned since";
        return vec![Err(Missing { of: "axes".into(), why: why.into() })];
    };
    let nominal = matrix(rows);
    each_direction(document, joint, |directions, axis| {
        let meant = nominal.column(axis.index()).normalize();
        let own = directions.largest_std(axis) / ARCSEC;
        let std = own.hypot(requirement.nominal_std_arcsec.unwrap_or(0.0));
        (angle(&directions.column(axis), &meant) / ARCSEC, std, String::new())
    })
}

fn each_direction(
    document: &Document,
    joint: &Joint,
    one: impl Fn(&Directions, Axis) -> (f64, f64, String),
) -> Vec<Shown> {
    let directions = match Directions::of(document, joint) {
        Ok(directions) => directions,
        Err(why) => return vec![Err(Missing { of: "axes".into(), why: why.into() })],
    };
    let found = |axis: Axis| {
        let (value, std, how) = one(&directions, axis);
        Ok(ShownValue { of: sensor_name(axis), value, std, gaps: Vec::new(), how })
    };
    Axis::ALL.map(found).into()
}

/// How far a sensor turns between the reference and the farther end of the temperatures, arcsec: √(a² + b²)
/// |ΔT|, with a and b of `axis_temperature` in the model. u is the larger of u(a) and u(b), times |ΔT|.
pub fn over_temperature(document: &Document, requirement: &Requirement) -> Vec<Shown> {
    each_sensor(document, |axis: Axis| {
        let missing = |why: String| Missing { of: sensor_name(axis), why };
        let [a, b] = turn_per_k(document, axis).ok_or_else(|| {
            missing(
                "the document's model has no `axis_temperature`; record `axes_orientation` at several temperatures, and \
                 diagnose shows whether the axes turn"
                    .into(),
            )
        })?;
        let range = asked(document, axis, Part::Sensor, requirement.sensor_temperature_c).map_err(missing)?;
        let far = range.warmer().map(f64::abs).into_iter().fold(0.0, f64::max);
        let std = a.std().zip(b.std()).map(|(a, b)| a.max(b));
        let std = std
            .ok_or_else(|| missing("`axis_temperature` of the model has no uncertainty; state one".into()))?;
        Ok(ShownValue {
            of: sensor_name(axis),
            value: a.value().hypot(b.value()) * far,
            std: std * far,
            gaps: range.gap.into_iter().collect(),
            how: format!("{} K from the reference", bare(far)),
        })
    })
}

/// The parameters of `axis_temperature` of a sensor, arcsec/K.
pub fn turn_per_k(document: &Document, axis: Axis) -> Option<[&Quantity; 2]> {
    let mut effects = document.model.iter().flat_map(|model| &model.effects);
    let effect = effects.find(|effect| {
        effect.effect == "axis_temperature" && effect.sensor == Some(axis) && effect.recording.is_none()
    })?;
    Some([effect.parameters.get("first_arcsec_per_k")?, effect.parameters.get("second_arcsec_per_k")?])
}
