//! What is fitted: the calibration's parameters, what is not known of each recording, effects, and columns.
//!
//! `unknown` says what may be unknown and what is known of it beforehand, `state` where a fit stands, `prediction` and
//! `derivatives` what readings are there, `step` where a step leads.

mod derivatives;
mod prediction;
mod state;
mod step;
mod unknown;

pub use state::{Model, Single, State, amplitudes, named, target, time_constant};
pub use unknown::{Unknown, chain, moving_place, path, stated_std};

use common::Axis;
use physics::{Parameter, Unit, frames};
use std::sync::Mutex;

use crate::Error;
use crate::observed::Observed;
use unknown::{OFFSET_NT, possible, settings, undetermined};

impl<'a> Model<'a> {
    /// The recordings of a document; unknown is of the base model what they can feel.
    pub fn of(observed: Observed<'a>) -> Result<(Self, State), Error> {
        let settings = settings(&observed);
        let (unknowns, priors) = possible(&observed, &settings).into_iter().unzip();
        let mut model = Self { observed, unknowns, priors, settings, acting: Mutex::default() };
        let effects = physics::adopt(model.observed.document).map_err(|error| error.at("model"))?;
        let mut state = State { base: vec![0.0; model.unknowns.len()], ..State::default() };
        for effect in effects {
            state = model.with(&state, effect);
        }
        let jacobian = model.base_columns(&state)?;
        let mut felt: Vec<usize> =
            (0..model.unknowns.len()).filter(|k| jacobian[*k].iter().any(|value| *value != 0.0)).collect();
        if model.only_magnitudes() {
            model.without_common_turn(&mut felt);
        }
        model.unknowns = felt.iter().map(|k| model.unknowns[*k]).collect();
        model.priors = felt.iter().map(|k| model.priors[*k]).collect();
        state.base = vec![0.0; felt.len()];
        let columns: Vec<&Vec<f64>> = felt.iter().map(|k| &jacobian[*k]).collect();
        let is_offset =
            |k: &usize| matches!(model.unknowns[*k], Unknown::Chain(Parameter::SensorOffset(_), _));
        for k in undetermined(&columns, (0..felt.len()).filter(is_offset).collect())? {
            model.priors[k].get_or_insert(OFFSET_NT);
        }
        let state = model.with_past(state, 0)?;
        Ok((model, state))
    }

    /// Takes three turns of sensors out of the unknowns, so that no turn of all sensors together is left
    /// among them, which magnitudes alone do not show: both of x, and that of y which goes more about x.
    fn without_common_turn(&self, felt: &mut Vec<usize>) {
        let about_x = |unit: Unit| {
            let run = (0..self.observed.runs.len()).find(|run| self.unit(*run) == unit)?;
            let mu = &self.observed.runs[run].setting.basic.mu;
            let moved = mu.column(0).cross(&mu.column(1));
            let [first, second] =
                frames::tangents(&mu.column(1).into()).map(|tangent| tangent.dot(&moved).abs());
            Some(usize::from(second > first))
        };
        felt.retain(|unknown| match self.unknowns[*unknown] {
            Unknown::Chain(Parameter::SensorTurn(Axis::X, _), _) => false,
            Unknown::Chain(Parameter::SensorTurn(Axis::Y, turn), unit) => about_x(unit) != Some(turn),
            _ => true,
        });
    }
}
