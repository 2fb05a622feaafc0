//! The minimum over base model, effects and columns together, in whitened space.

use estimate::gauss_newton::{Control, Damping, Descent, Directions, Minimum, Tolerance};
use estimate::screen::{Gain, Screen};
use faer::Mat;
use physics::{EffectInstance, Parameter};
use rayon::prelude::*;
use std::sync::Arc;

use crate::Error;
use crate::algebra::{columns, square};
use crate::channel::Channel;
use crate::model::{Model, State, amplitudes};
use crate::whitening::{NoiseModel, neighbours_std};

/// The iteration. It begins damped: where a field hardly changes, whole steps along directions that hardly
/// show turn sensors by radians, and end in a minimum that is none. The last step is one that lowers the sum
/// of squares by less than [`TOLERANCE`].
const ITERATION: Control = Control {
    most: 100,
    tolerance: 0.031_622_776_6,
    damping: Damping { first: 1e-4, least: LIGHTEST, from: LIGHTEST },
    raise: Tolerance { absolute: 0.0, relative: 0.0 },
    idle: Some(Tolerance { absolute: 1e-3, relative: 1e-9 }),
    keep: true,
    reach: None,
};
const LIGHTEST: f64 = 1e-10;
/// Most steps from a fit nearby. A few that need more are rivals on the way to shapes or turns far from any that are
/// plausible; they took most of the time.
const NEAR: usize = 40;
/// Rows whose products are taken at once.
const BLOCK: usize = 16_384;

/// What the noise is taken from need not stand at its minimum to a hundredth of its standard deviation.
const ROUGH: Control = Control { tolerance: 0.3, ..ITERATION };

#[derive(Clone, Debug)]
pub struct Fit {
    pub state: State,
    /// Residual, nT.
    pub residual: Vec<f64>,
    /// The same whitened, the rows of prior knowledge behind it.
    pub white: Vec<f64>,
    /// Whitened derivatives, with the same rows.
    pub jacobian: Arc<Mat<f64>>,
    /// Covariance of the unknowns if the noise is as told; infinite variances for what is not determined.
    pub covariance: Mat<f64>,
    /// What is beyond the readings' own errors in that: of forms, and by how much two ways to fit are apart.
    pub beyond: Mat<f64>,
    pub rank: usize,
    /// Σ of the squared whitened residuals.
    pub cost: f64,
}

/// Recordings, noise and how rows are left out.
#[derive(Debug)]
pub struct Fitter<'a, 'b> {
    pub model: &'b Model<'a>,
    pub noise: &'b NoiseModel,
}

impl Fitter<'_, '_> {
    /// Residual in nT, and whitened with the rows of prior knowledge.
    pub fn white(&self, state: &State) -> Result<(Vec<f64>, Vec<f64>), Error> {
        let residual = self.model.residual(state)?;
        let mut white = self.noise.whiten(&self.model.observed, &residual);
        white.extend(self.model.known(state).iter().map(|(_, value, std)| -value / std));
        Ok((residual, white))
    }

    /// Whitened derivatives by the unknowns of the base model at a state.
    fn base_jacobian(&self, state: &State) -> Result<Vec<Vec<f64>>, Error> {
        Ok(self.noise.whiten_all(&self.model.observed, &self.model.base_columns(state)?))
    }

