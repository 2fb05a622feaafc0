//! Free scales: 17 of the 18 unknowns of unconstrained directions.
//!
//! μ → s μ, η → η/s leaves every reading as it was, so that one of the six lengths cannot be seen. Five can:
//! the sensors' among each other, the coils' among each other, and the common product of both.

use common::{Axis, Calibration, PerAxis, ScaleResult, ScalesResult};
use estimate::stats;
use faer::Mat;

use crate::observations::relative_std;
use crate::unknowns::Unknown;
use crate::{Observations, Solution};

/// Disagreements below this probability are called so.
const DISAGREES_P: f64 = 0.01;

/// The scales of a solution that left them free.
pub fn describe(
    calibration: Option<&Calibration>,
    observations: &Observations,
    solution: &Solution,
) -> ScalesResult {
    let freedom = if solution.chi_squared.is_some() && solution.noise_factor == 1.0 {
        f64::INFINITY
    } else {
        solution.degrees_of_freedom
    };
    let state = &solution.fit.state;
    let sensors = group(
        &observations.sensors,
        |axis| (state.sensor_scale[axis.index()], relative_std(sensor_constant(calibration, axis))),
        |axis| place(solution, Unknown::SensorScale(axis)),
    );
    let coils = group(
        &observations.coils,
        |axis| (state.coil_scale[axis.index()], relative_std(coil_constant(calibration, axis))),
        |axis| place(solution, Unknown::CoilScale(axis)),
    );
    let relative = |members: &[Member]| -> PerAxis<ScaleResult> {
        let share = 1.0 / members.len() as f64;
        members
            .iter()
            .enumerate()
            .map(|(own, member)| {
                let weights: Vec<f64> = (0..members.len()).map(|k| f64::from(k == own) - share).collect();
                (member.axis, result(members, &weights, &solution.covariance, freedom))
            })
            .collect()
    };
    let all: Vec<Member> = sensors.iter().chain(&coils).copied().collect();
    let weights: Vec<f64> = std::iter::repeat_n(1.0 / sensors.len() as f64, sensors.len())
        .chain(std::iter::repeat_n(1.0 / coils.len() as f64, coils.len()))
        .collect();
    let common = result(&all, &weights, &solution.covariance, freedom);
    let (sensors, coils) = (relative(&sensors), relative(&coils));
    let verdict = verdict(&sensors, &coils, &common);
    ScalesResult { sensors, coils, common, verdict }
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
    axes.iter()
        .map(|&axis| {
            let (less_one, calibration_std) = scale(axis);
            Member {
                axis,
                logarithm: less_one.ln_1p(),
                gain: 1.0 / (1.0 + less_one),
                calibration_std: calibration_std.unwrap_or(0.0),
                place: place(axis),
            }
        })
        .collect()
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

fn verdict(sensors: &PerAxis<ScaleResult>, coils: &PerAxis<ScaleResult>, common: &ScaleResult) -> String {
    let named = |kind: &str, axis: Axis| format!("{kind} {axis}");
    let all = sensors
        .iter()
        .map(|(axis, scale)| (named("sensor", axis), scale))
        .chain(coils.iter().map(|(axis, scale)| (named("coil", axis), scale)))
        .chain(std::iter::once(("the common scale".to_string(), common)));
    let tested: Vec<(String, &ScaleResult)> = all.filter(|(_, scale)| scale.p_value.is_some()).collect();
    let count = tested.len() as f64;
    let far: Vec<String> = tested
        .iter()
        .filter(|(_, scale)| scale.p_value.is_some_and(|p| p * count < DISAGREES_P))
        .map(|(name, scale)| {
            format!(
                "{name} by {:+.0} ppm ({:+.1} sigma)",
                (scale.value - 1.0) * 1e6,
                scale.sigmas.unwrap_or(0.0)
            )
        })
        .collect();
    if far.is_empty() {
        "the readings agree with the sensitivities and coil constants of the calibration".into()
    } else {
        format!(
            "the readings disagree with the calibration's sensitivities and coil constants: {}",
            far.join(", ")
        )
    }
}

fn place(solution: &Solution, unknown: Unknown) -> Option<usize> {
    solution.meaning.iter().position(|meaning| *meaning == unknown)
}

fn sensor_constant(calibration: Option<&Calibration>, axis: Axis) -> Option<&common::Quantity> {
    let sensor = calibration?.sensors.as_ref()?.get(axis)?;
    sensor.sensitivity_nt_per_v.as_ref().or(sensor.sensitivity_nt_per_nt.as_ref())
}

fn coil_constant(calibration: Option<&Calibration>, axis: Axis) -> Option<&common::Quantity> {
    calibration?.coils.as_ref()?.get(axis)?.constant_nt_per_a.as_ref()
}
