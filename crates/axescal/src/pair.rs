//! One sensor with one coil, without the unit-length constraints (NASA eq. 38 to 52, program MAGCAL).

use common::PairComparison;
use estimate::{Options as Iteration, Problem};
use faer::MatMut;
use nalgebra::{Matrix3, Vector3};
use physics::frames::{ARCSEC, angle};
use physics::reading;

use crate::{AxesProblem, NoiseFactors, Observations, Result, Solution};

/// M/B = m · R n with all six components of m and n free. Lengths can be traded between m and n, so that the
/// rank is 5 at most; each step is the one of least norm.
struct Unconstrained<'a> {
    observations: &'a Observations,
    /// R of each orientation, corrected.
    rotations: Vec<Matrix3<f64>>,
    /// What the coil makes in each reading by the constrained fit, nT: less constants and offset.
    values_nt: Vec<f64>,
    noise: NoiseFactors,
}

impl Problem for Unconstrained<'_> {
    type State = (Vector3<f64>, Vector3<f64>);

    fn unknowns(&self) -> usize {
        6
    }

    fn rows(&self) -> usize {
        self.observations.readings.len()
    }

    fn linearise(&self, (m, n): &Self::State, residual: &mut [f64], mut jacobian: MatMut<'_, f64>) {
        for (row, observation) in self.observations.readings.iter().enumerate() {
            let rotation = &self.rotations[observation.orientation];
            let drive = observation.drive_nt[Observations::main_coil(observation).index()];
            let weight = 1.0 / (observation.std_nt * self.noise.of(observation));
            let at = reading(m, rotation, &(n * drive));
            residual[row] = weight * (self.values_nt[row] - at.value);
            for k in 0..3 {
                jacobian[(row, k)] = weight * at.by_sensor[k];
                jacobian[(row, 3 + k)] = weight * drive * at.by_field[k];
            }
        }
    }

    fn advance(&self, (m, n): &Self::State, step: &[f64]) -> Self::State {
        (m + Vector3::from_column_slice(&step[..3]), n + Vector3::from_column_slice(&step[3..]))
    }
}

/// The unconstrained solution beside the constrained one.
pub fn compare(observations: &Observations, solution: &Solution) -> Result<PairComparison> {
    let (sensor, coil) = (observations.sensors[0], observations.coils[0]);
    let constrained = AxesProblem::new(observations, &solution.freedom, solution.noise);
    let problem = Unconstrained {
        observations,
        rotations: (0..observations.orientations.len())
            .map(|orientation| constrained.rotation(&solution.fit.state, orientation))
            .collect(),
        values_nt: constrained.without_constants(&solution.fit.state),
        noise: solution.noise,
    };
    // From the frame's own axes, as the report begins: the least-norm path depends on the beginning.
    let sign = |value: f64| if value < 0.0 { -1.0 } else { 1.0 };
    let state = &solution.fit.state;
    let start = (
        Vector3::ith(sensor.index(), sign(state.mu[(sensor.index(), sensor.index())])),
        Vector3::ith(coil.index(), sign(state.eta[(coil.index(), coil.index())])),
    );
    let fit = estimate::solve(&problem, start, None, &Iteration::default())?;
    let (m, n) = fit.state;
    let direction = |matrix: &Matrix3<f64>, axis: common::Axis| matrix.column(axis.index()).into_owned();
    let count = observations.readings.len() as f64;
    Ok(PairComparison {
        sensor: sensor.to_string(),
        coil: coil.to_string(),
        unconstrained_sensor: m.into(),
        unconstrained_coil: n.into(),
        unconstrained_rank: fit.svd.rank(),
        incompatibility_rms_nt: (fit.cost / count).sqrt() * constrained.mean_std_nt(),
        sensor_difference_arcsec: angle(&m, &direction(&state.mu, sensor)) / ARCSEC,
        coil_difference_arcsec: angle(&n, &direction(&state.eta, coil)) / ARCSEC,
    })
}
