//! The problem that Gauss-Newton solves: readings as a function of directions and of what goes with them.

use common::Axis;
use estimate::Problem;
use faer::MatMut;
use nalgebra::{Matrix3, Vector3};
use physics::frames::{small_rotation, tangents, turned};
use physics::reading;

use crate::means::{self, Block};
use crate::unknowns::{KnownCoils, Unknown, place};
use crate::{AxesState, Freedom, NoiseFactors, Observation, Observations};

/// M = (1 + a_i) m_i · R(γ) (Σ_j (1 + c_j) B_j n_j + e) + o_i, residuals over their standard deviation and
/// free of what they have in common, followed by one row of prior knowledge for each unknown that has any.
pub struct AxesProblem<'a> {
    pub observations: &'a Observations,
    pub noise: NoiseFactors,
    pub meaning: Vec<Unknown>,
    /// The unknowns with prior knowledge, by their place, each with the inverse of its standard uncertainty.
    pub priors: Vec<(usize, f64)>,
    blocks: Vec<Block>,
    known_coils: Option<&'a KnownCoils>,
}

impl<'a> AxesProblem<'a> {
    pub fn new(observations: &'a Observations, freedom: &'a Freedom, noise: NoiseFactors) -> Self {
        // With the standard uncertainty of what is known beforehand; the directions have none.
        let mut unknowns: Vec<(Unknown, f64)> = Vec::new();
        let turns = |axes: &[Axis], unknown: fn(Axis, usize) -> Unknown| -> Vec<(Unknown, f64)> {
            axes.iter().flat_map(|axis| [0, 1].map(|k| (unknown(*axis, k), f64::INFINITY))).collect()
        };
        let constants = |axes: &[Axis], unknown: fn(Axis) -> Unknown, stds: [Option<f64>; 3]| {
            let one = |axis: &Axis| Some((unknown(*axis), stds[axis.index()]?));
            axes.iter().filter_map(one).collect::<Vec<(Unknown, f64)>>()
        };
        let Observations { sensors, coils, orientations, .. } = observations;
        let fixed = freedom.known_coils.as_ref().is_some_and(|known| known.whitening.is_none());
        unknowns.extend(turns(sensors, Unknown::Sensor));
        unknowns.extend(turns(if fixed { &[] } else { coils }, Unknown::Coil));
        unknowns.extend(constants(sensors, Unknown::SensorScale, freedom.sensor_scale));
        unknowns.extend(constants(coils, Unknown::CoilScale, freedom.coil_scale));
        let turning = if freedom.orientations { orientations.len() } else { 0 };
        for orientation in 0..turning {
            unknowns.extend([0, 1, 2].map(|k| (Unknown::Correction(orientation, k), 1.0)));
        }
        let field = freedom.residual_field.iter().flatten().enumerate();
        unknowns.extend(field.map(|(k, std)| (Unknown::ResidualField(k), *std)));
        unknowns.extend(constants(sensors, Unknown::Offset, freedom.offsets));
        let known = unknowns.iter().enumerate().filter(|(_, (_, std))| std.is_finite());
        Self {
            observations,
            noise,
            priors: known.map(|(place, (_, std))| (place, 1.0 / std)).collect(),
            meaning: unknowns.into_iter().map(|(unknown, _)| unknown).collect(),
            blocks: means::blocks(observations),
            known_coils: freedom.known_coils.as_ref().filter(|_| !fixed),
        }
    }

    /// Where an unknown stands in the step; None where it does not move.
    fn place(&self, unknown: Unknown) -> Option<usize> {
        place(&self.meaning, unknown)
    }

    /// The rows of prior knowledge, each with its unknown.
    pub fn prior_rows(&self) -> impl Iterator<Item = (usize, Unknown)> {
        let first = self.observations.readings.len();
        self.priors.iter().enumerate().map(move |(row, (place, _))| (first + row, self.meaning[*place]))
    }

    /// The rows that hold known coils to their directions.
    pub fn known_coil_row_numbers(&self) -> std::ops::Range<usize> {
        self.observations.readings.len() + self.priors.len()..self.rows()
    }

    /// Takes what the errors of readings have in common out of a column in units of their deviations.
    pub fn whiten(&self, column: &mut [f64]) {
        means::whiten(&self.blocks, column);
    }

    /// Standard deviation of a reading, nT.
    fn std_nt(&self, reading: &Observation) -> f64 {
        reading.std_nt * self.noise.of(reading)
    }

    pub fn mean_std_nt(&self) -> f64 {
        let readings = &self.observations.readings;
        readings.iter().map(|reading| self.std_nt(reading)).sum::<f64>() / readings.len() as f64
    }

