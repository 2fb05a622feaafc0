//! How large each cause is, with its uncertainty over all forms of noise.

use common::Quantity;
use estimate::mixture::{Component, Mixture};
use faer::Mat;

use crate::fit::Fit;
use crate::form::Form;
use crate::noises::{self, Filter};
use crate::problem::{Cause, Problem, Term};
use crate::stack::{Candidate, Product, Stack, products};
use crate::sweep::Sweep;

/// Half the change of ln τ over which the derivative with respect to it is taken.
const APART: f64 = 0.02;
/// A form of noise of a smaller probability than this changes no digit.
const LEAST: f64 = 1e-6;

/// A cause and what it does to each channel.
#[derive(Clone, Debug)]
pub struct Amplitude {
    /// What acts.
    pub cause: Cause,
    /// In which form, a relaxation with its best time constant.
    pub form: Form,
    /// For each channel, those of its columns; one for all of a clock.
    pub channels: Vec<Vec<Quantity>>,
    /// The time constant, s.
    pub late_s: Option<Quantity>,
    /// Of amplitudes that should be one: the share of what they explain that one explains.
    pub alike: Option<f64>,
}

impl Amplitude {
    /// Those of the first channel.
    pub fn first(&self) -> Vec<Quantity> {
        self.channels.first().cloned().unwrap_or_default()
    }
}

/// All channels with the causes of a set.
pub struct Fitted {
    pub amplitudes: Vec<Amplitude>,
    /// The coefficient of each of the base's columns in each channel, with its standard uncertainty; the level
    /// follows them.
    pub base: Vec<Vec<(f64, f64)>>,
    /// What plain least squares leave: on the base alone, and on all columns.
    pub before: Vec<Vec<f64>>,
    pub after: Vec<Vec<f64>>,
    pub contributions: Vec<Vec<Vec<f64>>>,
    pub noise: Vec<noises::Form>,
    /// The columns of the fit that are independent, for each channel.
    columns: Vec<Vec<usize>>,
    /// Columns of the derivative of each relaxed cause with respect to ln τ.
    slopes: Vec<Option<Vec<usize>>>,
    stack: Stack,
}

impl Fitted {
    /// The columns of a channel's fit that are independent, and what is known of each besides.
    pub fn columns_of(&self, channel: usize) -> (Vec<&[f64]>, Vec<f64>) {
        let known = |column: usize| {
            self.stack.known.iter().find(|(place, _)| *place == column).map_or(0.0, |of| of.1)
        };
        let places = self.places_of(channel).into_iter();
        places.map(|column| (self.stack.columns[column].as_slice(), known(column))).unzip()
    }

    /// The places of these columns that are left without a cause; of all for `None`.
    pub fn without(&self, channel: usize, cause: Option<usize>) -> Vec<usize> {
        let out = cause.map_or(&[][..], |number| &self.stack.candidates[number].columns[channel]);
        let places = self.places_of(channel).into_iter().enumerate();
        places.filter(|(_, column)| !out.contains(column)).map(|(place, _)| place).collect()
    }

    /// A time constant is held: its derivative would follow what is left far from the rows that show it.
    fn places_of(&self, channel: usize) -> Vec<usize> {
        let slope = |column: &usize| self.slopes.iter().flatten().flatten().any(|slope| slope == column);
        self.columns[channel].iter().filter(|column| !slope(column)).copied().collect()
    }
}

