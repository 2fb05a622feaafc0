//! One k and one O for a sensor, from the coil's field and from the reversals.

use common::number::{p_value, signed, uncertain};
use common::{Quantity, SensorCalibration};
use estimate::stats;

use crate::conditions::Conditions;
use crate::reversal::Turned;
use crate::sensitivity::{Constants, sensitivity_key};

/// Factor of a 95 % interval of the normal.
const NORMAL: f64 = 1.959_964;
/// Below this probability of a larger difference, the two offsets disagree.
const DISAGREE_BELOW: f64 = 0.01;

/// What O is joined of.
pub struct Seen<'a> {
    /// k and O in a coil.
    pub constants: Option<&'a Constants>,
    /// O by reversals.
    pub turned: Option<&'a Turned>,
    /// The effects of temperature that were taken off of both.
    pub conditions: &'a Conditions,
}

/// Writes what was found over what the document said; what was not recorded stays.
///
/// O is seen twice: in the coil, where errors of the coil's own offset come in, and by reversals. Where the two agree they are
/// joined by their uncertainties (and k with them, as far as it goes with O); where they do not, the reversals count. Errors of
/// the coefficients of temperature are in both and weigh for neither: at another reference temperature they are others, and the
/// offset has to be the same but for what it moves by.
pub fn into(entry: &mut SensorCalibration, mut found: SensorCalibration, seen: &Seen<'_>) {
    if let Some(constants) = seen.constants {
        let (values, covariance, finding) = joined(constants, seen.turned, seen.conditions);
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
    } else if let Some(reversal) = &found.reversal {
        entry.offset_nt = Some(reversal.offset_nt.clone());
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

fn joined(constants: &Constants, turned: Option<&Turned>, conditions: &Conditions) -> Joined {
    let alone = [constants.sensitivity, constants.offset_nt];
    let Some(turned) = turned else { return (alone, constants.covariance, None) };
    // Derivatives of k, of O and of the reversals' O by the parameters of the temperatures.
    let parameters = conditions.covariance.len();
    let of = |by: &dyn Fn(usize) -> Option<f64>| -> Vec<f64> {
        (0..parameters).map(|parameter| by(parameter).unwrap_or(0.0)).collect()
    };
    let by = [0, 1].map(|i| of(&|parameter| constants.by_temperature.get(parameter).map(|by| by[i])));
    let by_turned = of(&|parameter| turned.by_temperature.get(parameter).copied());
    let own = |i: usize, j: usize| constants.covariance[i][j] - conditions.between(&by[i], &by[j]);
    // A few degrees of freedom count as a wider normal.
    let turned_nt2 = turned.own_nt2 * (turned.coverage_factor_95 / NORMAL).powi(2);
    let difference = turned.offset_nt - constants.offset_nt;
    let variance = own(1, 1) + turned_nt2;
    if variance <= 0.0 {
        return (alone, constants.covariance, None);
    }
    let apart: Vec<f64> = by[1].iter().zip(&by_turned).map(|(a, b)| a - b).collect();
    let p = stats::chi_squared_p(difference * difference / (variance + conditions.variance(&apart)), 1.0);
    if p < DISAGREE_BELOW {
        let std = (turned_nt2 + conditions.variance(&by_turned)).sqrt();
        let finding = format!(
            "the offset in the coil is {} nT, by reversals {} nT: they do not agree ({}), and the reversals count; what is left in the coil, or its offset, may be wrong",
            signed(&uncertain(constants.offset_nt, constants.covariance[1][1].sqrt())),
            signed(&uncertain(turned.offset_nt, std)),
            p_value(p)
        );
        // k as it was, O as the reversals have it; the temperatures are in both.
        let both = conditions.between(&by[0], &by_turned);
        let covariance = [[constants.covariance[0][0], both], [both, std * std]];
        return ([constants.sensitivity, turned.offset_nt], covariance, Some(finding));
    }
    let gain = [own(0, 1) / variance, own(1, 1) / variance];
    let values = [alone[0] + gain[0] * difference, alone[1] + gain[1] * difference];
    let joined_by = [0, 1]
        .map(|i| -> Vec<f64> { by[i].iter().zip(&apart).map(|(by, apart)| by - gain[i] * apart).collect() });
    let left = |i: usize, j: usize| {
        own(i, j) - gain[i] * own(1, j) + conditions.between(&joined_by[i], &joined_by[j])
    };
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
            by_temperature: Vec::new(),
            nonlinearity: Vec::new(),
            largest_nt: 50_000.0,
            fit: SensitivityFit::default(),
        }
    }

    fn turned(offset_nt: f64, std: f64) -> Turned {
        Turned { offset_nt, own_nt2: std * std, coverage_factor_95: NORMAL, by_temperature: Vec::new() }
    }

    #[test]
    fn agreeing_offsets_are_joined() {
        // Equal weights: the mean, with half the variance; k moves by C_kO/(2 C_OO) of the difference.
        let (values, covariance, finding) =
            joined(&constants(), Some(&turned(1.2, 0.2)), &Conditions::default());
        assert!((values[1] - 1.1).abs() < 1e-12 && (covariance[1][1] - 0.02).abs() < 1e-12);
        assert!((values[0] - 6400.01).abs() < 1e-9 && (covariance[0][0] - 0.0098).abs() < 1e-12);
        assert!(finding.is_none());
    }

    #[test]
    fn of_offsets_that_disagree_the_reversals_count() {
        let (values, covariance, finding) =
            joined(&constants(), Some(&turned(3.0, 0.01)), &Conditions::default());
        assert_eq!(values, [6400.0, 3.0]);
        assert_eq!(covariance[1], [0.0, 0.01 * 0.01]);
        assert!(finding.is_some_and(|text| text.contains("do not agree")));
    }

    #[test]
    fn what_both_owe_to_the_temperatures_does_not_average_down() {
        // A coefficient known to 0.1 nT/K, both offsets taken 2 K from the reference: 0.2 nT in either, and in their mean.
        let conditions = Conditions { effects: Vec::new(), covariance: vec![vec![0.01]] };
        let mut warm = constants();
        (warm.by_temperature, warm.covariance[1][1]) = (vec![[0.0, 2.0]], 0.04 + 0.04);
        let both = Turned { by_temperature: vec![2.0], ..turned(1.2, 0.2) };
        let (values, covariance, _) = joined(&warm, Some(&both), &conditions);
        assert!((values[1] - 1.1).abs() < 1e-12 && (covariance[1][1] - (0.02 + 0.04)).abs() < 1e-12);
    }
}
