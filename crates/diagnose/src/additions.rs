//! What comes into the model as states, columns and effects.

use physics::{EffectInstance, Parameter, Role};

use crate::Error;
use crate::candidates::Shape;
use crate::model::{Model, State, amplitudes};
use crate::pool::searched;
use crate::proposal::{Addition, Proposal, What};
use crate::stacked::Stacked;

/// The columns of an effect at the shapes of a fit, and the derivatives by those, sizes as in the fit.
pub fn at_shapes(
    model: &Model<'_>,
    state: &State,
    effect: &EffectInstance,
) -> Result<(Vec<Stacked>, Vec<Stacked>), Error> {
    let with = model.with(state, effect.clone());
    let number = with.effects.len() - 1;
    let infos = effect.kind.parameters();
    let shapes: Vec<usize> =
        (0..infos.len()).filter(|k| infos[*k].is_shape_at(effect.parameters[*k])).collect();
    let stacked = |columns: Vec<Vec<f64>>| -> Vec<Stacked> {
        columns.iter().map(|column| Stacked::of(&model.observed, column)).collect()
    };
    let by: Vec<Parameter> = shapes.iter().map(|k| Parameter::Effect(number, *k)).collect();
    let mut by_shape = model.derivatives(&with, &by)?;
    for (column, k) in by_shape.iter_mut().zip(&shapes) {
        column.iter_mut().for_each(|d| *d *= effect.parameters[*k]);
    }
    let (columns, finite) = model.columns_of_last(state, &with)?;
    if finite {
        // Its size is its shape.
        by_shape.clear();
    }
    Ok((stacked(columns), stacked(by_shape)))
}

/// The columns of an event, and whether they are what it does rather than derivatives by its amplitudes.
pub fn columns_of(
    model: &Model<'_>,
    state: &State,
    event: &Proposal,
) -> Result<Option<(Vec<Stacked>, bool)>, Error> {
    let (dense, finite) = match &event.addition {
        Addition::Single(single) => (vec![model.one_at(single.row)], false),
        Addition::Effect(effect) => model.columns_of_last(state, &model.with(state, effect.clone()))?,
    };
    let columns: Vec<Stacked> = dense.iter().map(|column| Stacked::of(&model.observed, column)).collect();
    let fit = columns.iter().all(Stacked::is_finite) && !columns.iter().all(Stacked::is_zero);
    Ok(fit.then_some((columns, finite)))
}

pub fn with_additions(model: &Model<'_>, state: &State, additions: &[Addition]) -> State {
    additions.iter().fold(state.clone(), |mut state, addition| match addition {
        Addition::Effect(effect) => model.with(&state, effect.clone()),
        Addition::Single(single) => {
            state.singles.push(single.clone());
            state
        }
    })
}

/// A state without additions that stand in it from some numbers of effects and singles on; the numbers behind them.
pub fn without(state: &State, from: (usize, usize), gone: &[Addition]) -> (State, (usize, usize)) {
    let effects = gone.iter().filter(|one| matches!(one, Addition::Effect(_))).count();
    let to = (from.0 + effects, from.1 + gone.len() - effects);
    let mut state = state.clone();
    state.keep_effects(|number| !(from.0..to.0).contains(&number));
    state.singles.drain(from.1..to.1);
    (state, to)
}

/// What comes in for an atom at a shape with its coefficients.
pub fn additions(what: &What, shape: &Shape, coefficients: &[f64]) -> Vec<Addition> {
    match what {
        What::Physics(template) => {
            let mut effect = shape.form.as_ref().unwrap_or(template).clone();
            let searched = searched(effect.kind);
            let shape = shape.value;
            let mut sizes = coefficients.iter();
            let sized = !amplitudes(effect.kind).is_empty();
            for (k, info) in effect.kind.parameters().iter().enumerate() {
                match (info.role, shape) {
                    (Role::Amplitude, _) => effect.parameters[k] = sizes.next().copied().unwrap_or(0.0),
                    (_, Some(value)) if Some(k) == searched => {
                        // What is a little late does as much as it is late.
                        let late = !sized && info.name.ends_with("_s");
                        let times = coefficients.first().filter(|_| late).map_or(1.0, |c| c.abs());
                        effect.parameters[k] = value * times;
                    }
                    _ => {}
                }
            }
            vec![Addition::Effect(effect)]
        }
        What::Event(additions) => additions.clone(),
        What::Smooth { .. } => Vec::new(),
    }
}
