//! Where an event begins and ends, to the row.

use common::series::even_step_s;
use physics::Kind;

use crate::Error;
use crate::fit::{Fit, Fitter};

/// Most rows by which an event is moved.
const SHIFTS: usize = 8;

/// A fit one of whose effects begins or ends some rows earlier or later, where that fits better: what a large departure does to the
/// calibration hides where it begins.
pub fn settled_in_time(fitter: &Fitter<'_, '_>, mut fit: Fit, number: usize) -> Result<Fit, Error> {
    let effect = fit.state.effects[number].clone();
    let movable: Vec<usize> = match effect.kind {
        Kind::Spike | Kind::ReadingStep => vec![1],
        Kind::Dropout => vec![0, 1],
        _ => return Ok(fit),
    };
    let step = effect.recording.as_ref().and_then(|id| {
        let run = fitter.model.observed.runs.iter().find(|run| run.recording.id == *id)?;
        even_step_s(run.time_s?)
    });
    let Some(step) = step else { return Ok(fit) };
    for _ in 0..SHIFTS {
        let mut better: Option<Fit> = None;
        for &at in &movable {
            for sign in [-1.0, 1.0] {
                let mut state = fit.state.clone();
                state.effects[number].parameters[at] += sign * step;
                if effect.kind == Kind::Dropout && at == 0 {
                    // The end stays.
                    state.effects[number].parameters[1] -= sign * step;
                }
                let Ok(moved) = fitter.refine(&state) else { continue };
                if moved.cost < better.as_ref().map_or(fit.cost, |b| b.cost) - 1e-6 * fit.cost {
                    better = Some(moved);
                }
            }
        }
        match better {
            Some(moved) => fit = moved,
            None => break,
        }
    }
    Ok(fit)
}
