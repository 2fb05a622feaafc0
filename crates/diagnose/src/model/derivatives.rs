//! Derivatives of what is predicted by the unknowns.

use common::Axis;
use physics::{Basic, Parameter, Prediction, Role, frames};
use rayon::prelude::*;

use super::prediction::Seen;
use super::state::{Model, State};
use super::step::at_bound;
use super::unknown::{Unknown, chain};
use crate::Error;

/// Step of the differences by which turns of the block enter, rad.
const TURN_RAD: f64 = 1e-5;

impl Model<'_> {
    /// Derivatives of what is predicted by the unknowns of the base model at a state.
    pub fn base_columns(&self, state: &State) -> Result<Vec<Vec<f64>>, Error> {
        let runs: Vec<Vec<Vec<f64>>> = (0..self.observed.runs.len())
            .into_par_iter()
            .map(|run| {
                let (now, _) = self.setting(state, run);
                let moving: Vec<Vec<(Parameter, f64)>> = self
                    .unknowns
                    .iter()
                    .map(|unknown| match unknown {
                        Unknown::Chain(parameter, unit) if *unit == self.unit(run) => {
                            self.local(&now, run, *parameter)
                        }
                        _ => Vec::new(),
                    })
                    .collect();
                let is_wanted = |own: &Parameter| moving.iter().flatten().any(|(local, _)| local == own);
                let parameters: Vec<Parameter> = chain().filter(is_wanted).collect();
                let Seen { basic, prediction, derivatives } = self.predict(state, run, &parameters)?;
                let length: usize = self.observed.channels_of(run).map(|channel| channel.rows.len()).sum();
                let stack = |derivative: &Prediction| -> Vec<f64> {
                    let channels = self.observed.channels_of(run);
                    channels.flat_map(|channel| channel.derivative(&basic, &prediction, derivative)).collect()
                };
                let moved = |unknown: usize, step: f64| -> Result<Vec<f64>, Error> {
                    let values = |sign: f64| -> Result<Vec<f64>, Error> {
                        let mut state = state.clone();
                        state.base[unknown] += sign * step;
                        let seen = self.predict(&state, run, &[])?;
                        let channels = self.observed.channels_of(run);
                        Ok(channels.flat_map(|c| c.predicted(&seen.basic, &seen.prediction)).collect())
                    };
                    let (above, below) = (values(1.0)?, values(-1.0)?);
                    Ok(above.iter().zip(below).map(|(a, b)| (a - b) / (2.0 * step)).collect())
                };
                self.unknowns
                    .iter()
                    .enumerate()
                    .map(|(number, unknown)| match unknown {
                        Unknown::Chain(_, unit) if *unit == self.unit(run) => {
                            let mut column = vec![0.0; length];
                            for (local, weight) in &moving[number] {
                                let at = parameters.iter().position(|p| p == local).unwrap_or(0);
                                let Some(derivative) = derivatives[at].as_ref() else { continue };
                                column.iter_mut().zip(stack(derivative)).for_each(|(c, d)| *c += weight * d);
                            }
                            Ok(column)
                        }
                        Unknown::Field(_) if self.observed.runs[run].setting.context.in_coils => {
                            moved(number, 1.0)
                        }
                        Unknown::Turn { setting, .. } if *setting == self.settings[run] => {
                            moved(number, TURN_RAD)
                        }
                        _ => Ok(vec![0.0; length]),
                    })
                    .collect::<Result<Vec<_>, Error>>()
            })
            .collect::<Result<_, Error>>()?;
        Ok((0..self.unknowns.len())
            .map(|k| match self.unknowns[k] {
                Unknown::Level(channel) => self.level(channel),
                _ => runs.iter().flat_map(|run| run[k].iter().copied()).collect(),
            })
            .collect())
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
        let parts: Vec<Vec<Vec<f64>>> = (0..self.observed.runs.len())
            .into_par_iter()
            .map(|run| {
                let Seen { basic, prediction, derivatives } = self.predict(state, run, parameters)?;
                let stack = |derivative: &Option<Prediction>| {
                    let mut part = Vec::new();
                    for channel in self.observed.channels_of(run) {
                        match derivative {
                            Some(derivative) => {
                                part.extend(channel.derivative(&basic, &prediction, derivative));
                            }
                            None => part.extend(std::iter::repeat_n(0.0, channel.rows.len())),
                        }
                    }
                    part
                };
                Ok(derivatives.iter().map(stack).collect())
            })
            .collect::<Result<_, Error>>()?;
        Ok((0..parameters.len())
            .map(|k| parts.iter().flat_map(|part| part[k].iter().copied()).collect())
            .collect())
    }

    /// Columns of the last effect of a state: the derivatives by its amplitudes, or, of an effect that has
    /// none, by how much it changes what a state without it predicts, and whether it is that.
    pub fn columns_of_last(&self, without: &State, with: &State) -> Result<(Vec<Vec<f64>>, bool), Error> {
        let number = with.effects.len() - 1;
        let infos = with.effects[number].kind.parameters().iter().enumerate();
        let amplitudes: Vec<Parameter> = infos
            .filter(|(_, info)| info.role == Role::Amplitude)
            .map(|(k, _)| Parameter::Effect(number, k))
            .collect();
        if amplitudes.is_empty() {
            return Ok((vec![self.change(without, with)?], true));
        }
        Ok((self.derivatives(with, &amplitudes)?, false))
    }
}