    /// Whitened derivatives at a state with the rows of prior knowledge, those of the base model given.
    fn jacobian<'c>(&self, state: &State, base: impl Iterator<Item = &'c [f64]>) -> Result<Mat<f64>, Error> {
        let others = self.noise.whiten_all(&self.model.observed, &self.model.other_columns(state)?);
        let mut columns: Vec<&[f64]> = base.collect();
        columns.extend(others.iter().map(Vec::as_slice));
        let known = self.model.known(state);
        let rows = self.model.observed.rows;
        let mut jacobian = Mat::zeros(rows + known.len(), columns.len());
        for (j, column) in columns.iter().enumerate() {
            jacobian.col_as_slice_mut(j)[..rows].copy_from_slice(column);
        }
        known.iter().enumerate().for_each(|(prior, (j, _, std))| jacobian[(rows + prior, *j)] = 1.0 / std);
        Ok(jacobian)
    }

    /// A whitened series as if the noise were white, nT.
    pub fn in_nt(&self, white: &[f64]) -> Vec<f64> {
        let channels = self.model.observed.channels.iter().zip(&self.noise.std_nt);
        channels.flat_map(|(channel, std)| white[channel.range()].iter().map(move |w| w * std)).collect()
    }

    /// What a reading resolves, nT: the largest noise of a channel as it is declared; where it is not, as a
    /// fit's neighbouring residuals differ (by the median of the distances).
    pub fn resolution_nt(&self, fit: &Fit) -> f64 {
        if self.noise.known > 0.0 {
            return self.noise.std_nt.iter().copied().fold(0.0, f64::max);
        }
        let of = |channel: &Channel| neighbours_std(&fit.residual[channel.range()]);
        self.model.observed.channels.iter().map(of).fold(0.0, f64::max)
    }

    /// The minimum from a state, damped: along directions that hardly show a whole step goes too far.
    pub fn refine(&self, start: &State) -> Result<Fit, Error> {
        self.minimum(start, None, &ITERATION)
    }

    /// The minimum near another fit, whose derivatives by the unknowns of the base model serve to begin with
    /// (effects change them by no more than their own size). Not for effects that hide the field, which take
    /// rows out of them. Anywhere on the way where the sum of squares cannot come to some value.
    pub fn refine_near(&self, start: &State, fit: &Fit, reach: Option<f64>) -> Result<Fit, Error> {
        let damping = Damping { first: LIGHTEST, ..ITERATION.damping };
        let control = Control { damping, most: NEAR, reach, ..ITERATION };
        self.minimum(start, Some(&fit.jacobian), &control)
    }

    /// The minimum from a state. Most of the work is in the derivatives by the unknowns of the base model,
    /// which change little: they are those that are kept.
    fn minimum(&self, start: &State, kept: Option<&Mat<f64>>, control: &Control) -> Result<Fit, Error> {
        let at = At::of(self, start.clone())?;
        let begin = kept.map(|jacobian| self.linear_with(&at, self.base_of(jacobian))).transpose()?;
        let Minimum { at, linear, .. } = estimate::minimise(self, at, begin, control)?;
        self.with_covariance(at, linear.of)
    }

    fn base_of<'c>(&self, jacobian: &'c Mat<f64>) -> impl Iterator<Item = &'c [f64]> {
        let rows = self.model.observed.rows;
        columns(jacobian).take(self.model.unknowns.len()).map(move |column| &column[..rows])
    }

    fn linear_with<'c>(
        &self,
        at: &At,
        base: impl Iterator<Item = &'c [f64]>,
    ) -> Result<Directions<Mat<f64>>, Error> {
        Ok(Directions::of_products(self.jacobian(&at.state, base)?, &at.white)?)
    }

    /// A state as a fit that stands where it is.
    pub fn at(&self, state: &State) -> Result<Fit, Error> {
        let base = self.base_jacobian(state)?;
        let jacobian = self.jacobian(state, base.iter().map(Vec::as_slice))?;
        self.with_covariance(At::of(self, state.clone())?, jacobian)
    }

    fn with_covariance(&self, at: At, jacobian: Mat<f64>) -> Result<Fit, Error> {
        let At { state, residual, white, cost } = at;
        let all: Vec<usize> = (0..jacobian.ncols()).collect();
        let Gain { covariance, rank, .. } = self.screen(&jacobian, &[], &white).gain(&all)?;
        let beyond = Mat::zeros(all.len(), all.len());
        let jacobian = jacobian.into();
        Ok(Fit { state, residual, white, jacobian, covariance, beyond, rank, cost })
    }

    /// By how much the sum of squares of a fit falls with an effect as it stands, nothing fitted again.
    pub fn gain_as_it_is(&self, fit: &Fit, effect: &EffectInstance) -> Result<f64, Error> {
        let with = self.model.residual(&self.model.with(&fit.state, effect.clone()))?;
        let change: Vec<f64> = fit.residual.iter().zip(with).map(|(before, after)| before - after).collect();
        let white = self.noise.whiten(&self.model.observed, &change);
        let along: f64 = white.iter().zip(&fit.white).map(|(a, b)| a * b).sum();
        Ok(2.0 * along - square(&white))
    }

    /// What all of some columns (nT, stacked) gain together, a fit's own derivatives projected out.
    pub fn gain_of(&self, fit: &Fit, columns: &[Vec<f64>]) -> Result<Gain, Error> {
        let white = self.noise.whiten_all(&self.model.observed, columns);
        let base = fit.jacobian.ncols();
        let [own, group] = [0..base, base..base + columns.len()].map(Vec::from_iter);
        Ok(self.screen(&fit.jacobian, &white, &fit.white).given(&own)?.gain(&group)?)
    }

    /// An effect with its amplitudes fitted to what a fit has left, what that gains, and its rank.
    pub fn sized(&self, fit: &Fit, effect: &EffectInstance) -> Result<(EffectInstance, f64, usize), Error> {
        let with = self.model.with(&fit.state, effect.clone());
        let (number, amplitudes) = (with.effects.len() - 1, amplitudes(effect.kind));
        let parameters: Vec<Parameter> = amplitudes.iter().map(|k| Parameter::Effect(number, *k)).collect();
        let gain = self.gain_of(fit, &self.model.derivatives(&with, &parameters)?)?;
        let mut effect = effect.clone();
        for (at, value) in amplitudes.into_iter().zip(gain.coefficients) {
            effect.parameters[at] = value;
        }
        Ok((effect, gain.gain, gain.rank))
    }

    /// Whitened derivatives, further whitened columns, which prior knowledge does not touch, and residual:
    /// products by blocks of rows on all threads, without a copy of the whole.
    pub fn screen(&self, jacobian: &Mat<f64>, more: &[Vec<f64>], white: &[f64]) -> Screen {
        let width = jacobian.ncols() + more.len();
        let all = columns(jacobian).chain(more.iter().map(Vec::as_slice)).chain([white]);
        let all: Vec<&[f64]> = all.collect();
        let blocks: Vec<Mat<f64>> = (0..white.len())
            .into_par_iter()
            .step_by(BLOCK)
            .map(|from| {
                let to = white.len().min(from + BLOCK);
                let mut part = Mat::zeros(to - from, width + 1);
                for (j, column) in all.iter().enumerate() {
                    let there = &column[from.min(column.len())..to.min(column.len())];
                    part.col_as_slice_mut(j)[..there.len()].copy_from_slice(there);
                }
                estimate::gram(part.as_ref())
            })
            .collect();
        let total = blocks.iter().fold(Mat::zeros(width + 1, width + 1), |sum, block| sum + block);
        Screen::of(total.as_ref(), white.len())
    }
}

