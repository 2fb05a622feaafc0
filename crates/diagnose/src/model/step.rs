//! Steps over the constants of the sensors along which readings move in a straight line.
//!
//! A sensor reads (μ·B − O)/k = m·B − o, which is linear in m = μ/k and o = O/k, but not in sensitivity,
//! turns and offset. Where a field hardly changes, m and o trade with each other over long distances, and
//! steps over k, O and turns would leave the valley. So a step is taken over m and o, and k, O and the turns
//! are those of where it ends.

use common::Axis;
use nalgebra::{Matrix3, Vector3};
use physics::{Basic, Parameter, ParameterInfo, Role, Unit, frames};

use super::state::{Model, State};
use super::unknown::Unknown;

/// A time constant or a level goes no farther beyond its plausible range than by this factor.
const FARTHEST: f64 = 10.0;
/// A step that turns a sensor by more than this is left as it is, rad.
const FARTHEST_TURN: f64 = 0.5;

/// Between which values a shape moves.
fn bounds(info: &ParameterInfo) -> [f64; 2] {
    [info.low / FARTHEST, info.high * FARTHEST]
}

/// Whether a shape has come to one of its bounds, where it stays.
pub fn at_bound(info: &ParameterInfo, value: f64) -> bool {
    let [low, high] = bounds(info);
    value <= low || value >= high
}

impl Model<'_> {
    /// A state moved along a step over the unknowns.
    pub fn advance(&self, state: &State, step: &[f64]) -> State {
        let mut next = state.clone();
        let base = self.unknowns.len();
        next.base.iter_mut().zip(step).for_each(|(value, s)| *value += s);
        self.straighten(state, &mut next);
        let free = self.free(state);
        for ((effect, parameter), s) in free.iter().zip(&step[base..]) {
            let info = &next.effects[*effect].kind.parameters()[*parameter];
            let value = &mut next.effects[*effect].parameters[*parameter];
            if info.role == Role::Shape {
                let largest = if info.name == "frequency_hz" { 1e-2 } else { 1.0 };
                let moved = *value * s.clamp(-largest, largest).exp();
                let [low, high] = bounds(info);
                *value = moved.clamp(low, high);
            } else {
                *value += s;
            }
        }
        for (single, s) in next.singles.iter_mut().zip(&step[base + free.len()..]) {
            single.height_nt += s;
        }
        let behind = base + free.len() + next.singles.len();
        next.past.iter_mut().zip(&step[behind..]).for_each(|(past, s)| past.height_nt += s);
        next
    }

    /// Brings constants and turns, moved from one state to the next by a step, to where readings move in a
    /// straight line. Coils and sensors that move together by any linear map leave the coils' field in the
    /// sensors as it was: where all of both is unknown, such maps are made as a whole.
    fn straighten(&self, before: &State, next: &mut State) {
        for (run, own) in self.observed.runs.iter().enumerate() {
            let unit = self.unit(run);
            if (0..run).any(|earlier| self.unit(earlier) == unit) {
                continue;
            }
            let chain = Chain { unknowns: &self.unknowns, basic: &own.setting.basic, unit };
            let mut sensors = Axis::ALL.map(|axis| chain.sensor_moved((before, next), axis));
            if let Some(coils) = chain.coils_moved((before, next)) {
                let [now, by] = coils.map(|vectors| Matrix3::from_columns(&vectors));
                let vectors = [0, 1].map(|k| Matrix3::from_columns(&sensors.map(|sensor| sensor.vector[k])));
                if let (Some(coils), Some(moved)) = (mapped(&now, &by), mapped(&vectors[0], &vectors[1])) {
                    chain.set_coils(next, &coils);
                    for (k, sensor) in sensors.iter_mut().enumerate() {
                        sensor.vector[1] = moved.column(k) - sensor.vector[0];
                    }
                }
            }
            for (axis, sensor) in Axis::ALL.into_iter().zip(sensors) {
                chain.straighten_sensor(next, axis, &sensor);
            }
        }
    }
}

/// The constants of the readings in a unit, as they came.
struct Chain<'m> {
    unknowns: &'m [Unknown],
    basic: &'m Basic,
    unit: Unit,
}

