//! How large each cause is, with its uncertainty over all forms of noise.

use common::Quantity;
use estimate::mixture::{Component, Mixture};
use faer::Mat;

use crate::fit::Fit;
use crate::form::Form;
use crate::noises::{self, Filter};
use crate::problem::{Cause, Problem, Term};
use crate::products::{Product, products};
use crate::stack::Stack;
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
    /// The causes.
    pub amplitudes: Vec<Amplitude>,
    /// The coefficient of each of the base's columns in each channel, with its standard uncertainty; the level
    /// follows them.
    pub base: Vec<Vec<(f64, f64)>>,
    /// What is left of each channel under its most probable form of noise.
    pub residual: Vec<Vec<f64>>,
    /// What plain least squares leave: on the base alone, and on all columns.
    pub before: Vec<Vec<f64>>,
    pub after: Vec<Vec<f64>>,
    /// What each cause contributes to each channel.
    pub contributions: Vec<Vec<Vec<f64>>>,
    /// The most probable form of noise of each channel.
    pub noise: Vec<noises::Form>,
    /// Variance of the whitened residual under it.
    pub variance: Vec<f64>,
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
    let derivatives = slopes(problem, &mut stack, named);
    let made = products(&stack, noises);
    let columns: Vec<Vec<usize>> = (0..stack.y.len())
        .map(|channel| {
            let own = stack.candidates.iter().flat_map(|one| one.columns[channel].clone());
            let slopes = derivatives.iter().flatten().flatten().copied();
            stack.base.iter().copied().chain(own).chain(slopes).collect()
        })
        .collect();
    let mixtures: Vec<Mixture> = (0..stack.y.len())
        .map(|channel| {
            let own: Vec<usize> = columns[channel][stack.base.len()..].to_vec();
            let weights = Sweep::of(&made, problem.rows(), stack.y[channel], &stack.base, &own).weights();
            let freedom = problem.rows() as f64 - columns[channel].len() as f64;
            let of = |product: &Product| coefficients(&stack, product, channel, &columns[channel], freedom);
            let heavy = made.iter().zip(&weights).filter(|(_, weight)| **weight > LEAST);
            Mixture::of(
                heavy
                    .map(|(product, weight)| {
                        let (coefficients, covariance) = of(product);
                        Component { log_weight: weight.ln(), coefficients, covariance }
                    })
                    .collect(),
                freedom.max(1.0),
            )
        })
        .collect();
    let mut fitted = Fitted {
        amplitudes: Vec::new(),
        base: Vec::new(),
        residual: Vec::new(),
        before: Vec::new(),
        after: Vec::new(),
        contributions: vec![Vec::new(); named.len()],
        noise: Vec::new(),
        variance: Vec::new(),
        columns: Vec::new(),
        slopes: derivatives.clone(),
        stack,
    };
    let stack = &fitted.stack;
    for (channel, columns) in columns.iter().enumerate() {
        let y = stack.y[channel];
        let own: Vec<usize> = columns[stack.base.len()..].to_vec();
        let best = Sweep::of(&made, problem.rows(), y, &stack.base, &own).best();
        let fit = Fit::of(&made[best].gram, y, columns);
        let scaled = |series: Vec<f64>| -> Vec<f64> { series.iter().map(|v| v * stack.scale[y]).collect() };
        fitted.residual.push(scaled(fit.rest(&stack.columns, &stack.columns[y])));
        let plain = |columns: &[usize]| {
            scaled(Fit::of(&made[0].gram, y, columns).rest(&stack.columns, &stack.columns[y]))
        };
        fitted.before.push(plain(&stack.plain));
        fitted.after.push(plain(columns));
        for (of, candidate) in fitted.contributions.iter_mut().zip(&stack.candidates) {
            let mut sum = vec![0.0; problem.rows()];
            for column in &candidate.columns[channel] {
                let size = fit.coefficient(*column) * stack.scale[y];
                sum.iter_mut().zip(&stack.columns[*column]).for_each(|(sum, value)| *sum += size * value);
            }
            of.push(sum);
        }
        fitted.noise.push(noises[best].form.clone());
        let freedom = (problem.rows() as f64 - columns.len() as f64).max(1.0);
        fitted.variance.push(fit.left / freedom * stack.scale[y] * stack.scale[y]);
        fitted.columns.push(fit.columns);
    }
    let place = |channel: usize, column: usize| {
        columns[channel].iter().position(|known| *known == column).expect("a column of the fit")
    };
    let quantity = |channel: usize, column: usize| {
        let at = place(channel, column);
        let scale = stack.scale[stack.y[channel]] / stack.scale[column];
        let (value, variance) = (mixtures[channel].coefficients()[at], mixtures[channel].covered(at, at));
        (value * scale, variance.max(0.0).sqrt() * scale.abs())
    };
    fitted.base = (0..stack.y.len())
        .map(|channel| stack.base.iter().map(|column| quantity(channel, *column)).collect())
        .collect();
    for (number, ((cause, form), candidate)) in named.iter().zip(&stack.candidates).enumerate() {
        let of_channel = |channel: usize| -> Vec<(f64, f64)> {
            candidate.columns[channel].iter().map(|column| quantity(channel, *column)).collect()
        };
        let each: Vec<Vec<(f64, f64)>> = (0..stack.y.len()).map(of_channel).collect();
        let late_s = derivatives[number].as_ref().map(|slope| {
            let ratios = (0..stack.y.len()).flat_map(|channel| {
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
        let quantities =
            |all: &[(f64, f64)]| all.iter().map(|(value, std)| Quantity::new(*value, *std)).collect();
        let (channels, alike) = if candidate.tied {
            let columns = candidate.columns.iter().map(Vec::len).max().unwrap_or(0);
            let of_column = |column: usize| each.iter().filter_map(move |of| of.get(column).copied());
            let means: Vec<((f64, f64), [f64; 2])> =
                (0..columns).map(|column| mean(of_column(column))).collect();
            let [one, other] = [0, 1].map(|part| means.iter().map(|(_, parts)| parts[part]).sum::<f64>());
            let alike = one / (one + other);
            (vec![quantities(&means.iter().map(|(mean, _)| *mean).collect::<Vec<_>>())], Some(alike))
        } else {
            (each.iter().map(|of| quantities(of)).collect(), None)
        };
        fitted.amplitudes.push(Amplitude { cause: *cause, form: *form, channels, late_s, alike });
    }
    fitted
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
    let variance = fit.left / freedom.max(1.0);
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
