//! Shapes that no instrument and nothing near one has.

use common::number::significant;

use crate::Outcome;
use crate::model::Model;

/// A time constant or a level may be this factor beyond its plausible range, and by so many standard
/// uncertainties.
const BEYOND: f64 = 2.0;
const SURELY: f64 = 2.0;

/// Takes back the names where one was fitted with a shape that is surely not plausible: what has it is
/// something else.
pub fn judge(model: &Model<'_>, outcome: &mut Outcome) {
    let fit = &outcome.fit;
    let base = model.unknowns.len();
    let why = model.free(&fit.state).into_iter().enumerate().find_map(|(place, (effect, parameter))| {
        let effect = &fit.state.effects[effect];
        let (info, value) = (&effect.kind.parameters()[parameter], effect.parameters[parameter]);
        // Of its logarithm.
        let std = fit.covariance[(base + place, base + place)].sqrt();
        let beyond = is_beyond(value, std, [info.low, info.high]);
        (info.is_shape_at(value) && beyond).then(|| {
            let (name, kind, value) = (info.name, effect.kind.name(), significant(value, 3));
            format!("{kind} would need {name} = {value}; plausible values are {} to {}", info.low, info.high)
        })
    });
    if let Some(why) = why.filter(|_| !outcome.found.is_empty()) {
        outcome.without_names(&why);
    }
}

/// Whether a shape is surely outside its plausible range, by the standard uncertainty of its logarithm.
fn is_beyond(value: f64, std: f64, [low, high]: [f64; 2]) -> bool {
    let surely = |factor: f64| factor.ln() - SURELY * std > BEYOND.ln();
    surely(value / high) || surely(low / value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shape_is_implausible_where_it_surely_is() {
        let range = [1.0, 1000.0];
        let cases = [
            (4870.0, 0.12, true),
            (4870.0, 0.6, false),
            (1900.0, 0.01, false),
            (0.4, 0.1, true),
            (30.0, 0.1, false),
        ];
        for (value, std, beyond) in cases {
            assert_eq!(is_beyond(value, std, range), beyond, "{value} ± {std}");
        }
        // What is not determined is not implausible.
        assert!(!is_beyond(1e4, f64::INFINITY, range));
    }
}
