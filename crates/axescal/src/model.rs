//! The problem that Gauss-Newton solves: readings as a function of directions and of what goes with them.

use common::Axis;
use estimate::Problem;
use faer::MatMut;
use nalgebra::{Matrix3, Vector3};
use physics::frames::{small_rotation, tangents, turned};
use physics::reading;

use crate::means::{self, Block};
use crate::unknowns::{KnownCoils, Unknown};
use crate::{AxesState, Freedom, NoiseFactors, Observation, Observations};

/// M = (1 + a_i) m_i · R(γ) (Σ_j (1 + c_j) B_j n_j + e) + o_i, residuals over their standard deviation and
/// free of what they have in common, followed by one row of prior knowledge for each unknown that has any.
pub struct AxesProblem<'a> {
    /// The readings.
    pub observations: &'a Observations,
    /// Factor on their standard deviations.
    pub noise: NoiseFactors,
    /// What each component of the step means.
    pub meaning: Vec<Unknown>,
    place: Places,
    /// The unknowns with prior knowledge, by their place, each with the inverse of its standard uncertainty.
    pub priors: Vec<(usize, f64)>,
    blocks: Vec<Block>,
    known_coils: Option<&'a KnownCoils>,
}

/// Where each kind of unknown begins in the step; None where it does not move.
#[derive(Default)]
struct Places {
    sensor: [Option<usize>; 3],
    coil: [Option<usize>; 3],
    sensor_scale: [Option<usize>; 3],
    coil_scale: [Option<usize>; 3],
    corrections: Option<usize>,
    residual_field: Option<usize>,
    offset: [Option<usize>; 3],
}

