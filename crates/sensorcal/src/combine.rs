//! One k and one O for a sensor, from the coil's field and from the reversals.

use common::covariance::{self, between};
use common::number::{p_value, signed, uncertain};
use common::uncertainty::{self, Block};
use common::{Axis, Code, Finding, Quantity, SensorCalibration, Uncertainty};
use estimate::stats;
use faer::{Mat, mat};

use crate::conditions::Conditions;
use crate::reversal::Turned;
use crate::sensitivity::{Constants, sensitivity_key};
use crate::{Error, Result};

/// Below this probability of a larger difference, the two offsets disagree.
const DISAGREE_BELOW: f64 = 0.01;

/// Writes what was found over what the document said; what was not recorded stays.
///
/// O is seen twice: in the coil, where errors of the coil's own offset come in, and by reversals. Where the
/// two agree they are joined by their uncertainties (and k with them, as far as it goes with O); where they
/// do not, the reversals count. Errors of the coefficients of temperature are in both and weigh for neither:
/// they depend on the reference temperature, the offset otherwise does not.
pub fn into(
    entry: &mut SensorCalibration,
    mut found: SensorCalibration,
    (constants, turned): (Option<&Constants>, Option<&Turned>),
    conditions: &Conditions,
    (sensor, joint): (Axis, &mut Uncertainty),
) -> Result<()> {
    let mut put = |block: Block| joint.put(block).map_err(Error::Unanswerable);
    let offset = uncertainty::sensor_offset(sensor);
    if let Some(constants) = constants {
        let (gain, finding) = joined(constants, turned, conditions);
        put(block(constants, turned, conditions, gain))?;
        let difference = turned.map_or(0.0, |turned| turned.offset_nt - constants.offset_nt);
        let key = uncertainty::sensitivity(sensor, constants.unit.suffix());
        let k = quantity(joint, &key, constants.sensitivity + gain[0] * difference);
        match constants.unit {
            physics::Unit::Volt => entry.sensitivity_nt_per_v = Some(k),
            physics::Unit::Nanotesla => entry.sensitivity_nt_per_nt = Some(k),
        }
        entry.offset_nt = Some(quantity(joint, &offset, constants.offset_nt + gain[1] * difference));
        entry.covariance = Some(covariance::rows(&joint.covariance(&[key, offset])));
        entry.covariance_order = Some(vec![sensitivity_key(constants.unit).into(), "offset_nt".into()]);
        if let (Some(fit), Some(finding)) = (&mut found.sensitivity, finding) {
            fit.findings.push(finding);
        }
    } else if let Some(turned) = turned {
        put(Block {
            name: format!("sensor {sensor}: scatter of the reversals"),
            degrees_of_freedom: f64::INFINITY,
            parameters: vec![offset.clone()],
            covariance: mat![[turned.covered_nt2()]],
            by: by_turned(turned, conditions).map(|(path, by)| (path, vec![by])).collect(),
        })?;
        entry.offset_nt = Some(quantity(joint, &offset, turned.offset_nt));
        (entry.covariance, entry.covariance_order) = (None, None);
    }
    let SensorCalibration { sensitivity, reversal, noise, drift, temperature, cross_field, .. } = found;
    entry.sensitivity = sensitivity.or(entry.sensitivity.take());
    entry.reversal = reversal.or(entry.reversal.take());
    entry.noise = noise.or(entry.noise.take());
    entry.drift = drift.or(entry.drift.take());
    entry.temperature = temperature.or(entry.temperature.take());
    entry.cross_field = cross_field.or(entry.cross_field.take());
    Ok(())
}

/// A value with the uncertainty that the sources say.
pub fn quantity(joint: &Uncertainty, path: &str, value: f64) -> Quantity {
    Quantity::new(value, joint.std(path))
        .covered_by(stats::coverage_factor(0.95, joint.degrees_of_freedom(path)))
}