impl Chain<'_> {
    fn unknown(&self, parameter: Parameter) -> Option<usize> {
        self.unknowns.iter().position(|unknown| *unknown == Unknown::Chain(parameter, self.unit))
    }

    fn turns(&self, of: fn(Axis, usize) -> Parameter, axis: Axis) -> [Option<usize>; 2] {
        [0, 1].map(|which| self.unknown(of(axis, which)))
    }

    /// Constant times direction of each coil before, and its move; None unless all of coils and sensors is unknown.
    fn coils_moved(&self, (before, next): (&State, &State)) -> Option<[[Vector3<f64>; 3]; 2]> {
        let mut vectors = [[Vector3::zeros(); 3]; 2];
        for axis in Axis::ALL {
            self.unknown(Parameter::Sensitivity(axis))?;
            let [first, second] = self.turns(Parameter::SensorTurn, axis);
            first.and(second)?;
            let constant = self.unknown(Parameter::CoilConstant(axis))?;
            let turns = self.turns(Parameter::CoilTurn, axis);
            turns[0].and(turns[1])?;
            let k = axis.index();
            let c = self.basic.coils[k].constant_nt_per_a + before.base[constant];
            let stated = self.basic.eta.column(k).normalize();
            let [direction, turned] = turned_by_step(&stated, turns, (before, next));
            vectors[0][k] = direction * c;
            vectors[1][k] = turned * c + direction * (next.base[constant] - before.base[constant]);
        }
        Some(vectors)
    }

    fn set_coils(&self, next: &mut State, coils: &Matrix3<f64>) {
        for axis in Axis::ALL {
            let k = axis.index();
            let (stated, coil) = (self.basic.eta.column(k).normalize(), coils.column(k).into_owned());
            let constant = coil.norm() * coil.dot(&stated).signum() - self.basic.coils[k].constant_nt_per_a;
            set(next, self.unknown(Parameter::CoilConstant(axis)), constant);
            set_turns(next, self.turns(Parameter::CoilTurn, axis), along_tangents(&stated, &coil));
        }
    }

    /// What a sensor's reading is made of before a step, and by how much the step moves it.
    fn sensor_moved(&self, (before, next): (&State, &State), axis: Axis) -> Sensor {
        let stated = self.basic.sensors[axis.index()];
        let column: Vector3<f64> = self.basic.mu.column(axis.index()).into_owned();
        let (length, direction) = (column.norm(), column.normalize());
        let turns = self.turns(Parameter::SensorTurn, axis);
        let [mu, d_mu] = turned_by_step(&direction, turns, (before, next)).map(|part| part * length);
        let of = |stated: f64, unknown: Option<usize>| {
            let now = value(before, unknown);
            [stated + now, value(next, unknown) - now]
        };
        let [k, d_k] = of(stated.sensitivity, self.unknown(Parameter::Sensitivity(axis)));
        let [o, d_o] = of(stated.offset_nt, self.unknown(Parameter::SensorOffset(axis)));
        Sensor {
            vector: [mu / k, d_mu / k - mu * (d_k / (k * k))],
            offset: o / k + d_o / k - o * d_k / (k * k),
            sensitivity: k + d_k,
        }
    }

    fn straighten_sensor(&self, next: &mut State, axis: Axis, sensor: &Sensor) {
        let stated = self.basic.sensors[axis.index()];
        let column: Vector3<f64> = self.basic.mu.column(axis.index()).into_owned();
        let m = sensor.vector[0] + sensor.vector[1];
        let direction = column.normalize();
        let turn = along_tangents(&direction, &m);
        let along = m.dot(&direction);
        let far = turn.iter().any(|turn| turn.abs() > FARTHEST_TURN);
        if !(along > 0.0 && along.is_finite()) || far {
            return;
        }
        let sensitivity = self.unknown(Parameter::Sensitivity(axis));
        let k = if sensitivity.is_some() { column.norm() / m.norm() } else { sensor.sensitivity };
        set(next, sensitivity, k - stated.sensitivity);
        set(next, self.unknown(Parameter::SensorOffset(axis)), sensor.offset * k - stated.offset_nt);
        set_turns(next, self.turns(Parameter::SensorTurn, axis), turn);
    }
}

/// A sensor on a step, in units of its sensitivity.
#[derive(Clone, Copy)]
struct Sensor {
    /// μ/k before, and by how much it moves.
    vector: [Vector3<f64>; 2],
    /// O/k where the step ends.
    offset: f64,
    /// k there.
    sensitivity: f64,
}

fn value(state: &State, unknown: Option<usize>) -> f64 {
    unknown.map_or(0.0, |k| state.base[k])
}

fn set(state: &mut State, unknown: Option<usize>, value: f64) {
    if let Some(unknown) = unknown {
        state.base[unknown] = value;
    }
}

fn set_turns(state: &mut State, unknowns: [Option<usize>; 2], turn: [f64; 2]) {
    unknowns.into_iter().zip(turn).for_each(|(unknown, turn)| set(state, unknown, turn));
}

/// A direction before a step that turns it, and by how much it moves to first order.
fn turned_by_step(
    stated: &Vector3<f64>,
    turns: [Option<usize>; 2],
    (before, next): (&State, &State),
) -> [Vector3<f64>; 2] {
    let turn = turns.map(|unknown| value(before, unknown));
    let by_turn = frames::turned_derivatives(stated, turn);
    let moved = turns.map(|unknown| value(next, unknown) - value(before, unknown));
    [frames::turned(stated, turn), by_turn[0] * moved[0] + by_turn[1] * moved[1]]
}

/// The turns along the tangents of a direction that lead to another.
fn along_tangents(direction: &Vector3<f64>, to: &Vector3<f64>) -> [f64; 2] {
    let along = to.dot(direction);
    frames::tangents(direction).map(|tangent| tangent.dot(to) / along)
}

/// Where the linear map G that moves vectors V (columns) by δV to first order takes them as a whole: exp(G) V,
/// G = δV V⁻¹. None where the vectors are in a plane.
fn mapped(vectors: &Matrix3<f64>, by: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let map = by * vectors.try_inverse()?;
    (map.norm() < FARTHEST_TURN).then(|| map.exp() * vectors)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coils by G, sensors by −Gᵀ: the product of their vectors is what sensors read of coils.
    #[test]
    fn coils_and_sensors_that_move_together_leave_readings_as_they_were() {
        let coils = Matrix3::new(3.0, 0.1, -0.2, 0.0, 3.1, 0.1, 0.2, -0.1, 2.9);
        let sensors = Matrix3::new(0.0, 1.0, 0.05, -1.0, 0.02, 0.0, 0.01, 0.0, 1.0);
        let map = Matrix3::new(0.02, -0.1, 0.0, 0.2, 0.0, 0.03, 0.0, 0.05, -0.01);
        let moved_coils = mapped(&coils, &(map * coils)).expect("in no plane");
        let moved_sensors = mapped(&sensors, &(-map.transpose() * sensors)).expect("in no plane");
        let (before, after) = (sensors.transpose() * coils, moved_sensors.transpose() * moved_coils);
        assert!((after - before).norm() < 1e-14 && (moved_coils - coils).norm() > 0.5);
        assert!(mapped(&Matrix3::zeros(), &map).is_none());
    }
}
