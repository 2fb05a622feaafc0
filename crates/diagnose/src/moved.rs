//! How far the constants moved, and whether the calibration as stated still holds.

use common::{BaseShift, MovedConstant, Quantity, Verdict};
use estimate::stats::chi_squared_p;
use nalgebra::{DMatrix, DVector};
use physics::Parameter;

use crate::Outcome;
use crate::level::at_least_one;
use crate::model::{Model, Unknown, stated_std};

/// Share of a constant's precision that keeps directions which nothing determines in their place.
const RIDGE: f64 = 1e-12;
/// Eigenvalues of the stated constants below this are rounding.
const ROUNDING: f64 = 1e-9;
/// Another constant could have moved where χ² falls by no more than this less without it: odds of twenty.
const AS_GOOD: f64 = 6.0;

/// Shifts of all constants that the final fit determines.
pub fn shifts(model: &Model<'_>, outcome: &Outcome) -> Vec<BaseShift> {
    let scale = outcome.now.look.rest.scale();
    let of = |(k, (unknown, shift)): (usize, (&Unknown, &f64))| {
        let variance = outcome.now.fit.covariance[(k, k)];
        (*shift != 0.0 && variance.is_finite()).then(|| BaseShift {
            parameter: name(model, unknown),
            shift: Quantity::new(*shift, (variance * scale).sqrt()),
        })
    };
    model.unknowns.iter().zip(&outcome.now.fit.state.base).enumerate().filter_map(of).collect()
}

/// The constants that moved farther than the calibration states. Nothing is said beside an answer that leaves
/// open what the fit's constants are.
pub fn moved(model: &Model<'_>, outcome: &Outcome, level: f64) -> Vec<MovedConstant> {
    let open = matches!(outcome.verdict, Verdict::Unexplained | Verdict::Ambiguous);
    let Some(calibration) = model.observed.document.calibration.as_ref().filter(|_| !open) else {
        return Vec::new();
    };
    let stated: Vec<Option<f64>> =
        model.unknowns.iter().map(|unknown| stated_std(calibration, unknown)).collect();
    let mut held = Held::of(outcome, &stated);
    let mut found: Vec<MovedConstant> = Vec::new();
    let mut constants: Vec<&Unknown> = Vec::new();
    while let Some(next) = held.most_moved(level) {
        held.let_go(next.constant);
        constants.push(&model.unknowns[next.constant]);
        let (shift, std) = held.estimate(next.constant);
        found.push(MovedConstant {
            parameter: name(model, &model.unknowns[next.constant]),
            shift: Quantity::new(shift, std),
            stated_std: stated[next.constant].unwrap_or_default(),
            p_adjusted: next.p,
            alternatives: next.alternatives.iter().map(|k| name(model, &model.unknowns[*k])).collect(),
            cause: None,
        });
    }
    for (one, constant) in found.iter_mut().zip(&constants) {
        one.cause = cause(constant, &constants).map(str::to_string);
    }
    found
}

/// What moves a constant together with others that moved: offsets of coils as a constant field does, offsets of sensors
/// as hard iron, scales and directions of sensors as soft iron (nine numbers).
fn cause(constant: &Unknown, moved: &[&Unknown]) -> Option<&'static str> {
    let of = |unknown: &Unknown| match unknown {
        Unknown::Chain(Parameter::CoilOffset(_), _) => Some(("a constant field in the coils", 2)),
        Unknown::Chain(Parameter::SensorOffset(_), _) => {
            Some(("a constant field fixed to the sensors, as of hard iron", 2))
        }
        Unknown::Chain(Parameter::Sensitivity(_) | Parameter::SensorTurn(..), _) => {
            Some(("a field in proportion to the field, as of soft iron", 4))
        }
        _ => None,
    };
    let (cause, least) = of(constant)?;
    (moved.iter().filter(|other| of(other) == Some((cause, least))).count() >= least).then_some(cause)
}

/// What recordings say of the unknowns, with constants held where they are stated.
///
/// With b the unknowns of the fit, H their precision, and P that of what is stated (diagonal), both together
/// are best met at β = (H + P)⁻¹ H b, and χ² = (β − b)ᵀH(β − b) + βᵀPβ. Where the calibration holds, that has
/// as many degrees of freedom as stated constants are seen, and χ² falls by χ²(1) when the statement of one
/// of them is let go: the test by which geodesists find gross errors (Baarda 1968, A testing procedure for
/// use in geodetic networks).
struct Held {
    precision: DMatrix<f64>,
    fitted: DVector<f64>,
    stated: DVector<f64>,
}

