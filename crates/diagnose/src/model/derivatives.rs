//! Derivatives of what is predicted by the unknowns.

use common::Axis;
use physics::{Basic, Parameter, Role, frames};
use rayon::prelude::*;

use super::prediction::Seen;
use super::state::{Model, State, amplitudes};
use super::step::at_bound;
use super::unknown::{Unknown, chain};
use crate::Error;
use crate::channel::Channel;

/// Step of the differences by which turns of the block enter, rad.
const TURN_RAD: f64 = 1e-5;

impl Model<'_> {
    /// Derivatives of what is predicted by the unknowns of the base model at a state.
    pub fn base_columns(&self, state: &State) -> Result<Vec<Vec<f64>>, Error> {
        let runs = (0..self.observed.runs.len()).into_par_iter();
        let runs: Vec<Vec<Vec<f64>>> =
            runs.map(|run| self.base_columns_in(state, run)).collect::<Result<_, Error>>()?;
        let column = |(k, unknown): (usize, &Unknown)| match unknown {
            Unknown::Level(channel) => self.level(*channel),
            _ => runs.iter().flat_map(|run| run[k].iter().copied()).collect(),
        };
        Ok(self.unknowns.iter().enumerate().map(column).collect())
    }

    /// The same in one run, levels left out.
    fn base_columns_in(&self, state: &State, run: usize) -> Result<Vec<Vec<f64>>, Error> {
        let (now, _) = self.setting(state, run);
        let moving = |unknown: &Unknown| match unknown {
            Unknown::Chain(parameter, unit) if *unit == self.unit(run) => self.local(&now, run, *parameter),
            _ => Vec::new(),
        };
        let moving: Vec<Vec<(Parameter, f64)>> = self.unknowns.iter().map(moving).collect();
        let is_wanted = |own: &Parameter| moving.iter().flatten().any(|(local, _)| local == own);
        let parameters: Vec<Parameter> = chain().filter(is_wanted).collect();
        let seen = self.predict(state, run, &parameters)?;
        let length = self.observed.channels_of(run).map(|channel| channel.rows.len()).sum();
        let moved = |unknown: usize, step: f64| -> Result<Vec<f64>, Error> {
            let values = |sign: f64| {
                let mut state = state.clone();
                state.base[unknown] += sign * step;
                self.predicted_in(&state, run)
            };
            let (above, below) = (values(1.0)?, values(-1.0)?);
            Ok(above.iter().zip(below).map(|(a, b)| (a - b) / (2.0 * step)).collect())
        };
        let column = |(number, unknown): (usize, &Unknown)| match unknown {
            Unknown::Field(_) if self.observed.runs[run].setting.context.in_coils => moved(number, 1.0),
            Unknown::Turn { setting, .. } if *setting == self.settings[run] => moved(number, TURN_RAD),
            _ => {
                let mut column = vec![0.0; length];
                for (local, weight) in &moving[number] {
                    let at = parameters.iter().position(|p| p == local).unwrap_or(0);
                    let own = self.derivative_in(run, &seen, at);
                    column.iter_mut().zip(own).for_each(|(c, d)| *c += weight * d);
                }
                Ok(column)
            }
        };
        self.unknowns.iter().enumerate().map(column).collect()
    }

    /// The derivative with respect to one of the parameters of what is predicted of a run, channel by channel.
    fn derivative_in(&self, run: usize, seen: &Seen, parameter: usize) -> Vec<f64> {
        let of = |channel: &Channel| match &seen.derivatives[parameter] {
            Some(derivative) => channel.derivative(&seen.basic, &seen.prediction, derivative),
            None => vec![0.0; channel.rows.len()],
        };
        self.observed.channels_of(run).flat_map(of).collect()
    }

    /// What moves when a parameter of the chain moves. A turn counts along the tangents of the direction as
    /// the document has it; the chain's derivatives are along those of the direction as it stands.
    fn local(&self, now: &Basic, run: usize, parameter: Parameter) -> Vec<(Parameter, f64)> {
        let before = &self.observed.runs[run].setting.basic;
        let (axis, which, before, now, of): (_, _, _, _, fn(Axis, usize) -> Parameter) = match parameter {
            Parameter::SensorTurn(axis, which) => (axis, which, &before.mu, &now.mu, Parameter::SensorTurn),
            Parameter::CoilTurn(axis, which) => (axis, which, &before.eta, &now.eta, Parameter::CoilTurn),
            other => return vec![(other, 1.0)],
        };
        let unit = |matrix: &nalgebra::Matrix3<f64>| matrix.column(axis.index()).into_owned().normalize();
        let (before, now) = (unit(before), unit(now));
        let along = frames::tangents(&before)[which];
        // (u + t)/|u + t| moves by what is across it, and |u + t| = 1/(u·v).
        let moved = (along - now * now.dot(&along)) * before.dot(&now);
        let local = frames::tangents(&now);
        (0..2).map(|k| (of(axis, k), local[k].dot(&moved))).collect()
    }

    /// Derivatives of what is predicted by the unknowns behind those of the base model at a state: effects,
    /// single readings, the past. Shapes count by their logarithm, and not at all once they have come to a bound.
    pub fn other_columns(&self, state: &State) -> Result<Vec<Vec<f64>>, Error> {
        let free = self.free(state);
        let parameters: Vec<Parameter> = free.iter().map(|(e, p)| Parameter::Effect(*e, *p)).collect();
        let mut of_effects = self.derivatives(state, &parameters)?;
        for (column, (effect, parameter)) in of_effects.iter_mut().zip(&free) {
            let instance = &state.effects[*effect];
            let info = &instance.kind.parameters()[*parameter];
            if info.role == Role::Shape {
                let value = instance.parameters[*parameter];
                let value = if at_bound(info, value) { 0.0 } else { value };
                column.iter_mut().for_each(|d| *d *= value);
            }
        }
        of_effects.extend(state.singles.iter().map(|single| self.one_at(single.row)));
        of_effects.extend(state.past.iter().map(|past| self.past(state, past)));
        Ok(of_effects)
    }

    /// One in a row of the stack.
    pub fn one_at(&self, row: usize) -> Vec<f64> {
        let mut column = vec![0.0; self.observed.rows];
        column[row] = 1.0;
        column
    }

    /// Derivatives of what is predicted by parameters of effects, stacked.
    pub fn derivatives(&self, state: &State, parameters: &[Parameter]) -> Result<Vec<Vec<f64>>, Error> {
        let of = |run: usize| {
            let seen = self.predict(state, run, parameters)?;
            Ok((0..parameters.len()).map(|k| self.derivative_in(run, &seen, k)).collect())
        };
        let runs = (0..self.observed.runs.len()).into_par_iter();
        let parts: Vec<Vec<Vec<f64>>> = runs.map(of).collect::<Result<_, Error>>()?;
        let column = |k: usize| parts.iter().flat_map(|part| part[k].iter().copied()).collect();
        Ok((0..parameters.len()).map(column).collect())
    }

    /// Columns of the last effect of a state: the derivatives by its amplitudes, or, of an effect that has
    /// none, by how much it changes what a state without it predicts, and whether it is that.
    pub fn columns_of_last(&self, without: &State, with: &State) -> Result<(Vec<Vec<f64>>, bool), Error> {
        let number = with.effects.len() - 1;
        let amplitudes = amplitudes(with.effects[number].kind);
        if amplitudes.is_empty() {
            return Ok((vec![self.change(without, with)?], true));
        }
        let amplitudes: Vec<Parameter> =
            amplitudes.into_iter().map(|k| Parameter::Effect(number, k)).collect();
        Ok((self.derivatives(with, &amplitudes)?, false))
    }
}
