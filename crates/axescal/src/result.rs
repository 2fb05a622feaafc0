//! The solution as `calibration.axes`.

use common::{
    AxesCalibration, AxesFit, AxesReadings, Axis, Code, Document, DoubtfulReading, Findings, IterationStep,
    OrientationResult, PerAxis, Quantity,
};
use estimate::stats::rms;
use faer::Mat;
use nalgebra::Matrix3;
use physics::frames::ARCSEC;

use crate::doubts::Doubt;
use crate::unknowns::{Unknown, place};
use crate::{
    AxesProblem, Observation, Observations, Options, OrientationGroup, Result, Solution, assumptions, pair,
    scales,
};

/// More readings than this are summed up by orientation only.
const MOST_READINGS: usize = 20_000;

pub fn describe(
    document: &Document,
    observations: &Observations,
    solution: &Solution,
    options: &Options,
) -> Result<AxesCalibration> {
    let state = &solution.fit.state;
    let [sensor_turns, coil_turns] = solution.turns(observations);
    let covariance = |one: &Mat<f64>, other: &Mat<f64>| one * &solution.covariance * other.transpose();
    let stated = |axes: &[Axis], matrix: &Matrix3<f64>, turns: &Mat<f64>| {
        physics::directions(axes, matrix, &covariance(turns, turns))
    };
    let mut findings = Findings::default();
    findings.extend(observations.findings.iter().cloned());
    findings.extend(solution.findings.iter().cloned());
    let (residual_field_nt, offsets_nt) = constants(solution, observations, &mut findings);
    let calibration = document.calibration.as_ref();
    let pair = (observations.sensors.len() == 1 && observations.coils.len() == 1)
        .then(|| pair::compare(observations, solution))
        .transpose()?;
    Ok(AxesCalibration {
        sensors: Some(stated(&observations.sensors, &state.mu, &sensor_turns)),
        coils: Some(stated(&observations.coils, &state.eta, &coil_turns)),
        cross_covariance: Some(common::covariance::rows(&covariance(&sensor_turns, &coil_turns))),
        residual_field_nt,
        offsets_nt,
        scales: options.free_scales.then(|| scales::describe(calibration, observations, solution)),
        pair,
        orientations: orientations(observations, solution),
        phases: observations.phases.clone(),
        fit: Some(fit(observations, solution, options)),
        assumptions: assumptions::list(document, observations, solution),
        doubtful: doubtful(document, observations, solution),
        findings,
        readings: (observations.readings.len() <= MOST_READINGS)
            .then(|| readings(document, observations, solution)),
        ..AxesCalibration::default()
    })
}

type Constants = (Option<PerAxis<Quantity>>, Option<PerAxis<Quantity>>);

/// Residual field and offsets, as far as the recordings separate them.
fn constants(solution: &Solution, observations: &Observations, findings: &mut Findings) -> Constants {
    let shown = |axis: &Axis| crate::freedom::separates_constants(observations, *axis);
    if !observations.sensors.iter().any(shown) {
        return (None, None);
    }
    let constant = |meaning: &Unknown| matches!(meaning, Unknown::ResidualField(_) | Unknown::Offset(_));
    let places: Vec<usize> =
        (0..solution.meaning.len()).filter(|k| constant(&solution.meaning[*k])).collect();
    let unseen = solution.fit.svd.unseen(&places);
    let mut mixed = Vec::new();
    let mut quantity = |value: f64, unknown: Unknown, name: String| -> Option<Quantity> {
        let place = place(&solution.meaning, unknown)?;
        if unseen.iter().any(|direction| direction[place].abs() > 1e-3) {
            mixed.push(name);
            return None;
        }
        Some(Quantity::new(value, solution.covariance[(place, place)].sqrt()))
    };
    let state = &solution.fit.state;
    let mut field = PerAxis::default();
    for axis in Axis::ALL {
        let (k, name) = (axis.index(), format!("{axis} of the residual field"));
        *field.entry(axis) = quantity(state.residual_field[k], Unknown::ResidualField(k), name);
    }
    let mut offsets = PerAxis::default();
    for &axis in observations.sensors.iter().filter(|axis| shown(axis)) {
        let (offset, name) = (-state.offsets[axis.index()], format!("the offset of sensor {axis}"));
        *offsets.entry(axis) = quantity(offset, Unknown::Offset(axis), name);
    }
    if !mixed.is_empty() {
        findings.push(Code::NotDetermined.said(format!(
            "{} cannot be separated by zero drives in these orientations; record zero drives with the block turned over (180°)",
            mixed.join(", ")
        )));
    }
    let some = |all: PerAxis<Quantity>| Some(all).filter(|all| all.iter().next().is_some());
    (some(field), some(offsets))
}