/// How O by reversals moves with each parameter of the temperatures.
fn by_turned(turned: &Turned, conditions: &Conditions) -> impl Iterator<Item = (String, f64)> {
    conditions.paths.iter().cloned().zip(turned.by_temperature.iter().copied())
}

/// What the coil shows with `gain` times the difference of the reversals' offset from its own.
fn block(constants: &Constants, turned: Option<&Turned>, conditions: &Conditions, gain: [f64; 2]) -> Block {
    let mut block = constants.block.clone();
    let Some(turned) = turned else { return block };
    let count = block.parameters.len();
    let gain: Vec<f64> = gain.into_iter().chain(std::iter::repeat(0.0)).take(count).collect();
    let own = &constants.block.covariance;
    let apart = own[(1, 1)] + turned.covered_nt2();
    block.covariance = Mat::from_fn(count, count, |i, j| {
        own[(i, j)] - gain[i] * own[(1, j)] - gain[j] * own[(i, 1)] + gain[i] * gain[j] * apart
    });
    for (_, by) in &mut block.by {
        let of_offset = by[1];
        by.iter_mut().zip(&gain).for_each(|(by, gain)| *by -= gain * of_offset);
    }
    block.by.extend(
        by_turned(turned, conditions).map(|(path, by)| (path, gain.iter().map(|gain| gain * by).collect())),
    );
    block
}