/// A constant without whose statement the rest agrees best.
struct Moved {
    constant: usize,
    p: f64,
    alternatives: Vec<usize>,
}

impl Held {
    fn of(outcome: &Outcome, stated: &[Option<f64>]) -> Self {
        let jacobian = &outcome.now.fit.jacobian;
        let scale = outcome.now.look.rest.scale();
        let unknowns = jacobian.ncols();
        let dot = |i: usize, j: usize| -> f64 {
            let (a, b) = (jacobian.col_as_slice(i), jacobian.col_as_slice(j));
            a.iter().zip(b).map(|(a, b)| a * b).sum()
        };
        let mut precision = DMatrix::from_fn(unknowns, unknowns, |i, j| dot(i, j) / scale);
        for k in 0..unknowns {
            precision[(k, k)] *= 1.0 + RIDGE;
        }
        let base = &outcome.now.fit.state.base;
        let at = |k: usize| stated.get(k).copied().flatten().map_or(0.0, |std| 1.0 / (std * std));
        Self {
            precision,
            fitted: DVector::from_fn(unknowns, |k, _| base.get(k).copied().unwrap_or(0.0)),
            stated: DVector::from_fn(unknowns, |k, _| at(k)),
        }
    }

    /// Both precisions together, by a factor for each unknown that makes its diagonal one, and its inverse.
    fn together(&self, stated: &DVector<f64>) -> Option<DMatrix<f64>> {
        let all = &self.precision + DMatrix::from_diagonal(stated);
        let scale = all.diagonal().map(|value| if value > 0.0 { 1.0 / value.sqrt() } else { 0.0 });
        let mut scaled = DMatrix::from_fn(all.nrows(), all.ncols(), |i, j| scale[i] * all[(i, j)] * scale[j]);
        for k in 0..scaled.nrows() {
            scaled[(k, k)] += RIDGE;
        }
        let inverse = scaled.cholesky()?.inverse();
        Some(DMatrix::from_fn(all.nrows(), all.ncols(), |i, j| scale[i] * inverse[(i, j)] * scale[j]))
    }

    /// χ² of the statements with the recordings.
    fn chi_squared(&self, stated: &DVector<f64>) -> f64 {
        let Some(inverse) = self.together(stated) else { return 0.0 };
        let best = inverse * (&self.precision * &self.fitted);
        let apart = &best - &self.fitted;
        (&self.precision * &apart).dot(&apart) + best.component_mul(stated).dot(&best)
    }

    /// Degrees of freedom of that: how many combinations of stated constants the recordings see.
    fn freedom(&self) -> f64 {
        let Some(inverse) = self.together(&self.stated) else { return 0.0 };
        let root = self.stated.map(f64::sqrt);
        // P^½ (P⁻¹ − (H + P)⁻¹) P^½ over the stated ones.
        let seen = DMatrix::from_fn(root.len(), root.len(), |i, j| {
            let one = if i == j && root[i] > 0.0 { 1.0 } else { 0.0 };
            one - root[i] * inverse[(i, j)] * root[j]
        });
        seen.symmetric_eigenvalues().iter().filter(|value| **value > ROUNDING).count() as f64
    }

    fn let_go(&mut self, constant: usize) {
        self.stated[constant] = 0.0;
    }

    fn estimate(&self, constant: usize) -> (f64, f64) {
        let Some(inverse) = self.together(&self.stated) else { return (0.0, f64::INFINITY) };
        let best = &inverse * (&self.precision * &self.fitted);
        (best[constant], inverse[(constant, constant)].sqrt())
    }

    /// The constant that has moved, where chance does not allow at a level that all are where they are
    /// stated: by the fall of χ² of one among all, or by χ² as a whole.
    fn most_moved(&self, level: f64) -> Option<Moved> {
        let all: Vec<usize> = (0..self.stated.len()).filter(|k| self.stated[*k] > 0.0).collect();
        let whole = self.chi_squared(&self.stated);
        let fall = |k: usize| {
            let mut stated = self.stated.clone();
            stated[k] = 0.0;
            (whole - self.chi_squared(&stated), k)
        };
        let falls: Vec<(f64, usize)> = all.iter().map(|k| fall(*k)).collect();
        let (most, constant) = *falls.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
        let single = at_least_one(chi_squared_p(most, 1.0), all.len() as f64);
        let freedom = self.freedom();
        let joint = if freedom > 0.0 { chi_squared_p(whole, freedom) } else { 1.0 };
        let p = at_least_one(single.min(joint), 2.0);
        let others = falls.iter().filter(|(fall, k)| *k != constant && *fall > most - AS_GOOD);
        (p < level).then(|| Moved { constant, p, alternatives: others.map(|(_, k)| *k).collect() })
    }
}

