//! Free scales: 17 of the 18 unknowns of unconstrained directions.
//!
//! μ → s μ, η → η/s leaves every reading as it was, so that one of the six lengths cannot be seen. Five can:
//! the sensors' among each other, the coils' among each other, and the common product of both.

use common::number::{counted, p_value, signed, significant, uncertain};
use common::{Axis, Calibration, PerAxis, Quantity, ScaleResult, ScalesResult};
use estimate::stats;
use faer::Mat;
use nalgebra::{DMatrix, DVector};

use crate::unknowns::{Unknown, place};
use crate::{Observations, Solution};

/// Disagreements below this probability are called so.
const DISAGREES_P: f64 = 0.01;

pub fn describe(
    calibration: Option<&Calibration>,
    observations: &Observations,
    solution: &Solution,
) -> ScalesResult {
    let freedom = solution.noise_freedom;
    let state = &solution.fit.state;
    let sensitivity =
        |axis| calibration?.sensor(axis).and_then(|sensor| physics::sensitivity(sensor, observations.unit));
    let coil_constant = |axis| calibration?.coil(axis)?.constant_nt_per_a.as_ref();
    let sensors = group(
        &observations.sensors,
        |axis| (state.sensor_scale[axis.index()], sensitivity(axis).and_then(Quantity::relative_std)),
        |axis| place(&solution.meaning, Unknown::SensorScale(axis)),
    );
    let coils = group(
        &observations.coils,
        |axis| (state.coil_scale[axis.index()], coil_constant(axis).and_then(Quantity::relative_std)),
        |axis| place(&solution.meaning, Unknown::CoilScale(axis)),
    );
    let relative = |members: &[Member]| -> PerAxis<ScaleResult> {
        let share = 1.0 / members.len() as f64;
        let one = |(own, member): (usize, &Member)| {
            let weights: Vec<f64> = (0..members.len()).map(|k| f64::from(k == own) - share).collect();
            (member.axis, result(members, &weights, &solution.covariance, freedom))
        };
        members.iter().enumerate().map(one).collect()
    };
    let all: Vec<Member> = sensors.iter().chain(&coils).copied().collect();
    let weights: Vec<f64> = std::iter::repeat_n(1.0 / sensors.len() as f64, sensors.len())
        .chain(std::iter::repeat_n(1.0 / coils.len() as f64, coils.len()))
        .collect();
    let common = result(&all, &weights, &solution.covariance, freedom);
    let verdict = verdict(&sensors, &coils, &solution.covariance);
    ScalesResult { sensors: relative(&sensors), coils: relative(&coils), common, verdict }
}

/// One scale: its logarithm, the calibration's relative uncertainty, its place among the unknowns.
#[derive(Clone, Copy)]
struct Member {
    axis: Axis,
    logarithm: f64,
    gain: f64,
    calibration_std: f64,
    place: Option<usize>,
}

fn group(
    axes: &[Axis],
    scale: impl Fn(Axis) -> (f64, Option<f64>),
    place: impl Fn(Axis) -> Option<usize>,
) -> Vec<Member> {
    let member = |&axis: &Axis| {
        let (less_one, calibration_std) = scale(axis);
        Member {
            axis,
            logarithm: less_one.ln_1p(),
            gain: 1.0 / (1.0 + less_one),
            calibration_std: calibration_std.unwrap_or(0.0),
            place: place(axis),
        }
    };
    axes.iter().map(member).collect()
}

/// exp(Σ w ln s) with its uncertainties; the weights are such that what cannot be seen drops out.
fn result(members: &[Member], weights: &[f64], covariance: &Mat<f64>, freedom: f64) -> ScaleResult {
    let value =
        members.iter().zip(weights).map(|(member, weight)| weight * member.logarithm).sum::<f64>().exp();
    let mut variance = 0.0;
    for (a, wa) in members.iter().zip(weights) {
        for (b, wb) in members.iter().zip(weights) {
            if let (Some(i), Some(j)) = (a.place, b.place) {
                variance += wa * wb * a.gain * b.gain * covariance[(i, j)];
            }
        }
    }
    let calibration: f64 = members.iter().zip(weights).map(|(m, w)| (w * m.calibration_std).powi(2)).sum();
    let joined = (variance + calibration).sqrt();
    // Of a single sensor or coil the relative scale is 1 by definition.
    let sigmas = (joined > 0.0).then(|| (value - 1.0) / joined);
    ScaleResult {
        value,
        std: value * variance.max(0.0).sqrt(),
        calibration_std: calibration.sqrt(),
        sigmas,
        p_value: sigmas.map(|sigmas| stats::two_sided_p(sigmas, freedom)),
    }
}