/// How much of the difference between the two offsets goes to k and to O, and what is to be said of it.
fn joined(
    constants: &Constants,
    turned: Option<&Turned>,
    conditions: &Conditions,
) -> ([f64; 2], Option<Finding>) {
    let alone = ([0.0; 2], None);
    let Some(turned) = turned else { return alone };
    // Derivatives of O and of the reversals' O by the parameters of the temperatures.
    let parameters = conditions.covariance.nrows();
    let of = |by: &dyn Fn(usize) -> Option<f64>| -> Vec<f64> {
        (0..parameters).map(|parameter| by(parameter).unwrap_or(0.0)).collect()
    };
    let by = [0, 1].map(|i| of(&|parameter| constants.by_temperature.get(parameter).map(|by| by[i])));
    let by_turned = of(&|parameter| turned.by_temperature.get(parameter).copied());
    let own =
        |i: usize, j: usize| constants.covariance[i][j] - between(&conditions.covariance, &by[i], &by[j]);
    let difference = turned.offset_nt - constants.offset_nt;
    let variance = own(1, 1) + turned.covered_nt2();
    if variance <= 0.0 {
        return alone;
    }
    let apart: Vec<f64> = by[1].iter().zip(&by_turned).map(|(a, b)| a - b).collect();
    let p = stats::chi_squared_p(difference * difference / (variance + conditions.variance(&apart)), 1.0);
    if p < DISAGREE_BELOW {
        let std = (turned.covered_nt2() + conditions.variance(&by_turned)).sqrt();
        let of_coil = (constants.offset_nt, constants.covariance[1][1].sqrt());
        let [own, reversed] = [of_coil, (turned.offset_nt, std)].map(|(nt, std)| signed(&uncertain(nt, std)));
        let p = p_value(p);
        let finding = Code::OffsetsDisagree.said(format!(
            "the offset in the coil is {own} nT, by reversals {reversed} nT: they disagree ({p}); the reversals are used. The residual field of the coil, or the coil's offset, may be wrong"
        ));
        // k as it was, O as the reversals have it.
        return ([0.0, 1.0], Some(finding));
    }
    ([own(0, 1) / variance, own(1, 1) / variance], None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensitivity::Constants;
    use common::{Findings, SensitivityFit};

    fn constants() -> Constants {
        let covariance = [[0.01, 0.004], [0.004, 0.04]];
        Constants {
            unit: physics::Unit::Volt,
            sensitivity: 6400.0,
            offset_nt: 1.0,
            covariance,
            common: [[0.0; 2]; 2],
            block: Block {
                name: "the coil".into(),
                degrees_of_freedom: f64::INFINITY,
                parameters: vec![uncertainty::sensitivity(Axis::X, "v"), uncertainty::sensor_offset(Axis::X)],
                covariance: Mat::from_fn(2, 2, |i, j| covariance[i][j]),
                by: Vec::new(),
            },
            by_temperature: Vec::new(),
            nonlinearity: Vec::new(),
            largest_nt: 50_000.0,
            fit: SensitivityFit::default(),
        }
    }

    fn turned(offset_nt: f64, std: f64) -> Turned {
        let normal = stats::coverage_factor(0.95, f64::INFINITY);
        Turned { offset_nt, own_nt2: std * std, coverage_factor_95: normal, by_temperature: Vec::new() }
    }

    /// k and O, their covariance, and what is said.
    fn found(
        constants: &Constants,
        turned: Turned,
        conditions: &Conditions,
        joint: Uncertainty,
    ) -> ([f64; 2], Vec<Vec<f64>>, Findings) {
        let (mut entry, mut joint) = (SensorCalibration::default(), joint);
        let fitted = SensorCalibration {
            sensitivity: Some(Box::new(constants.fit.clone())),
            ..SensorCalibration::default()
        };
        let offsets = (Some(constants), Some(&turned));
        into(&mut entry, fitted, offsets, conditions, (Axis::X, &mut joint)).expect("found");
        let values =
            [&entry.sensitivity_nt_per_v, &entry.offset_nt].map(|of| of.as_ref().expect("found").value());
        (values, entry.covariance.expect("found"), entry.sensitivity.expect("found").findings.clone())
    }

    #[test]
    fn agreeing_offsets_are_joined() {
        // Equal weights: the mean, with half the variance; k moves by C_kO/(2 C_OO) of the difference.
        let (values, covariance, findings) =
            found(&constants(), turned(1.2, 0.2), &Conditions::none(), Uncertainty::default());
        assert!((values[1] - 1.1).abs() < 1e-12 && (covariance[1][1] - 0.02).abs() < 1e-9);
        assert!((values[0] - 6400.01).abs() < 1e-9 && (covariance[0][0] - 0.0098).abs() < 1e-9);
        assert!(findings.is_empty());
    }

    #[test]
    fn of_offsets_that_disagree_the_reversals_count() {
        let (values, covariance, findings) =
            found(&constants(), turned(3.0, 0.01), &Conditions::none(), Uncertainty::default());
        assert_eq!(values, [6400.0, 3.0]);
        assert!(covariance[1][0].abs() < 1e-12 && (covariance[1][1] - 0.01 * 0.01).abs() < 1e-9);
        assert!(findings[0].contains("disagree"));
    }

    #[test]
    fn what_both_owe_to_the_temperatures_does_not_average_down() {
        // A coefficient known to 0.1 nT/K, both offsets taken 2 K from the reference: 0.2 nT in either, and
        // in their mean.
        let coefficient = Block {
            name: "temperature".into(),
            degrees_of_freedom: f64::INFINITY,
            parameters: vec!["coefficient".into()],
            covariance: mat![[0.01]],
            by: Vec::new(),
        };
        let mut joint = Uncertainty::default();
        joint.put(coefficient).expect("found");
        let conditions =
            Conditions { covariance: mat![[0.01]], paths: vec!["coefficient".into()], ..Conditions::none() };
        let mut warm = constants();
        (warm.by_temperature, warm.covariance[1][1]) = (vec![[0.0, 2.0]], 0.04 + 0.04);
        warm.block.by = vec![("coefficient".into(), vec![0.0, 2.0])];
        let both = Turned { by_temperature: vec![2.0], ..turned(1.2, 0.2) };
        let (values, covariance, _) = found(&warm, both, &conditions, joint);
        assert!((values[1] - 1.1).abs() < 1e-12 && (covariance[1][1] - (0.02 + 0.04)).abs() < 1e-9);
    }
}
