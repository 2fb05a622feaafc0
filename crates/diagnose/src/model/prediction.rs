//! What is predicted of the recordings at a state, and what that leaves of the readings.

use nalgebra::Vector3;
use physics::{Basic, Context, EffectInstance, Parameter, Prediction, frames};
use rayon::prelude::*;

use super::state::{Model, State};
use super::unknown::Unknown;
use crate::Error;
use crate::magnitude;

/// What is predicted of a run at a state.
pub(super) struct Seen {
    pub basic: Basic,
    pub prediction: Prediction,
    /// By each parameter; None for those of an effect that does not act there.
    pub derivatives: Vec<Option<Prediction>>,
}

impl<'a> Model<'a> {
    /// Prediction of a run at a state, and its derivatives.
    pub(super) fn predict(&self, state: &State, run: usize, parameters: &[Parameter]) -> Result<Seen, Error> {
        let (basic, context) = self.setting(state, run);
        let acting: Vec<usize> = (0..state.effects.len()).filter(|k| state.acts[*k][run]).collect();
        let effects: Vec<EffectInstance> = acting.iter().map(|k| state.effects[*k].clone()).collect();
        let mapped = |parameter: &Parameter| match parameter {
            Parameter::Effect(effect, number) => {
                Some(Parameter::Effect(acting.iter().position(|k| k == effect)?, *number))
            }
            other => Some(*other),
        };
        let mapped: Vec<Option<Parameter>> = parameters.iter().map(mapped).collect();
        let wanted: Vec<Parameter> = mapped.iter().flatten().copied().collect();
        let failed = |error: physics::Error| error.at(&self.observed.runs[run].path);
        let (prediction, found) =
            physics::predict_with_jacobian(&basic, &effects, &context, &wanted).map_err(failed)?;
        let mut found = found.into_iter();
        let derivatives = mapped.iter().map(|there| there.and_then(|_| found.next())).collect();
        Ok(Seen { basic, prediction, derivatives })
    }

    /// The chain and the conditions of a run at a state.
    pub fn setting(&self, state: &State, run: usize) -> (Basic, Context<'a>) {
        let mut basic = self.observed.runs[run].setting.basic.clone();
        let mut context = self.observed.runs[run].setting.context.clone();
        let instrument = self.unit(run);
        let mut turns = [[[0.0; 2]; 3]; 2];
        let mut rotation = Vector3::zeros();
        for (unknown, value) in self.unknowns.iter().zip(&state.base) {
            match unknown {
                Unknown::Chain(Parameter::SensorTurn(axis, which), of) if *of == instrument => {
                    turns[0][axis.index()][*which] = *value;
                }
                Unknown::Chain(Parameter::CoilTurn(axis, which), of) if *of == instrument => {
                    turns[1][axis.index()][*which] = *value;
                }
                Unknown::Chain(parameter, of) if *of == instrument => {
                    if let Some(place) = basic.constant_mut(*parameter) {
                        *place += value;
                    }
                }
                Unknown::Field(axis) if context.in_coils => {
                    context.ambient_nt.iter_mut().for_each(|field| field[axis.index()] += value);
                }
                Unknown::Turn { setting, about } if *setting == self.settings[run] => {
                    rotation[*about] = *value;
                }
                _ => {}
            }
        }
        for (matrix, turns) in [&mut basic.mu, &mut basic.eta].into_iter().zip(turns) {
            for (k, turn) in turns.into_iter().enumerate().filter(|(_, turn)| *turn != [0.0; 2]) {
                let turned = frames::turned_at_length(&matrix.column(k).into_owned(), turn);
                matrix.set_column(k, &turned);
            }
        }
        if rotation != Vector3::zeros() {
            context.orientation.rotation = frames::small_rotation(&rotation) * context.orientation.rotation;
        }
        if !self.observed.runs[run].smooth.is_empty() {
            context.ambient_nt = magnitude::ambient(&self.observed.runs[run], &basic, &context);
        }
        (basic, context)
    }

    /// One in a channel, or ±1 by the position of a reversal; stacked.
    pub(super) fn level(&self, number: usize) -> Vec<f64> {
        let channel = &self.observed.channels[number];
        let position = self.observed.runs[channel.run].recording.column("position");
        let mut column = vec![0.0; self.observed.rows];
        for (at, row) in channel.range().zip(&channel.rows) {
            column[at] = position.map_or(1.0, |position| position[*row]);
        }
        column
    }

    /// What is predicted of a run, nT, channel by channel.
    pub(super) fn predicted_in(&self, state: &State, run: usize) -> Result<Vec<f64>, Error> {
        let Seen { basic, prediction, .. } = self.predict(state, run, &[])?;
        let channels = self.observed.channels_of(run);
        Ok(channels.flat_map(|channel| channel.predicted(&basic, &prediction)).collect())
    }

    /// What is predicted, nT, stacked.
    pub fn predicted(&self, state: &State) -> Result<Vec<f64>, Error> {
        let runs = (0..self.observed.runs.len()).into_par_iter();
        let parts: Vec<Vec<f64>> =
            runs.map(|run| self.predicted_in(state, run)).collect::<Result<_, Error>>()?;
        Ok(parts.concat())
    }

    /// Observed less predicted, nT, over all channels.
    pub fn residual(&self, state: &State) -> Result<Vec<f64>, Error> {
        let mut residual = self.predicted(state)?;
        for channel in &self.observed.channels {
            let own = residual[channel.range()].iter_mut().zip(&channel.readings);
            own.for_each(|(residual, reading)| *residual = channel.to_nt * reading - *residual);
        }
        for (number, unknown) in self.unknowns.iter().enumerate() {
            if let Unknown::Level(channel) = unknown {
                let level = state.base[number];
                let column = self.level(*channel);
                residual.iter_mut().zip(&column).for_each(|(r, c)| *r -= level * c);
            }
        }
        for single in &state.singles {
            residual[single.row] -= single.height_nt;
        }
        for past in &state.past {
            residual.iter_mut().zip(self.past(state, past)).for_each(|(r, c)| *r -= past.height_nt * c);
        }
        Ok(residual)
    }

    /// By how much what is predicted changes from one state to another, stacked.
    pub fn change(&self, from: &State, to: &State) -> Result<Vec<f64>, Error> {
        let (before, after) = (self.residual(from)?, self.residual(to)?);
        Ok(before.iter().zip(after).map(|(a, b)| a - b).collect())
    }
}