    /// Standard deviation of a reading less what those before it say of it, nT.
    pub fn own_std_nt(&self, reading: usize) -> f64 {
        let own = |block: &Block| {
            let row = reading.checked_sub(block.first).filter(|row| *row < block.root.nrows())?;
            Some(block.root[(row, row)])
        };
        let share = self.blocks.iter().find_map(own).unwrap_or(1.0);
        share * self.std_nt(&self.observations.readings[reading])
    }

    /// R of an orientation with its correction.
    pub fn rotation(&self, state: &AxesState, orientation: usize) -> Matrix3<f64> {
        let given = &self.observations.orientations[orientation].orientation;
        match self.place(Unknown::Correction(orientation, 0)) {
            None => given.rotation,
            Some(_) => small_rotation(&(given.uncertainty * state.corrections[orientation])) * given.rotation,
        }
    }

    /// The prediction of a reading, nT, and its derivatives, each given to `derivative`.
    fn predict(
        &self,
        state: &AxesState,
        rotation: &Matrix3<f64>,
        observation: &Observation,
        mut derivative: impl FnMut(usize, f64),
    ) -> f64 {
        let sensor = observation.sensor;
        let i = sensor.index();
        let m = state.mu.column(i).into_owned();
        let drive = observation.drive_nt.component_mul(&state.coil_scale.add_scalar(1.0));
        let left = if observation.constant { state.residual_field } else { Vector3::zeros() };
        let ambient = observation.ambient_nt + left;
        let at = reading(&m, rotation, &physics::field_geo(&state.eta, &drive, &ambient));
        let gain = 1.0 + state.sensor_scale[i];
        if let Some(place) = self.place(Unknown::Sensor(sensor, 0)) {
            for (k, tangent) in tangents(&m).iter().enumerate() {
                derivative(place + k, gain * at.by_sensor.dot(tangent));
            }
        }
        for coil in Axis::ALL {
            let j = coil.index();
            if observation.drive_nt[j] == 0.0 {
                continue;
            }
            let n = state.eta.column(j).into_owned();
            if let Some(place) = self.place(Unknown::Coil(coil, 0)) {
                for (k, tangent) in tangents(&n).iter().enumerate() {
                    derivative(place + k, gain * drive[j] * at.by_field.dot(tangent));
                }
            }
            if let Some(place) = self.place(Unknown::CoilScale(coil)) {
                derivative(place, gain * observation.drive_nt[j] * at.by_field.dot(&n));
            }
        }
        if let Some(place) = self.place(Unknown::SensorScale(sensor)) {
            derivative(place, at.value);
        }
        if let Some(place) = self.place(Unknown::Correction(observation.orientation, 0)) {
            let uncertainty =
                &self.observations.orientations[observation.orientation].orientation.uncertainty;
            let by_unit = uncertainty.transpose() * at.by_rotation * gain;
            (0..3).for_each(|k| derivative(place + k, by_unit[k]));
        }
        let mut value = gain * at.value;
        if observation.constant {
            if let Some(place) = self.place(Unknown::ResidualField(0)) {
                (0..3).for_each(|k| derivative(place + k, gain * at.by_field[k]));
            }
            if let Some(place) = self.place(Unknown::Offset(sensor)) {
                derivative(place, 1.0);
            }
            value += state.offsets[i];
        }
        value
    }

    /// Observed less predicted for every reading, nT.
    pub fn residuals_nt(&self, state: &AxesState) -> Vec<f64> {
        let rotations = self.rotations(state);
        let difference = |one: &Observation| {
            one.value_nt - self.predict(state, &rotations[one.orientation], one, |_, _| {})
        };
        self.observations.readings.iter().map(difference).collect()
    }

    /// Every reading less what constant fields and offsets make in it, and freed of its scale, nT.
    pub fn without_constants(&self, state: &AxesState) -> Vec<f64> {
        let rotations = self.rotations(state);
        let freed = |observation: &Observation| {
            let undriven = Observation { drive_nt: Vector3::zeros(), ..observation.clone() };
            let constant = self.predict(state, &rotations[observation.orientation], &undriven, |_, _| {});
            let (sensor, coil) = (observation.sensor.index(), observation.drive_nt.iamax());
            (observation.value_nt - constant)
                / ((1.0 + state.sensor_scale[sensor]) * (1.0 + state.coil_scale[coil]))
        };
        self.observations.readings.iter().map(freed).collect()
    }

