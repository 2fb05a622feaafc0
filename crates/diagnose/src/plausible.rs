//! Shapes that no instrument and nothing near one has.

use common::number::significant;
use physics::Role;

use crate::Outcome;
use crate::model::Model;

/// A time constant or a level may be this factor beyond its plausible range, and by so many standard uncertainties.
const BEYOND: f64 = 2.0;
const SURELY: f64 = 2.0;

/// Takes back the names where one was fitted with a shape that is surely not plausible: what has it is something else.
pub fn judge(model: &Model<'_>, outcome: &mut Outcome) {
    let fit = &outcome.fit;
    let base = model.unknowns.len();
    let why = model.free(&fit.state).into_iter().enumerate().find_map(|(place, (effect, parameter))| {
        let effect = &fit.state.effects[effect];
        let (info, value) = (&effect.kind.parameters()[parameter], effect.parameters[parameter]);
        // Of its logarithm.
        let std = fit.covariance[(base + place, base + place)].sqrt();
        let surely = |factor: f64| factor.ln() - SURELY * std > BEYOND.ln();
        let beyond = surely(value / info.high) || surely(info.low / value);
        (info.role == Role::Shape && beyond).then(|| {
            let (name, kind, value) = (info.name, effect.kind.name(), significant(value, 3));
            format!("{kind} would have {name} = {value}; {} to {} are plausible", info.low, info.high)
        })
    });
    if let Some(why) = why.filter(|_| !outcome.found.is_empty()) {
        outcome.without_names(&why);
    }
}
