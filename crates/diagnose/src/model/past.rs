//! What effects that follow the field outside kept of the time before the recordings.

use physics::{EffectInstance, Family};

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

/// The time constants of an effect that follows the field outside.
fn time_constants_s(effect: &EffectInstance) -> Vec<f64> {
    let about = effect.kind.about();
    let value = |name: &str| {
        let place = about.parameters.iter().position(|info| info.name == name);
        place.map(|place| effect.parameters[place])
    };
    let lag_s = value("lag_s").filter(|_| about.family == Family::OutsideField);
    let second = lag_s.zip(value("second_lag_ratio")).map(|(lag_s, ratio)| lag_s * ratio);
    [lag_s, second.filter(|tau| *tau > 0.0)].into_iter().flatten().collect()
}
