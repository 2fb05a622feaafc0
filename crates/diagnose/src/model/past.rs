//! What effects that follow the field outside kept of the time before the recordings.

use physics::{EffectInstance, Family, Kind, ParameterInfo};

use super::state::{Model, Past, State};
use crate::Error;
use crate::algebra::square;

impl Model<'_> {
    /// A state with the past of its effects from one on, unknown and as large as what they do.
    pub fn with_past(&self, mut state: State, from: usize) -> Result<State, Error> {
        for effect in from..state.effects.len() {
            let relaxations = time_constants_s(&state.effects[effect]).len();
            if relaxations == 0 {
                continue;
            }
            let mut without = state.clone();
            without.acts[effect].fill(false);
            let does = self.change(&without, &state)?;
            for (channel, of) in self.observed.channels.iter().enumerate() {
                let std_nt = (square(&does[of.range()]) / of.rows.len() as f64).sqrt();
                let past = |relaxation| Past { effect, relaxation, channel, height_nt: 0.0, std_nt };
                state.past.extend((0..relaxations).filter(|_| std_nt > 0.0).map(past));
            }
        }
        Ok(state)
    }

    /// What one nT of it does, stacked.
    pub(super) fn past(&self, state: &State, past: &Past) -> Vec<f64> {
        let mut column = vec![0.0; self.observed.rows];
        let channel = &self.observed.channels[past.channel];
        let time = self.observed.runs[channel.run].time_s;
        let taus = time_constants_s(&state.effects[past.effect]);
        if let (Some(time), Some(tau)) = (time, taus.get(past.relaxation)) {
            for (at, row) in channel.range().zip(&channel.rows) {
                column[at] = ((time[0] - time[*row]) / tau).exp();
            }
        }
        column
    }
}

/// Which parameter is the time constant of an effect that remembers fields. One that remembers temperatures has none
/// here: they are let settle before a recording.
pub fn time_constant(kind: Kind) -> Option<usize> {
    let about = kind.about();
    let remembers = matches!(about.family, Family::LateResponse | Family::OutsideField);
    let is_it = |info: &ParameterInfo| ["lag_s", "time_constant_s"].contains(&info.name);
    about.parameters.iter().position(is_it).filter(|_| remembers)
}

/// The time constants of an effect that follows the field outside, which was there before a recording; drives were at
/// rest.
fn time_constants_s(effect: &EffectInstance) -> Vec<f64> {
    let infos = effect.kind.parameters();
    let place = time_constant(effect.kind).filter(|_| effect.kind.follows_outside());
    let second = infos.iter().position(|info| info.name == "second_lag_ratio");
    let Some(tau) = place.map(|place| effect.parameters[place]) else { return Vec::new() };
    let second = second.map(|place| effect.parameters[place] * tau).filter(|tau| *tau > 0.0);
    std::iter::once(tau).chain(second).collect()
}
