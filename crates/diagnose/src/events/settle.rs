//! Where an event begins and ends, to the row.

use common::series::even_step_s;
use faer::Mat;
use physics::{Kind, Parameter, Role};

use crate::Error;
use crate::fit::{Fit, Fitter, columns, left, orthonormal, square};
use crate::model::State;

/// Most rows by which an event is moved.
const SHIFTS: usize = 8;

/// A fit one of whose effects begins or ends some rows earlier or later, where that fits better: what a large departure does to the
/// calibration hides where it begins. All other unknowns follow each shift linearly; the fit is refined at the best.
pub fn settled_in_time(fitter: &Fitter<'_, '_>, fit: Fit, number: usize) -> Result<Fit, Error> {
    let effect = &fit.state.effects[number];
    let movable: &[usize] = match effect.kind {
        Kind::Spike | Kind::ReadingStep => &[1],
        Kind::Dropout => &[0, 1],
        _ => return Ok(fit),
    };
    let step = effect.recording.as_ref().and_then(|id| {
        let run = fitter.model.observed.runs.iter().find(|run| run.recording.id == *id)?;
        even_step_s(run.time_s?)
    });
    let Some(step) = step else { return Ok(fit) };
    let others = Others::of(fitter, &fit, number)?;
    let as_it_is = others.left(fitter, &fit.state)?;
    let mut best = (as_it_is, fit.state.clone());
    for _ in 0..SHIFTS {
        let around = best.1.clone();
        let before = best.0;
        for &at in movable {
            for shift in [-step, step] {
                let mut state = around.clone();
                let parameters = &mut state.effects[number].parameters;
                parameters[at] += shift;
                if effect.kind == Kind::Dropout && at == 0 {
                    // The end stays.
                    parameters[1] -= shift;
                }
                let left = others.left(fitter, &state)?;
                if left < best.0 - 1e-6 * as_it_is {
                    best = (left, state);
                }
            }
        }
        if best.0 >= before {
            break;
        }
    }
    if best.0 >= as_it_is {
        return Ok(fit);
    }
    Ok(fitter.refine(&best.1).ok().filter(|moved| moved.cost < fit.cost).unwrap_or(fit))
}

/// The unknowns of a fit but those of one effect, as an orthonormal basis of their whitened derivatives.
struct Others {
    basis: Mat<f64>,
    /// The effect's amplitudes.
    own: Vec<Parameter>,
}

impl Others {
    fn of(fitter: &Fitter<'_, '_>, fit: &Fit, number: usize) -> Result<Self, Error> {
        let base = fitter.model.unknowns.len();
        let free = fitter.model.free(&fit.state);
        let is_own = |column: usize| {
            column.checked_sub(base).and_then(|k| free.get(k)).is_some_and(|(effect, _)| *effect == number)
        };
        let kept: Vec<usize> = (0..fit.jacobian.ncols()).filter(|column| !is_own(*column)).collect();
        let all = Mat::from_fn(fit.jacobian.nrows(), kept.len(), |i, j| fit.jacobian[(i, kept[j])]);
        let infos = fit.state.effects[number].kind.parameters().iter().enumerate();
        let amplitudes = infos.filter(|(_, info)| info.role == Role::Amplitude);
        let own = amplitudes.map(|(k, _)| Parameter::Effect(number, k)).collect();
        Ok(Self { basis: orthonormal(&all)?, own })
    }

    /// Sum of squares at a state, all unknowns but the moments of the effect fitted linearly.
    fn left(&self, fitter: &Fitter<'_, '_>, state: &State) -> Result<f64, Error> {
        let white = left(columns(&self.basis), &fitter.white(state)?.1);
        let mut rest = square(&white);
        for column in
            fitter.noise.whiten_all(&fitter.model.observed, &fitter.model.derivatives(state, &self.own)?)
        {
            let column = left(columns(&self.basis), &column);
            let along: f64 = column.iter().zip(&white).map(|(c, w)| c * w).sum();
            rest -= along * along / square(&column).max(f64::MIN_POSITIVE);
        }
        Ok(rest)
    }
}