    fn rotations(&self, state: &AxesState) -> Vec<Matrix3<f64>> {
        (0..self.observations.orientations.len()).map(|number| self.rotation(state, number)).collect()
    }

    /// The value of an unknown that has a prior of mean zero.
    fn value(&self, state: &AxesState, place: usize) -> f64 {
        match self.meaning[place] {
            Unknown::SensorScale(axis) => state.sensor_scale[axis.index()],
            Unknown::CoilScale(axis) => state.coil_scale[axis.index()],
            Unknown::Correction(orientation, k) => state.corrections[orientation][k],
            Unknown::ResidualField(k) => state.residual_field[k],
            Unknown::Offset(axis) => state.offsets[axis.index()],
            Unknown::Sensor(..) | Unknown::Coil(..) => 0.0,
        }
    }

    /// Rows that hold the coils to their given directions: W times the turns from them.
    fn known_coil_rows(
        &self,
        state: &AxesState,
        first: usize,
        residual: &mut [f64],
        jacobian: &mut MatMut<'_, f64>,
    ) {
        let Some(KnownCoils { directions, whitening: Some(whitening) }) = self.known_coils else { return };
        for (n, &axis) in self.observations.coils.iter().enumerate() {
            let (given, now) = (directions[axis.index()], state.eta.column(axis.index()).into_owned());
            let Some(place) = self.place(Unknown::Coil(axis, 0)) else { continue };
            for (k, tangent) in tangents(&given).iter().enumerate() {
                for row in 0..whitening.nrows() {
                    let weight = whitening[(row, 2 * n + k)];
                    residual[first + row] -= weight * tangent.dot(&now);
                    for (l, moving) in tangents(&now).iter().enumerate() {
                        jacobian[(first + row, place + l)] += weight * tangent.dot(moving);
                    }
                }
            }
        }
    }
}

impl Problem for AxesProblem<'_> {
    type State = AxesState;

    fn unknowns(&self) -> usize {
        self.meaning.len()
    }

    fn rows(&self) -> usize {
        let known = self.known_coils.map_or(0, |_| 2 * self.observations.coils.len());
        self.readings() + self.priors.len() + known
    }

    fn readings(&self) -> usize {
        self.observations.readings.len()
    }

    fn linearise(&self, state: &AxesState, residual: &mut [f64], mut jacobian: MatMut<'_, f64>) {
        let rotations = self.rotations(state);
        for (row, observation) in self.observations.readings.iter().enumerate() {
            let weight = 1.0 / (self.std_nt(observation));
            let rotation = &rotations[observation.orientation];
            let derivative = |column, derivative| jacobian[(row, column)] = weight * derivative;
            let predicted = self.predict(state, rotation, observation, derivative);
            residual[row] = weight * (observation.value_nt - predicted);
        }
        self.whiten(residual);
        for column in (0..self.meaning.len()).filter(|_| !self.blocks.is_empty()) {
            let mut values: Vec<f64> = (0..self.readings()).map(|row| jacobian[(row, column)]).collect();
            self.whiten(&mut values);
            values.into_iter().enumerate().for_each(|(row, value)| jacobian[(row, column)] = value);
        }
        let first = self.readings();
        for (row, (place, weight)) in self.priors.iter().enumerate() {
            residual[first + row] = -weight * self.value(state, *place);
            jacobian[(first + row, *place)] = *weight;
        }
        self.known_coil_rows(state, first + self.priors.len(), residual, &mut jacobian);
    }

    fn advance(&self, state: &AxesState, step: &[f64]) -> AxesState {
        let mut next = state.clone();
        for (place, unknown) in self.meaning.iter().enumerate() {
            match *unknown {
                Unknown::Sensor(axis, 0) => turn(&mut next.mu, axis, &step[place..place + 2]),
                Unknown::Coil(axis, 0) => turn(&mut next.eta, axis, &step[place..place + 2]),
                Unknown::Sensor(..) | Unknown::Coil(..) => {}
                Unknown::SensorScale(axis) => next.sensor_scale[axis.index()] += step[place],
                Unknown::CoilScale(axis) => next.coil_scale[axis.index()] += step[place],
                Unknown::Correction(orientation, k) => next.corrections[orientation][k] += step[place],
                Unknown::ResidualField(k) => next.residual_field[k] += step[place],
                Unknown::Offset(axis) => next.offsets[axis.index()] += step[place],
            }
        }
        next
    }
}

fn turn(matrix: &mut Matrix3<f64>, axis: Axis, step: &[f64]) {
    let direction = matrix.column(axis.index()).into_owned();
    matrix.set_column(axis.index(), &turned(&direction, [step[0], step[1]]));
}
