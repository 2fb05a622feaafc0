//! Where an event begins and ends, to the row.

use faer::Mat;
use physics::{EffectInstance, Kind, Parameter};

use crate::Error;
use crate::algebra::{columns, left, orthonormal, square};
use crate::fit::{Fit, Fitter};
use crate::model::{State, amplitudes};

/// Most rows by which an event is moved.
const SHIFTS: usize = 8;

/// A fit one of whose effects begins or ends some rows earlier or later, where that fits better: what a large
/// departure does to the calibration hides where it begins. All other unknowns follow each shift linearly;
/// the fit is refined at the best.
pub fn settled_in_time(fitter: &Fitter<'_, '_>, fit: Fit, number: usize) -> Result<Fit, Error> {
    let effect = &fit.state.effects[number];
    let movable: &[usize] = match effect.kind {
        Kind::Spike | Kind::ReadingStep => &[1],
        Kind::Dropout => &[0, 1],
        _ => return Ok(fit),
    };
    let Some(times) = times(fitter, effect) else { return Ok(fit) };
    let others = Others::of(fitter, &fit, number)?;
    let as_it_is = others.left(fitter, &fit.state)?;
    let mut best = (as_it_is, fit.state.clone());
    for _ in 0..SHIFTS {
        let around = best.1.clone();
        let before = best.0;
        for &at in movable {
            let parameters = &around.effects[number].parameters;
            let ends = effect.kind == Kind::Dropout && at == 1;
            let moment = if ends { parameters[0] + parameters[1] } else { parameters[at] };
            for shift in to_neighbours(&times, moment) {
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

/// The times of an event's recording, by the clock by which its moment is told.
fn times(fitter: &Fitter<'_, '_>, effect: &EffectInstance) -> Option<Vec<f64>> {
    let runs = fitter.model.observed.runs.iter();
    match &effect.recording {
        Some(id) => runs.filter(|run| run.recording.id == *id).find_map(|run| Some(run.time_s?.to_vec())),
        // What goes on in later recordings is told by the clock that they share.
        None => runs.filter_map(|run| run.on_clock()).find(|times| {
            let moment = effect.parameters.get(1).copied().unwrap_or(f64::NAN);
            times.first() <= Some(&moment) && Some(&moment) <= times.last()
        }),
    }
}

/// How far it is from the reading at a moment to the one before and the one after.
fn to_neighbours(times: &[f64], moment: f64) -> impl Iterator<Item = f64> {
    let after = times.partition_point(|time| *time < moment);
    let nearer = |row: &usize| times.get(*row).map_or(f64::INFINITY, |time| (time - moment).abs());
    let row = [after, after.saturating_sub(1)].into_iter().min_by(|a, b| nearer(a).total_cmp(&nearer(b)));
    let to = |other: Option<usize>| Some(times.get(other?)? - times.get(row?)?);
    [to(row.and_then(|row| row.checked_sub(1))), to(row.map(|row| row + 1))].into_iter().flatten()
}

/// The unknowns of a fit but those of one effect, as an orthonormal basis of their whitened derivatives.
struct Others {
    basis: Mat<f64>,
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
        let own = amplitudes(fit.state.effects[number].kind);
        let own = own.into_iter().map(|k| Parameter::Effect(number, k)).collect();
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

#[cfg(test)]
mod tests {
    use super::to_neighbours;

    #[test]
    fn a_moment_goes_to_the_readings_beside_it_across_gaps() {
        let times = [0.0, 1.0, 2.0, 10.0, 11.0];
        let shifts = |moment: f64| to_neighbours(&times, moment).collect::<Vec<f64>>();
        assert_eq!(shifts(2.0), [-1.0, 8.0]);
        assert_eq!(shifts(10.0 + 1e-9), [-8.0, 1.0]);
        assert_eq!((shifts(0.0), shifts(11.0)), (vec![1.0], vec![-1.0]));
        assert!(to_neighbours(&[], 1.0).next().is_none());
    }
}