/// Fits some causes in their forms to all channels.
pub fn fit(problem: &Problem, named: &[(Cause, Form)], noises: &[Filter]) -> Fitted {
    let mut stack = Stack::of(problem, named);
    let slopes = slopes(problem, &mut stack, named);
    let made = products(&stack, noises);
    let channels = || 0..stack.y.len();
    let columns: Vec<Vec<usize>> = channels()
        .map(|channel| {
            let own = stack.candidates.iter().flat_map(|one| one.columns[channel].clone());
            let slopes = slopes.iter().flatten().flatten().copied();
            stack.base.iter().copied().chain(own).chain(slopes).collect()
        })
        .collect();
    let sweep = |channel: usize| {
        let own = &columns[channel][stack.base.len()..];
        Sweep::of(&made, &stack, channel, &stack.base, own)
    };
    let sweeps: Vec<Sweep<'_>> = channels().map(sweep).collect();
    let mixture = |channel: usize| {
        let freedom = (problem.rows() as f64 - columns[channel].len() as f64).max(1.0);
        let heavy = made.iter().zip(sweeps[channel].weights()).filter(|(_, weight)| *weight > LEAST);
        let component = |(product, weight): (&Product, f64)| {
            let (coefficients, covariance) =
                coefficients(&stack, product, channel, &columns[channel], freedom);
            Component { log_weight: weight.ln(), coefficients, covariance }
        };
        Mixture::of(heavy.map(component).collect(), freedom)
    };
    let mixtures: Vec<Mixture> = channels().map(mixture).collect();
    let best: Vec<usize> = sweeps.iter().map(Sweep::best).collect();
    let fit = |channel: usize| Fit::of(&made[best[channel]].gram, stack.y[channel], &columns[channel]);
    let fits: Vec<Fit> = channels().map(fit).collect();
    let plain = |channel: usize, columns: &[usize]| -> Vec<f64> {
        let y = stack.y[channel];
        let rest = Fit::of(&made[0].gram, y, columns).rest(&stack.columns, &stack.columns[y]);
        rest.into_iter().map(|value| value * stack.scale[y]).collect()
    };
    let contribution = |candidate: &Candidate, channel: usize| {
        let mut sum = vec![0.0; problem.rows()];
        for column in &candidate.columns[channel] {
            let size = fits[channel].coefficient(*column) * stack.scale[stack.y[channel]];
            sum.iter_mut().zip(&stack.columns[*column]).for_each(|(sum, value)| *sum += size * value);
        }
        sum
    };
    let quantity = |channel: usize, column: usize| {
        let at = columns[channel].iter().position(|known| *known == column).expect("a column of the fit");
        let scale = stack.scale[stack.y[channel]] / stack.scale[column];
        let (value, variance) = (mixtures[channel].coefficients()[at], mixtures[channel].covered(at, at));
        (value * scale, variance.max(0.0).sqrt() * scale.abs())
    };
    let quantities =
        |all: &[(f64, f64)]| all.iter().map(|(value, std)| Quantity::new(*value, *std)).collect();
    let amplitude = |number: usize| {
        let ((cause, form), candidate) = (named[number], &stack.candidates[number]);
        let of_channel = |channel: usize| -> Vec<(f64, f64)> {
            candidate.columns[channel].iter().map(|column| quantity(channel, *column)).collect()
        };
        let each: Vec<Vec<(f64, f64)>> = channels().map(of_channel).collect();
        let late_s = slopes[number].as_ref().map(|slope| {
            let ratios = channels().flat_map(|channel| {
                slope.iter().zip(&each[channel]).map(move |(column, size)| (channel, *column, *size))
            });
            let parts = ratios.map(|(channel, column, (size, _))| {
                let (slope, std) = quantity(channel, column);
                (slope / size, std / size.abs())
            });
            let (by, std) = mean(parts).0;
            let late_s = form.late_s * by.clamp(-0.5, 0.5).exp();
            Quantity::new(late_s, late_s * std)
        });
        let (channels, alike) = if candidate.tied {
            let columns = candidate.columns.iter().map(Vec::len).max().unwrap_or(0);
            let of_column = |column: usize| each.iter().filter_map(move |of| of.get(column).copied());
            let (means, parts): (Vec<(f64, f64)>, Vec<[f64; 2]>) =
                (0..columns).map(|column| mean(of_column(column))).unzip();
            let [one, other] = [0, 1].map(|part| parts.iter().map(|parts| parts[part]).sum::<f64>());
            (vec![quantities(&means)], Some(one / (one + other)))
        } else {
            (each.iter().map(|of| quantities(of)).collect(), None)
        };
        Amplitude { cause, form, channels, late_s, alike }
    };
    let amplitudes = (0..named.len()).map(amplitude).collect();
    let base_of = |channel: usize| stack.base.iter().map(|column| quantity(channel, *column)).collect();
    let contributions_of =
        |candidate: &Candidate| channels().map(|channel| contribution(candidate, channel)).collect();
    Fitted {
        amplitudes,
        base: channels().map(base_of).collect(),
        before: channels().map(|channel| plain(channel, &stack.plain)).collect(),
        after: channels().map(|channel| plain(channel, &columns[channel])).collect(),
        contributions: stack.candidates.iter().map(contributions_of).collect(),
        noise: best.iter().map(|best| noises[*best].form.clone()).collect(),
        columns: fits.into_iter().map(|fit| fit.columns).collect(),
        slopes,
        stack,
    }
}

/// Columns of the derivative of each relaxed cause with respect to ln τ.
fn slopes(problem: &Problem, stack: &mut Stack, named: &[(Cause, Form)]) -> Vec<Option<Vec<usize>>> {
    let mut of = |(cause, form): &(Cause, Form)| {
        if form.late_s == 0.0 {
            return None;
        }
        let moved = |by: f64| problem.terms(*cause, &Form { late_s: form.late_s * by.exp(), ..*form });
        let pairs = moved(APART).into_iter().zip(moved(-APART));
        let columns = pairs.filter_map(|pair| match pair {
            (Term::Alike(later), Term::Alike(earlier)) => {
                let slope = later.iter().zip(&earlier).map(|(a, b)| (a - b) / (2.0 * APART)).collect();
                Some(stack.push(slope))
            }
            _ => None,
        });
        Some(columns.collect())
    };
    named.iter().map(&mut of).collect()
}

/// Coefficients of all columns of a channel, and their covariance; nothing is known of one that follows from
/// others.
fn coefficients(
    stack: &Stack,
    product: &Product,
    channel: usize,
    columns: &[usize],
    freedom: f64,
) -> (Vec<f64>, Mat<f64>) {
    let fit = Fit::of(&product.gram, stack.y[channel], columns);
    let variance = fit.left / freedom;
    let places: Vec<Option<usize>> = columns.iter().map(|column| fit.place(*column)).collect();
    let covariance = Mat::from_fn(columns.len(), columns.len(), |i, j| match (places[i], places[j]) {
        (Some(a), Some(b)) => variance * fit.inverse[(a, b)],
        _ => 0.0,
    });
    (columns.iter().map(|column| fit.coefficient(*column)).collect(), covariance)
}

/// The mean of values by their uncertainties and its own; what it explains, and what it does not, of their squares over
/// those of their uncertainties.
fn mean(of: impl Iterator<Item = (f64, f64)>) -> ((f64, f64), [f64; 2]) {
    let known: Vec<(f64, f64)> = of.filter(|(value, std)| value.is_finite() && *std > 0.0).collect();
    let weight: f64 = known.iter().map(|(_, std)| std.powi(-2)).sum();
    let mean = known.iter().map(|(value, std)| value * std.powi(-2)).sum::<f64>() / weight;
    let chi: f64 = known.iter().map(|(value, std)| ((value - mean) / std).powi(2)).sum();
    let freedom = known.len() as f64 - 1.0;
    // Values that differ by more than their uncertainties say how uncertain they are (Birge 1932).
    let wider = if freedom < 1.0 { 1.0 } else { (chi / freedom).max(1.0).sqrt() };
    ((mean, wider * weight.sqrt().recip()), [mean * mean * weight, chi])
}