impl<'a> AxesProblem<'a> {
    /// The problem for readings with a given freedom.
    pub fn new(observations: &'a Observations, freedom: &'a Freedom, noise: NoiseFactors) -> Self {
        let mut unknowns = Vec::new();
        let mut priors = Vec::new();
        let mut add = |unknown: Unknown, prior: Option<f64>| {
            unknowns.push(unknown);
            let place = unknowns.len() - 1;
            priors.extend(prior.filter(|std| std.is_finite()).map(|std| (place, 1.0 / std)));
            place
        };
        let mut place = Places::default();
        for &axis in &observations.sensors {
            place.sensor[axis.index()] = Some(add(Unknown::Sensor(axis, 0), None));
            add(Unknown::Sensor(axis, 1), None);
        }
        let fixed = freedom.known_coils.as_ref().is_some_and(|known| known.whitening.is_none());
        for &axis in observations.coils.iter().filter(|_| !fixed) {
            place.coil[axis.index()] = Some(add(Unknown::Coil(axis, 0), None));
            add(Unknown::Coil(axis, 1), None);
        }
        for &axis in &observations.sensors {
            if let Some(std) = freedom.sensor_scale[axis.index()] {
                place.sensor_scale[axis.index()] = Some(add(Unknown::SensorScale(axis), Some(std)));
            }
        }
        for &axis in &observations.coils {
            if let Some(std) = freedom.coil_scale[axis.index()] {
                place.coil_scale[axis.index()] = Some(add(Unknown::CoilScale(axis), Some(std)));
            }
        }
        if freedom.orientations {
            for orientation in 0..observations.orientations.len() {
                for k in 0..3 {
                    let at = add(Unknown::Correction(orientation, k), Some(1.0));
                    place.corrections.get_or_insert(at);
                }
            }
        }
        for (k, std) in freedom.residual_field.iter().flatten().enumerate() {
            let at = add(Unknown::ResidualField(k), Some(*std));
            place.residual_field.get_or_insert(at);
        }
        for &axis in &observations.sensors {
            if let Some(std) = freedom.offsets[axis.index()] {
                place.offset[axis.index()] = Some(add(Unknown::Offset(axis), Some(std)));
            }
        }
        Self {
            observations,
            noise,
            meaning: unknowns,
            place,
            priors,
            blocks: means::blocks(observations),
            known_coils: freedom.known_coils.as_ref().filter(|_| !fixed),
        }
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

    /// Takes what the errors of readings have in common out of a column over them, each in units of its own
    /// standard deviation.
    pub(crate) fn whiten(&self, column: &mut [f64]) {
        means::whiten(&self.blocks, column);
    }

    /// Standard deviation of a reading, nT.
    pub(crate) fn std_nt(&self, reading: &Observation) -> f64 {
        reading.std_nt * self.noise.of(reading)
    }

    /// Standard deviation of a reading less what those before it say of it, nT.
    pub(crate) fn own_std_nt(&self, reading: usize) -> f64 {
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
        match self.place.corrections {
            None => given.rotation,
            Some(_) => small_rotation(&(given.uncertainty * state.corrections[orientation])) * given.rotation,
        }
    }

    /// The prediction of a reading, nT, and its derivatives by the unknowns, handed to `derivative` one by
    /// one.
    fn predict(
        &self,
        state: &AxesState,
        rotation: &Matrix3<f64>,
        observation: &Observation,
        mut derivative: impl FnMut(usize, f64),
    ) -> f64 {
        let i = observation.sensor.index();
        let m = state.mu.column(i).into_owned();
        let drive = observation.drive_nt.component_mul(&state.coil_scale.add_scalar(1.0));
        let left = if observation.constant { state.residual_field } else { Vector3::zeros() };
        let ambient = observation.ambient_nt + left;
        let at = reading(&m, rotation, &physics::field_geo(&state.eta, &drive, &ambient));
        let gain = 1.0 + state.sensor_scale[i];
        if let Some(place) = self.place.sensor[i] {
            for (k, tangent) in tangents(&m).iter().enumerate() {
                derivative(place + k, gain * at.by_sensor.dot(tangent));
            }
        }
        for j in 0..3 {
            if observation.drive_nt[j] == 0.0 {
                continue;
            }
            let n = state.eta.column(j).into_owned();
            if let Some(place) = self.place.coil[j] {
                for (k, tangent) in tangents(&n).iter().enumerate() {
                    derivative(place + k, gain * drive[j] * at.by_field.dot(tangent));
                }
            }
            if let Some(place) = self.place.coil_scale[j] {
                derivative(place, gain * observation.drive_nt[j] * at.by_field.dot(&n));
            }
        }
        if let Some(place) = self.place.sensor_scale[i] {
            derivative(place, at.value);
        }
        if let Some(first) = self.place.corrections {
            let uncertainty =
                &self.observations.orientations[observation.orientation].orientation.uncertainty;
            let by_unit = uncertainty.transpose() * at.by_rotation * gain;
            (0..3).for_each(|k| derivative(first + 3 * observation.orientation + k, by_unit[k]));
        }
        let mut value = gain * at.value;
        if observation.constant {
            if let Some(place) = self.place.residual_field {
                (0..3).for_each(|k| derivative(place + k, gain * at.by_field[k]));
            }
            if let Some(place) = self.place.offset[i] {
                derivative(place, 1.0);
            }
            value += state.offsets[i];
        }
        value
    }

    /// Observed less predicted for every reading, nT.
    pub fn residuals_nt(&self, state: &AxesState) -> Vec<f64> {
        let rotations = self.rotations(state);
        let difference = |observation: &Observation| {
            observation.value_nt
                - self.predict(state, &rotations[observation.orientation], observation, |_, _| {})
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
        (0..self.observations.orientations.len())
            .map(|orientation| self.rotation(state, orientation))
            .collect()
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
            let Some(place) = self.place.coil[axis.index()] else { continue };
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
            let predicted = self.predict(
                state,
                &rotations[observation.orientation],
                observation,
                |column, derivative| {
                    jacobian[(row, column)] = weight * derivative;
                },
            );
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
