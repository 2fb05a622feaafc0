//! The solution as `calibration.axes`.

use common::{
    AxesCalibration, AxesDirections, AxesFit, AxesReadings, Axis, Document, DoubtfulReading, IterationStep,
    OneOrEach, OrientationResult, PerAxis, Quantity,
};
use faer::Mat;
use indexmap::IndexMap;
use nalgebra::{Matrix2, Matrix3, Vector3};
use physics::frames::{self, ARCSEC, angle, tangents};

use crate::model::Unknown;
use crate::{Error, Observations, Options, Solution, assumptions, pair, scales};

/// More readings than this are summed up by orientation only.
const MOST_READINGS: usize = 20_000;

/// Everything that is written to the document.
pub fn describe(
    document: &Document,
    observations: &Observations,
    solution: &Solution,
    options: &Options,
) -> Result<AxesCalibration, Error> {
    let state = &solution.fit.state;
    let sensor_turns = turns(solution, &observations.sensors, |axis| Unknown::Sensor(axis, 0), &state.mu);
    let coil_turns = turns(solution, &observations.coils, |axis| Unknown::Coil(axis, 0), &state.eta);
    let nominal = Matrix3::identity();
    let mut findings = observations.findings.clone();
    findings.extend(solution.findings.iter().cloned());
    let constants = constants(solution, observations, &mut findings);
    let calibration = document.calibration.as_ref();
    let pair = (observations.sensors.len() == 1 && observations.coils.len() == 1)
        .then(|| pair::compare(observations, solution))
        .transpose()?;
    Ok(AxesCalibration {
        sensors: Some(directions(
            &observations.sensors,
            &state.mu,
            &nominal,
            &sensor_turns,
            &solution.covariance,
        )),
        coils: Some(directions(&observations.coils, &state.eta, &nominal, &coil_turns, &solution.covariance)),
        cross_covariance: Some(rows(&(&sensor_turns * &solution.covariance * coil_turns.transpose()))),
        residual_field_nt: constants.0,
        offsets_nt: constants.1,
        scales: options.free_scales.then(|| scales::describe(calibration, observations, solution)),
        pair,
        orientations: orientations(observations, solution),
        phases: observations.phases.clone(),
        fit: Some(fit(observations, solution, options)),
        assumptions: assumptions::list(observations, solution)?,
        doubtful: doubtful(document, observations, solution),
        findings,
        readings: (observations.readings.len() <= MOST_READINGS)
            .then(|| readings(document, observations, solution)),
        extra: Default::default(),
    })
}

/// The 9×n matrix from the unknowns to the elements of a matrix of directions, column by column.
fn turns(
    solution: &Solution,
    axes: &[Axis],
    first: impl Fn(Axis) -> Unknown,
    matrix: &Matrix3<f64>,
) -> Mat<f64> {
    let mut map = Mat::zeros(9, solution.meaning.len());
    for &axis in axes {
        let Some(place) = solution.meaning.iter().position(|meaning| *meaning == first(axis)) else {
            continue;
        };
        for (k, tangent) in tangents(&matrix.column(axis.index()).into_owned()).iter().enumerate() {
            (0..3).for_each(|row| map[(3 * axis.index() + row, place + k)] = tangent[row]);
        }
    }
    map
}