/// The name of an unknown, which ends in its unit.
fn name(model: &Model<'_>, unknown: &Unknown) -> String {
    match unknown {
        Unknown::Chain(parameter, _) => match parameter {
            Parameter::Sensitivity(axis) => format!("sensors.{axis}.sensitivity"),
            Parameter::SensorOffset(axis) => format!("sensors.{axis}.offset_nt"),
            Parameter::SensorTurn(axis, which) => format!("axes.sensors.{axis}.turn_{which}_rad"),
            Parameter::CoilConstant(axis) => format!("coils.{axis}.constant_nt_per_a"),
            Parameter::CoilOffset(axis) => format!("coils.{axis}.offset_nt"),
            Parameter::CoilTurn(axis, which) => format!("axes.coils.{axis}.turn_{which}_rad"),
            Parameter::Effect(effect, parameter) => format!("effects[{effect}][{parameter}]"),
        },
        Unknown::Field(axis) => format!("axes.residual_field_nt.{axis}"),
        Unknown::Level(channel) => {
            let channel = &model.observed.channels[*channel];
            format!(
                "field of the shield in \"{}\", {}, nt",
                model.observed.runs[channel.run].recording.id, channel.column
            )
        }
        Unknown::Turn { setting, about } => format!("setting {setting} of the block about axis {about}, rad"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use noise::Stream;

    /// Constants, all but the last two stated, drawn with their uncertainty and with that of recordings.
    fn drawn(seed: u64) -> Held {
        let unknowns = 8;
        let mut stream = Stream::new(seed, "held");
        let root = DMatrix::from_fn(40, unknowns, |_, k| stream.normal() * 10f64.powi(k as i32 - 3));
        let precision = root.transpose() * &root;
        let stated =
            DVector::from_fn(unknowns, |k, _| if k < 6 { 10f64.powi(2 * k as i32 - 6) } else { 0.0 });
        let covariance = precision.clone().try_inverse().expect("an inverse");
        let errors = DVector::from_fn(unknowns, |_, _| stream.normal());
        let fitted = covariance.cholesky().expect("positive").l() * errors;
        let off = stated.map(|p| if p > 0.0 { stream.normal() / p.sqrt() } else { 0.0 });
        Held { precision, fitted: fitted + off, stated }
    }

    #[test]
    fn the_least_of_both_is_what_the_sum_of_covariances_gives() {
        let held = drawn(1);
        let mut all = held.precision.clone().try_inverse().expect("an inverse");
        for k in 0..8 {
            // What is not stated may be anywhere.
            all[(k, k)] += if held.stated[k] > 0.0 { 1.0 / held.stated[k] } else { 1e12 };
        }
        let expected = held.fitted.dot(&(all.try_inverse().expect("an inverse") * &held.fitted));
        let found = held.chi_squared(&held.stated);
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        assert_eq!(held.freedom(), 6.0);
    }

    #[test]
    fn constants_that_hold_are_told_as_often_as_the_level_says() {
        let draws = 2000;
        let told = (0..draws).filter(|seed| drawn(*seed).most_moved(0.05).is_some()).count();
        let share = told as f64 / f64::from(draws as u32);
        assert!((0.03..0.055).contains(&share), "{share}");
    }

    #[test]
    fn one_that_moved_is_told_by_its_size() {
        let (mut right, mut covered) = (0, 0);
        for seed in 0..200 {
            let mut held = drawn(seed);
            let std = 1.0 / held.stated[2].sqrt();
            held.fitted[2] += 20.0 * std;
            let moved = held.most_moved(0.01).expect("it moved");
            right += u32::from(moved.constant == 2);
            held.let_go(2);
            let (shift, uncertainty) = held.estimate(2);
            // From where it is stated, which is itself off by its uncertainty.
            covered += u32::from((shift - 20.0 * std).abs() < 2.0 * uncertainty.hypot(std));
        }
        assert!(right > 195 && covered > 180, "{right} {covered}");
    }
}