/// What the scales say of the calibration, by χ² over everything that can be seen of them.
///
/// A single wrong constant moves all relative scales; so each constant is tried as the only one that is off.
fn verdict(sensors: &[Member], coils: &[Member], covariance: &Mat<f64>) -> String {
    let of_sensors = sensors.iter().map(|member| (format!("sensor {}", member.axis), member, 1.0));
    let of_coils = coils.iter().map(|member| (format!("coil {}", member.axis), member, -1.0));
    let members: Vec<(String, &Member, f64)> = of_sensors.chain(of_coils).collect();
    let count = members.len();
    // The trade μ → s μ, η → η/s is taken out of the logarithms and of their covariance.
    let trade = DVector::from_iterator(count, members.iter().map(|(_, _, sign)| *sign)).normalize();
    let seen = DMatrix::identity(count, count) - &trade * trade.transpose();
    let scales = &seen * DVector::from_iterator(count, members.iter().map(|(_, member, _)| member.logarithm));
    let joined = DMatrix::from_fn(count, count, |i, j| {
        let (a, b) = (members[i].1, members[j].1);
        let fitted = match (a.place, b.place) {
            (Some(p), Some(q)) => a.gain * b.gain * covariance[(p, q)],
            _ => 0.0,
        };
        fitted + if i == j { a.calibration_std.powi(2) } else { 0.0 }
    });
    let size = joined.diagonal().max();
    // Along the trade the variance is made large instead of zero: it then says nothing.
    let regular = &seen * joined * &seen + &trade * trade.transpose() * (1e6 * size);
    let Some(weight) = regular.try_inverse() else { return "the scales are not determined".into() };
    let chi_squared = (scales.transpose() * &weight * &scales)[(0, 0)];
    let freedom = (count - 1) as f64;
    let degrees = counted(count - 1, "degree");
    let p = stats::chi_squared_p(chi_squared, freedom);
    if p >= DISAGREES_P {
        return format!(
            "the readings agree with the sensitivities and coil constants of the calibration (χ² = {} with {degrees} of freedom, {})",
            significant(chi_squared, 3),
            p_value(p)
        );
    }
    let alone = |(k, (name, ..)): (usize, &(String, &Member, f64))| {
        let column = seen.column(k);
        let information = (column.transpose() * &weight * column)[(0, 0)];
        let size = (column.transpose() * &weight * &scales)[(0, 0)] / information;
        let left = chi_squared - size * size * information;
        let ppm = uncertain(size * 1e6, information.sqrt().recip() * 1e6);
        (left, format!("{name} by {} ppm", signed(&ppm)))
    };
    let mut single: Vec<(f64, String)> = members.iter().enumerate().map(alone).collect();
    single.sort_by(|a, b| a.0.total_cmp(&b.0));
    let explains = |left: f64| stats::chi_squared_p(left, freedom - 1.0) >= DISAGREES_P;
    let enough = single.iter().filter(|(left, _)| explains(*left));
    let enough: Vec<&str> = enough.map(|(_, name)| name.as_str()).collect();
    let explained = match enough.as_slice() {
        [] => "no single constant explains it".to_string(),
        [one] => format!("one constant explains it, {one}"),
        several => format!("any one of these explains it: {}", several.join("; ")),
    };
    format!(
        "the readings disagree with the calibration's sensitivities and coil constants (χ² = {} with {degrees} of freedom, {}); {explained}",
        significant(chi_squared, 3),
        p_value(p)
    )
}
