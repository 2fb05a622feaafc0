//! Readings predicted from a fit to the others.

use estimate::screen::left_out;
use faer::Mat;
use physics::Kind;

use crate::Error;
use crate::fit::{Fit, Fitter};
use crate::model::State;

/// Parts of the readings that are left out in turn.
pub const FOLDS: usize = 6;
/// Pieces that a long channel is cut into, dealt out to the parts.
const PIECES: usize = 24;
/// Rows so many durations to either side of a vehicle's pass are not left out.
const PASS: f64 = 4.0;

/// What readings left out of a fit show.
#[derive(Clone, Debug)]
pub struct HeldOut {
    /// Σ of the squared whitened residuals of each part.
    pub parts: Vec<f64>,
    /// The squared whitened residual of each row; None where it is never left out.
    pub squares: Vec<Option<f64>>,
}

impl Fitter<'_, '_> {
    /// The part in which each whitened row is left out. What is known beforehand is never left out, nor are
    /// rows of a single moment that the state explains by themselves, nor the first row of noise with memory,
    /// which has its level: without them nothing is known of it.
    fn folds(&self, state: &State, rows: usize) -> Vec<usize> {
        let mut folds = vec![FOLDS; rows];
        let observed = &self.model.observed;
        for (at, channel) in observed.channels.iter().enumerate() {
            let length = channel.rows.len();
            for (number, row) in channel.range().enumerate() {
                folds[row] = match (length >= PIECES, observed.runs.len() >= FOLDS) {
                    (true, _) => number * PIECES / length % FOLDS,
                    (false, true) => channel.run % FOLDS,
                    (false, false) => number % FOLDS,
                };
            }
            if self.noise.remembers(at) {
                folds[channel.at] = FOLDS;
            }
            let run = &observed.runs[channel.run];
            for effect in &state.effects {
                let [from, to] = match (effect.kind, &effect.parameters[..]) {
                    (Kind::Spike, [.., time_s]) => [*time_s; 2],
                    (Kind::Dropout, [time_s, duration_s]) => [*time_s, time_s + duration_s],
                    (Kind::VehiclePass, [.., time_s, duration_s]) => {
                        [time_s - PASS * duration_s, time_s + PASS * duration_s]
                    }
                    _ => continue,
                };
                let elsewhere = effect.recording.as_ref().is_some_and(|only| *only != run.recording.id);
                let Some(time) = run.time_s.filter(|_| !elsewhere) else { continue };
                for (row, at) in channel.range().zip(&channel.rows) {
                    if (from..=to).contains(&time[*at]) {
                        folds[row] = FOLDS;
                    }
                }
            }
        }
        for single in &state.singles {
            folds[single.row] = FOLDS;
        }
        folds
    }

    /// The squared whitened residuals of each part, predicted from the others, at a fit's minimum.
    pub fn held_out(&self, fit: &Fit) -> Result<HeldOut, Error> {
        let folds = self.folds(&fit.state, fit.white.len());
        let width = fit.jacobian.ncols();
        let block = |fold: usize| {
            let rows: Vec<usize> = (0..fit.white.len()).filter(|row| folds[*row] == fold).collect();
            let block = Mat::from_fn(rows.len(), width + 1, |i, j| {
                if j < width { fit.jacobian[(rows[i], j)] } else { fit.white[rows[i]] }
            });
            estimate::gram(block.as_ref())
        };
        let blocks: Vec<Mat<f64>> = (0..=FOLDS).map(block).collect();
        let without = left_out(&blocks, &(0..width).collect::<Vec<_>>())?;
        let mut parts = vec![0.0; FOLDS];
        let squares = folds.iter().enumerate().map(|(row, fold)| {
            let part = parts.get_mut(*fold)?;
            let fitted: f64 =
                without[*fold].iter().enumerate().map(|(j, a)| a * fit.jacobian[(row, j)]).sum();
            let square = (fit.white[row] - fitted).powi(2);
            *part += square;
            Some(square)
        });
        let squares = squares.collect();
        Ok(HeldOut { parts, squares })
    }
}