fn directions(
    axes: &[Axis],
    matrix: &Matrix3<f64>,
    nominal: &Matrix3<f64>,
    map: &Mat<f64>,
    covariance: &Mat<f64>,
) -> AxesDirections {
    let covariance = map * covariance * map.transpose();
    let column = |axis: Axis| matrix.column(axis.index()).into_owned();
    // Standard uncertainty of a linear function of the nine elements.
    let std = |weights: &[(Axis, Vector3<f64>)]| -> f64 {
        let mut variance = 0.0;
        for (a, left) in weights {
            for (b, right) in weights {
                for row in 0..3 {
                    for other in 0..3 {
                        variance += left[row]
                            * covariance[(3 * a.index() + row, 3 * b.index() + other)]
                            * right[other];
                    }
                }
            }
        }
        variance.max(0.0).sqrt()
    };
    let largest = |axis: Axis| -> f64 {
        let [a, b] = tangents(&column(axis));
        let block = |left: &Vector3<f64>, right: &Vector3<f64>| -> f64 {
            let first = 3 * axis.index();
            (0..9).map(|k| left[k / 3] * covariance[(first + k / 3, first + k % 3)] * right[k % 3]).sum()
        };
        let ellipse = Matrix2::new(block(&a, &a), block(&a, &b), block(&b, &a), block(&b, &b));
        ellipse.symmetric_eigenvalues().max().max(0.0).sqrt()
    };
    let mut non_orthogonality = IndexMap::new();
    for (first, second) in [(Axis::X, Axis::Y), (Axis::Y, Axis::Z), (Axis::X, Axis::Z)] {
        if axes.contains(&first) && axes.contains(&second) {
            let (a, b) = (column(first), column(second));
            let sine = a.dot(&b).clamp(-1.0, 1.0);
            let std = std(&[(first, b), (second, a)]) / (1.0 - sine * sine).max(1e-12).sqrt();
            non_orthogonality
                .insert(format!("{first}{second}"), Quantity::new(sine.asin() / ARCSEC, std / ARCSEC));
        }
    }
    let off_nominal = axes.iter().map(|&axis| {
        let (own, meant) = (column(axis), nominal.column(axis.index()).into_owned());
        let towards = own * own.dot(&meant) - meant;
        let std = if towards.norm() > 1e-9 { std(&[(axis, towards.normalize())]) } else { largest(axis) };
        (axis, Quantity::new(angle(&own, &meant) / ARCSEC, std / ARCSEC))
    });
    let complete = axes.len() == 3;
    let known = axes.iter().map(|&axis| (axis, column(axis).into())).collect();
    AxesDirections {
        matrix: complete.then(|| frames::rows(matrix)),
        directions: (!complete).then_some(known),
        std_arcsec: Some(OneOrEach::Each(axes.iter().map(|&axis| (axis, largest(axis) / ARCSEC)).collect())),
        off_nominal_arcsec: Some(off_nominal.collect()),
        non_orthogonality_arcsec: (!non_orthogonality.is_empty()).then_some(non_orthogonality),
        covariance: Some(rows(&covariance)),
        covariance_order: Some((0..9).map(|k| format!("matrix[{}][{}]", k % 3, k / 3)).collect()),
        extra: Default::default(),
    }
}

fn rows(matrix: &Mat<f64>) -> Vec<Vec<f64>> {
    (0..matrix.nrows()).map(|i| (0..matrix.ncols()).map(|j| matrix[(i, j)]).collect()).collect()
}

type Constants = (Option<PerAxis<Quantity>>, Option<PerAxis<Quantity>>);

/// Residual field and offsets, as far as the recordings separate them.
fn constants(solution: &Solution, observations: &Observations, findings: &mut Vec<String>) -> Constants {
    if !crate::solve::separates_constants(observations) {
        return (None, None);
    }
    let null = beside_the_gauge(solution);
    let mut mixed = Vec::new();
    let mut quantity = |value: f64, unknown: Unknown, name: String| -> Option<Quantity> {
        let place = solution.meaning.iter().position(|meaning| *meaning == unknown)?;
        if null.iter().any(|direction| direction[place].abs() > 1e-3) {
            mixed.push(name);
            return None;
        }
        Some(Quantity::new(value, solution.covariance[(place, place)].sqrt()))
    };
    let state = &solution.fit.state;
    let mut field = PerAxis::default();
    for axis in Axis::ALL {
        let k = axis.index();
        *field.entry(axis) = quantity(
            state.residual_field[k],
            Unknown::ResidualField(k),
            format!("{axis} of the residual field"),
        );
    }
    let mut offsets = PerAxis::default();
    for &axis in &observations.sensors {
        *offsets.entry(axis) = quantity(
            -state.offsets[axis.index()],
            Unknown::Offset(axis),
            format!("the offset of sensor {axis}"),
        );
    }
    if !mixed.is_empty() {
        findings.push(format!(
            "{} cannot be told apart from zero drives in these orientations; turn the block over (180°) with no drive",
            mixed.join(", ")
        ));
    }
    let some = |all: PerAxis<Quantity>| {
        let any = all.iter().next().is_some();
        any.then_some(all)
    };
    (some(field), some(offsets))
}

/// The null directions without the trade of scales between sensors and coils (μ → s μ, η → η/s), which is
/// always there when scales are free and moves the residual field along with the coils.
fn beside_the_gauge(solution: &Solution) -> Vec<Vec<f64>> {
    let state = &solution.fit.state;
    let mut gauge: Vec<f64> = solution
        .meaning
        .iter()
        .map(|meaning| match *meaning {
            Unknown::SensorScale(axis) => 1.0 + state.sensor_scale[axis.index()],
            Unknown::CoilScale(axis) => -1.0 - state.coil_scale[axis.index()],
            Unknown::ResidualField(k) => -state.residual_field[k],
            _ => 0.0,
        })
        .collect();
    let norm = gauge.iter().map(|g| g * g).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    gauge.iter_mut().for_each(|g| *g /= norm);
    let mut null = solution.fit.svd.null_directions();
    for direction in &mut null {
        let along: f64 = direction.iter().zip(&gauge).map(|(d, g)| d * g).sum();
        direction.iter_mut().zip(&gauge).for_each(|(d, g)| *d -= along * g);
    }
    null
}