fn orientations(observations: &Observations, solution: &Solution) -> Vec<OrientationResult> {
    let one = |(number, group): (usize, &OrientationGroup)| {
        let all = observations.readings.iter().zip(&solution.residuals_nt);
        let own = all.filter(|(reading, _)| reading.orientation == number);
        let residuals: Vec<f64> = own.map(|(_, residual)| *residual).collect();
        let correction = place(&solution.meaning, Unknown::Correction(number, 0)).map(|place| {
            let uncertainty = &group.orientation.uncertainty;
            let turn = uncertainty * solution.fit.state.corrections[number] / ARCSEC;
            let block = Matrix3::from_fn(|i, j| solution.covariance[(place + i, place + j)]);
            let covariance = uncertainty * block * uncertainty.transpose();
            let std = |k: usize| covariance[(k, k)].max(0.0).sqrt() / ARCSEC;
            let of = |axis: Axis| (axis, Quantity::new(turn[axis.index()], std(axis.index())));
            Axis::ALL.into_iter().map(of).collect()
        });
        OrientationResult {
            recordings: group.recordings.clone(),
            readings: residuals.len(),
            rms_nt: rms(&residuals),
            correction_arcsec: correction,
            orthogonalised_by_arcsec: group.orientation.moved_rad / ARCSEC,
        }
    };
    observations.orientations.iter().enumerate().map(one).collect()
}

fn fit(observations: &Observations, solution: &Solution, options: &Options) -> AxesFit {
    let count = observations.readings.len();
    let turn = |step: &[f64]| {
        let turns = step.iter().zip(&solution.meaning).filter(|(_, meaning)| meaning.is_turn());
        turns.map(|(step, _)| step.abs()).fold(0.0, f64::max) / ARCSEC
    };
    let mean_square = |of: &dyn Fn(&Observation) -> f64| {
        observations.readings.iter().map(|reading| of(reading).powi(2)).sum::<f64>() / count as f64
    };
    let declared = mean_square(&|reading| reading.std_nt);
    let iteration = |step: &estimate::Step| IterationStep {
        rms_nt: (step.cost / count as f64).sqrt() * declared.sqrt(),
        turn_arcsec: turn(&step.step),
        rank: step.rank,
    };
    AxesFit {
        method: if options.known_coils { "coils known" } else { "coils unknown" }.into(),
        readings: count,
        unknowns: solution.meaning.len(),
        rank: solution.fit.svd.rank(),
        singular_values: solution.fit.svd.sigma().to_vec(),
        degrees_of_freedom: solution.degrees_of_freedom,
        rms_nt: rms(&solution.residuals_nt),
        noise_nt: mean_square(&|reading| reading.std_nt * solution.noise.of(reading)).sqrt(),
        noise_source: solution.noise_source.clone(),
        chi_squared: solution.chi_squared.map(|(chi_squared, _)| chi_squared),
        chi_squared_p: solution.chi_squared.map(|(_, p)| p),
        coverage_factor_95: solution.coverage_factor,
        iterations: solution.steps.iter().map(iteration).collect(),
    }
}

fn doubtful(document: &Document, observations: &Observations, solution: &Solution) -> Vec<DoubtfulReading> {
    let told = |doubt: &Doubt| {
        let reading = &observations.readings[doubt.reading];
        DoubtfulReading {
            recording: document.recordings[reading.recording].id.clone(),
            orientation: reading.orientation + 1,
            row: reading.row,
            coil: Observations::main_coil(reading),
            sensor: reading.sensor,
            leave_one_out_nt: doubt.leave_one_out_nt,
            t: doubt.t,
            p_adjusted: doubt.p_adjusted,
        }
    };
    solution.doubtful.iter().map(told).collect()
}

fn readings(document: &Document, observations: &Observations, solution: &Solution) -> AxesReadings {
    let mut columns = AxesReadings { weight: solution.weights.clone(), ..AxesReadings::default() };
    let problem = AxesProblem::new(observations, &solution.freedom, solution.noise);
    for (number, ((reading, influence), residual)) in
        observations.readings.iter().zip(&solution.influence).zip(&solution.residuals_nt).enumerate()
    {
        columns.orientation.push(reading.orientation + 1);
        columns.recording.push(document.recordings[reading.recording].id.clone());
        columns.row.push(reading.row);
        columns.coil.push(Observations::main_coil(reading));
        columns.sensor.push(reading.sensor);
        columns.residual_nt.push(*residual);
        columns.leverage.push(influence.leverage);
        columns.leave_one_out_nt.push(influence.leave_one_out * problem.own_std_nt(number));
        columns.t.push(influence.t);
    }
    columns
}
