//! Steps over the constants of the sensors along which readings move in a straight line.
//!
//! A sensor reads (μ·B − O)/k = m·B − o, which is linear in m = μ/k and o = O/k, but not in sensitivity,
//! turns and offset. Where a field hardly changes, m and o trade with each other over long distances, and
//! steps over k, O and turns would leave the valley. So a step is taken over m and o, and k, O and the turns
//! are those of where it ends.

use common::Axis;
use nalgebra::Vector3;
use physics::{Parameter, Role, Unit, frames};

use super::state::{Model, State};
use super::unknown::Unknown;

/// A time constant or a level goes no farther beyond its plausible range than by this factor.
const FARTHEST: f64 = 10.0;
/// A step that turns a sensor by more than this is left as it is, rad.
const FARTHEST_TURN: f64 = 0.5;

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
                *value = moved.clamp(info.low / FARTHEST, info.high * FARTHEST);
            } else {
                *value += s;
            }
        }
        for (column, s) in next.columns.iter_mut().zip(&step[base + free.len()..]) {
            column.coefficient += s;
        }
        next
    }

    /// Brings the constants of all sensors, moved from one state to the next by a step, to where readings
    /// move in a straight line.
    fn straighten(&self, before: &State, next: &mut State) {
        for run in 0..self.observed.runs.len() {
            let unit = self.unit(run);
            if (0..run).any(|earlier| self.unit(earlier) == unit) {
                continue;
            }
            for axis in Axis::ALL {
                self.straighten_sensor(before, next, (run, unit, axis));
            }
        }
    }

    fn straighten_sensor(&self, before: &State, next: &mut State, (run, unit, axis): (usize, Unit, Axis)) {
        let at = |parameter: Parameter| {
            self.unknowns.iter().position(|unknown| *unknown == Unknown::Chain(parameter, unit))
        };
        let sensitivity = at(Parameter::Sensitivity(axis));
        let offset = at(Parameter::SensorOffset(axis));
        let turns = [0, 1].map(|which| at(Parameter::SensorTurn(axis, which)));
        let value = |state: &State, unknown: Option<usize>| unknown.map_or(0.0, |k| state.base[k]);
        let basic = &self.observed.runs[run].setting.basic;
        let stated = basic.sensors[axis.index()];
        let column: Vector3<f64> = basic.mu.column(axis.index()).into_owned();
        let (length, direction) = (column.norm(), column.normalize());

        let turn = turns.map(|unknown| value(before, unknown));
        let mu = frames::turned_at_length(&column, turn);
        let k = stated.sensitivity + value(before, sensitivity);
        let o = stated.offset_nt + value(before, offset);
        let by_turn = frames::turned_derivatives(&direction, turn);
        let moved = |unknown: Option<usize>| value(next, unknown) - value(before, unknown);
        let d_mu = (by_turn[0] * moved(turns[0]) + by_turn[1] * moved(turns[1])) * length;
        let (d_k, d_o) = (moved(sensitivity), moved(offset));

        let m = mu / k + d_mu / k - mu * (d_k / (k * k));
        let own = o / k + d_o / k - o * d_k / (k * k);
        let [first, second] = frames::tangents(&direction);
        let along = m.dot(&direction);
        let turn = [first.dot(&m) / along, second.dot(&m) / along];
        let far = turn.iter().any(|turn| turn.abs() > FARTHEST_TURN);
        if !(along > 0.0 && along.is_finite()) || far {
            return;
        }
        let k = if sensitivity.is_some() { length / m.norm() } else { k };
        let mut set = |unknown: Option<usize>, value: f64| {
            if let Some(unknown) = unknown {
                next.base[unknown] = value;
            }
        };
        set(sensitivity, k - stated.sensitivity);
        set(offset, own * k - stated.offset_nt);
        (0..2).for_each(|which| set(turns[which], turn[which]));
    }
}