impl Fit {
    /// The same with a covariance on top of its own.
    pub fn widened(self, added: &Mat<f64>) -> Self {
        Self { covariance: &self.covariance + added, beyond: &self.beyond + added, ..self }
    }

    /// ln of the likelihood of its residual up to a constant, under the noise by which it is whitened: −½ (Σ
    /// of squares, whitened, and ln of the covariance's determinant).
    pub fn log_likelihood(&self, noise: &NoiseModel) -> f64 {
        -0.5 * (square(&self.white[..self.residual.len()]) + noise.log_determinant())
    }
}

/// A state with its residual, as it is and whitened, and the sum of squares.
pub struct At {
    state: State,
    residual: Vec<f64>,
    white: Vec<f64>,
    cost: f64,
}

impl At {
    fn of(fitter: &Fitter<'_, '_>, state: State) -> Result<Self, Error> {
        let (residual, white) = fitter.white(&state)?;
        let cost = square(&white);
        Ok(Self { state, residual, white, cost })
    }
}

impl Descent for Fitter<'_, '_> {
    type Point = At;
    type Linear = Directions<Mat<f64>>;
    type Error = Error;

    fn cost(&self, at: &At) -> f64 {
        at.cost
    }

    fn linear(&self, at: &At, kept: Option<&Self::Linear>) -> Result<Self::Linear, Error> {
        match kept {
            Some(kept) => self.linear_with(at, self.base_of(&kept.of)),
            None => self.linear_with(at, self.base_jacobian(&at.state)?.iter().map(Vec::as_slice)),
        }
    }

    fn moved(&self, at: &At, step: &[f64]) -> Result<At, Error> {
        At::of(self, self.model.advance(&at.state, step))
    }
}

/// Most times that white noise is estimated anew.
const ESTIMATES: usize = 8;
/// Change of its variance below which it is as it was.
const ESTIMATED: f64 = 0.02;

/// The fit and the noise it rests on: where the noise is not declared, both in turn, from a fit that takes it
/// as white. (Of the residual of a calibration that is far off, most would pass for slow noise.)
pub fn settled(model: &Model<'_>, start: &State, is_near: bool) -> Result<(Fit, NoiseModel), Error> {
    let residual = model.residual(start)?;
    let first = NoiseModel::of(&model.observed, start, &residual)?;
    let first_damping = if is_near { LIGHTEST } else { ITERATION.damping.first };
    let damping = Damping { first: first_damping, ..ITERATION.damping };
    let fit = Fitter { model, noise: &first }.minimum(start, None, &Control { damping, ..ITERATION })?;
    if first.known > 0.0 {
        return Ok((fit, first));
    }
    let (fit, _) = estimated(model, (fit, first))?;
    let noise = restricted(model, &fit.state, &fit.residual)?;
    Ok((Fitter { model, noise: &noise }.refine(&fit.state)?, noise))
}

/// Noise with memory of a residual beside all that a state has unknown.
pub fn restricted(model: &Model<'_>, state: &State, residual: &[f64]) -> Result<NoiseModel, Error> {
    let columns = [model.base_columns(state)?, model.other_columns(state)?].concat();
    NoiseModel::restricted(&model.observed, &columns, residual)
}

/// The fit by least squares: under white noise of the size that it leaves.
pub fn settled_white(model: &Model<'_>, start: &State) -> Result<(Fit, NoiseModel), Error> {
    let residual = model.residual(start)?;
    let first = NoiseModel::estimated(&model.observed, &residual)?;
    let fit = Fitter { model, noise: &first }.refine(start)?;
    let (fit, noise) = estimated(model, (fit, first))?;
    Ok((Fitter { model, noise: &noise }.refine(&fit.state)?, noise))
}

/// A rough fit and its white noise, estimated anew in turn until its size stays.
fn estimated(model: &Model<'_>, (mut fit, mut noise): (Fit, NoiseModel)) -> Result<(Fit, NoiseModel), Error> {
    for _ in 0..ESTIMATES {
        let before = noise.variance();
        noise = NoiseModel::estimated(&model.observed, &fit.residual)?;
        fit = Fitter { model, noise: &noise }.minimum(&fit.state, None, &ROUGH)?;
        if (noise.variance() / before - 1.0).abs() < ESTIMATED {
            break;
        }
    }
    Ok((fit, noise))
}