fn orientations(observations: &Observations, solution: &Solution) -> Vec<OrientationResult> {
    observations
        .orientations
        .iter()
        .enumerate()
        .map(|(number, group)| {
            let residuals: Vec<f64> = observations
                .readings
                .iter()
                .zip(&solution.residuals_nt)
                .filter(|(reading, _)| reading.orientation == number)
                .map(|(_, residual)| *residual)
                .collect();
            let place =
                solution.meaning.iter().position(|meaning| *meaning == Unknown::Correction(number, 0));
            let correction = place.map(|place| {
                let uncertainty = &group.orientation.uncertainty;
                let turn = uncertainty * solution.fit.state.corrections[number] / ARCSEC;
                let block = Matrix3::from_fn(|i, j| solution.covariance[(place + i, place + j)]);
                let covariance = uncertainty * block * uncertainty.transpose();
                Axis::ALL
                    .into_iter()
                    .map(|axis| {
                        let k = axis.index();
                        (axis, Quantity::new(turn[k], covariance[(k, k)].max(0.0).sqrt() / ARCSEC))
                    })
                    .collect()
            });
            OrientationResult {
                recordings: group.recordings.clone(),
                readings: residuals.len(),
                rms_nt: rms(&residuals),
                correction_arcsec: correction,
                orthogonalised_by_arcsec: group.orientation.moved_rad / ARCSEC,
            }
        })
        .collect()
}

fn fit(observations: &Observations, solution: &Solution, options: &Options) -> AxesFit {
    let count = observations.readings.len();
    let turn = |step: &[f64]| {
        let turns = step.iter().zip(&solution.meaning).filter(|(_, meaning)| meaning.is_turn());
        turns.map(|(step, _)| step.abs()).fold(0.0, f64::max) / ARCSEC
    };
    let noise = observations.readings.iter().map(|r| r.std_nt * r.std_nt).sum::<f64>() / count as f64;
    AxesFit {
        method: match options.coils {
            crate::Coils::Unknown => "coils unknown".into(),
            crate::Coils::Known => "coils known".into(),
        },
        readings: count,
        unknowns: solution.meaning.len(),
        rank: solution.fit.svd.rank(),
        singular_values: solution.fit.svd.sigma().to_vec(),
        degrees_of_freedom: solution.degrees_of_freedom,
        rms_nt: rms(&solution.residuals_nt),
        noise_nt: noise.sqrt() * solution.noise_factor,
        noise_source: solution.noise_source.clone(),
        chi_squared: solution.chi_squared.map(|(chi_squared, _)| chi_squared),
        chi_squared_p: solution.chi_squared.map(|(_, p)| p),
        coverage_factor_95: solution.coverage_factor,
        iterations: solution
            .steps
            .iter()
            .map(|step| IterationStep {
                rms_nt: (step.cost / count as f64).sqrt() * noise.sqrt(),
                turn_arcsec: turn(&step.step),
                rank: step.rank,
            })
            .collect(),
    }
}

fn doubtful(document: &Document, observations: &Observations, solution: &Solution) -> Vec<DoubtfulReading> {
    solution
        .doubtful
        .iter()
        .map(|doubt| {
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
        })
        .collect()
}

fn readings(document: &Document, observations: &Observations, solution: &Solution) -> AxesReadings {
    let mut columns = AxesReadings { weight: solution.weights.clone(), ..AxesReadings::default() };
    for ((reading, influence), residual) in
        observations.readings.iter().zip(&solution.influence).zip(&solution.residuals_nt)
    {
        columns.orientation.push(reading.orientation + 1);
        columns.recording.push(document.recordings[reading.recording].id.clone());
        columns.row.push(reading.row);
        columns.coil.push(Observations::main_coil(reading));
        columns.sensor.push(reading.sensor);
        columns.residual_nt.push(*residual);
        columns.leverage.push(influence.leverage);
        columns.leave_one_out_nt.push(influence.leave_one_out * reading.std_nt * solution.noise_factor);
        columns.t.push(influence.t);
    }
    columns
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
