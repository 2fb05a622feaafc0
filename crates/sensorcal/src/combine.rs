//! One k and one O for a sensor, from the coil's field and from the reversals.

use common::number::{p_value, signed, uncertain};
use common::{Quantity, SensorCalibration};
use estimate::stats;

use crate::sensitivity::{Constants, sensitivity_key};

/// Factor of a 95 % interval of the normal.
const NORMAL: f64 = 1.959_964;
/// Below this probability of a larger difference, the two offsets disagree.
const DISAGREE_BELOW: f64 = 0.01;

/// Writes what was found over what the document said; what was not recorded stays.
///
/// O is seen twice: in the coil, where errors of the coil's own offset come in, and by reversals. Where the two agree they are
/// joined by their uncertainties (and k with them, as far as it goes with O); where they do not, the reversals count.
pub fn into(entry: &mut SensorCalibration, mut found: SensorCalibration, constants: Option<&Constants>) {
    let reversal = found.reversal.as_ref().map(|reversal| reversal.offset_nt.clone());
    if let Some(constants) = constants {
        // A few degrees of freedom count as a wider normal.
        let widened = found.reversal.as_ref().map(|reversal| {
            let std = reversal.offset_nt.std().unwrap_or(0.0) * reversal.coverage_factor_95 / NORMAL;
            Quantity::new(reversal.offset_nt.value(), std)
        });
        let (values, covariance, finding) = joined(constants, widened.as_ref());
        let k = Quantity::new(values[0], covariance[0][0].sqrt());
        let key = sensitivity_key(constants.unit);
        match constants.unit {
            physics::Unit::Volt => entry.sensitivity_nt_per_v = Some(k),
            physics::Unit::Nanotesla => entry.sensitivity_nt_per_nt = Some(k),
        }
        entry.offset_nt = Some(Quantity::new(values[1], covariance[1][1].sqrt()));
        entry.covariance = Some(covariance.iter().map(|row| row.to_vec()).collect());
        entry.covariance_order = Some(vec![key.into(), "offset_nt".into()]);
        if let (Some(fit), Some(finding)) = (&mut found.sensitivity, finding) {
            fit.findings.push(finding);
        }
    } else if let Some(offset) = reversal {
        entry.offset_nt = Some(offset);
        (entry.covariance, entry.covariance_order) = (None, None);
    }
    let SensorCalibration { sensitivity, reversal, noise, drift, temperature, cross_field, .. } = found;
    entry.sensitivity = sensitivity.or(entry.sensitivity.take());
    entry.reversal = reversal.or(entry.reversal.take());
    entry.noise = noise.or(entry.noise.take());
    entry.drift = drift.or(entry.drift.take());
    entry.temperature = temperature.or(entry.temperature.take());
    entry.cross_field = cross_field.or(entry.cross_field.take());
}

type Joined = ([f64; 2], [[f64; 2]; 2], Option<String>);

fn joined(constants: &Constants, reversal: Option<&Quantity>) -> Joined {
    let c = constants.covariance;
    let alone = [constants.sensitivity, constants.offset_nt];
    let Some((offset, std)) = reversal.and_then(|offset| Some((offset.value(), offset.std()?))) else {
        return (alone, c, None);
    };
    let difference = offset - constants.offset_nt;
    let variance = c[1][1] + std * std;
    if variance <= 0.0 {
        return (alone, c, None);
    }
    let p = stats::chi_squared_p(difference * difference / variance, 1.0);
    if p < DISAGREE_BELOW {
        let finding = format!(
            "the offset in the coil is {} nT, by reversals {} nT: they do not agree ({}), and the reversals count; what is left in the coil, or its offset, may be wrong",
            signed(&uncertain(constants.offset_nt, c[1][1].sqrt())),
            signed(&uncertain(offset, std)),
            p_value(p)
        );
        // k as it was, O as the reversals have it.
        return ([constants.sensitivity, offset], [[c[0][0], 0.0], [0.0, std * std]], Some(finding));
    }
    let gain = [c[0][1] / variance, c[1][1] / variance];
    let values = [alone[0] + gain[0] * difference, alone[1] + gain[1] * difference];
    let left = |i: usize, j: usize| c[i][j] - gain[i] * c[1][j];
    (values, [[left(0, 0), left(0, 1)], [left(1, 0), left(1, 1)]], None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensitivity::Constants;
    use common::SensitivityFit;

    fn constants() -> Constants {
        Constants {
            unit: physics::Unit::Volt,
            sensitivity: 6400.0,
            offset_nt: 1.0,
            covariance: [[0.01, 0.004], [0.004, 0.04]],
            common: [[0.0; 2]; 2],
            nonlinearity: Vec::new(),
            largest_nt: 50_000.0,
            fit: SensitivityFit::default(),
        }
    }

    #[test]
    fn agreeing_offsets_are_joined() {
        // Equal weights: the mean, with half the variance; k moves by C_kO/(2 C_OO) of the difference.
        let (values, covariance, finding) = joined(&constants(), Some(&Quantity::new(1.2, 0.2)));
        assert!((values[1] - 1.1).abs() < 1e-12 && (covariance[1][1] - 0.02).abs() < 1e-12);
        assert!((values[0] - 6400.01).abs() < 1e-9 && (covariance[0][0] - 0.0098).abs() < 1e-12);
        assert!(finding.is_none());
    }

    #[test]
    fn of_offsets_that_disagree_the_reversals_count() {
        let (values, covariance, finding) = joined(&constants(), Some(&Quantity::new(3.0, 0.01)));
        assert_eq!(values, [6400.0, 3.0]);
        assert_eq!(covariance[1], [0.0, 0.01 * 0.01]);
        assert!(finding.is_some_and(|text| text.contains("do not agree")));
    }
}
