//! A slow change of the difference: a straight drift, or noise with memory and no drift.

use common::{DriftExplanations, Quantity};
use estimate::stats;

use super::joint::LEVEL;

/// Coefficients of the cosine transform that tell the two apart, from the lowest on.
const COEFFICIENTS: usize = 64;
/// The weight above which a drift is taken for one.
const SURE: f64 = 1.0 - LEVEL;
/// Fewer say nothing.
const LEAST: usize = 16;
/// Densities of the noise: A [(k² + q²)^(−α/2) + w], k the number of the coefficient. Exponents α, …
const EXPONENTS: usize = 13;
const EXPONENT_STEP: f64 = 0.25;
/// … coefficients q below which the noise levels off, none of them at 0, …
const LEVELS_OFF: [f64; 5] = [0.0, 2.0, 4.0, 8.0, 16.0];
/// … white noise w over the other at the last coefficient, …
const WHITE: [f64; 5] = [0.0, 1.0, 10.0, 100.0, 1000.0];
/// … and A around its likeliest value: so many values on both sides, a factor apart.
const SIZES: i32 = 12;
const SIZE_FACTOR: f64 = 1.3;

/// What is known of a straight drift beside noise of many forms.
pub struct Explanations {
    /// Weight of a drift; the rest is that of noise alone.
    pub drift: f64,
    /// The drift, if it is one, nT/day.
    pub straight_nt_per_day: Quantity,
    /// Variances of the coefficients of the noise beside a drift, from the first on, in the mean over all
    /// forms.
    pub beside_drift: Vec<f64>,
    /// α of noise alone.
    pub exponent_alone: Quantity,
}

/// The sums of one explanation over the forms of noise.
#[derive(Default)]
struct Sum {
    /// ln of the greatest likelihood so far, by which all others are divided.
    greatest: f64,
    weight: f64,
    first: f64,
    second: f64,
    variances: Vec<f64>,
}

impl Sum {
    fn add(&mut self, ln_likelihood: f64, (value, variance): (f64, f64), shape: &[f64], size: f64) {
        if self.weight == 0.0 || ln_likelihood > self.greatest {
            let less = if self.weight == 0.0 { 0.0 } else { (self.greatest - ln_likelihood).exp() };
            for sum in
                [&mut self.weight, &mut self.first, &mut self.second].into_iter().chain(&mut self.variances)
            {
                *sum *= less;
            }
            self.greatest = ln_likelihood;
        }
        let weight = (ln_likelihood - self.greatest).exp();
        self.weight += weight;
        self.first += weight * value;
        self.second += weight * (value * value + variance);
        self.variances.resize(shape.len(), 0.0);
        self.variances.iter_mut().zip(shape).for_each(|(sum, shape)| *sum += weight * size * shape);
    }

    /// Mean and standard deviation.
    fn quantity(&self) -> Quantity {
        let mean = self.first / self.weight;
        Quantity::new(mean, (self.second / self.weight - mean * mean).max(0.0).sqrt())
    }
}

/// Weighs the explanations of what a matrix leaves, `left`, by the marginal likelihood of its lowest
/// coefficients; `days` are those of a straight line. None where there are too few.
///
/// Both are as probable before. Noise that levels off is together as probable as noise that does not; else
/// all forms are alike, with and without a drift. A drift has a normal prior about zero, so wide that its
/// standard deviation explains all scatter, √12 rms over the length. So neither explanation is preferred for
/// its freedom: noise that wanders as far has to be seen at shorter periods too.
///
/// Source: R. E. Kass and A. E. Raftery, Bayes factors, J. Am. Stat. Assoc. 90 (1995) 773–795.
pub fn explanations(left: &[f64], days: &[f64], (rms, length_days): (f64, f64)) -> Option<Explanations> {
    let count = COEFFICIENTS.min(left.len() / 4);
    if count < LEAST || rms.is_nan() || rms <= 0.0 {
        return None;
    }
    let (left, days) = (&left[..count], &days[..count]);
    let prior = 12.0 * (rms / length_days).powi(2);
    let (mut alone, mut drift) = (Sum::default(), Sum::default());
    for Shape { exponent, ln_prior, variances: shape } in shapes(count) {
        let weighted = |a: &[f64], b: &[f64]| -> f64 { (0..count).map(|k| a[k] * b[k] / shape[k]).sum() };
        let logarithms: f64 = shape.iter().map(|shape| shape.ln()).sum();
        let (squares, information, along) =
            (weighted(left, left), weighted(days, days), weighted(days, left));
        let rest = (squares - along * along / information).max(f64::EPSILON * squares);
        let without = |size: f64| ln_prior - 0.5 * (logarithms + count as f64 * size.ln() + squares / size);
        for size in sizes(squares / count as f64) {
            alone.add(without(size), (exponent, 0.0), &shape, size);
        }
        for size in sizes(rest / count as f64) {
            let precision = information / size + prior.recip();
            let gain = (along / size).powi(2) / precision - (1.0 + prior * information / size).ln();
            drift.add(
                without(size) + 0.5 * gain,
                (along / size / precision, precision.recip()),
                &shape,
                size,
            );
        }
    }
    let ratio = (alone.greatest - drift.greatest).exp() * alone.weight / drift.weight;
    Some(Explanations {
        drift: 1.0 / (1.0 + ratio),
        straight_nt_per_day: drift.quantity(),
        beside_drift: drift.variances.iter().map(|sum| sum / drift.weight).collect(),
        exponent_alone: alone.quantity(),
    })
}

/// A form of noise.
struct Shape {
    /// α.
    exponent: f64,
    ln_prior: f64,
    /// Of each coefficient, for A = 1.
    variances: Vec<f64>,
}

/// All forms of noise in so many coefficients.
fn shapes(count: usize) -> impl Iterator<Item = Shape> {
    let of = move |exponent: f64, off: f64, white: f64| {
        let flicker = |k: f64| (k * k + off * off).powf(-0.5 * exponent);
        let white = white * flicker(count as f64);
        let share = if off == 0.0 { 1.0 } else { 1.0 / (LEVELS_OFF.len() - 1) as f64 };
        let variances = (1..=count).map(|k| flicker(k as f64) + white).collect();
        Shape { exponent, ln_prior: share.ln(), variances }
    };
    (0..EXPONENTS).flat_map(move |step| {
        let exponent = step as f64 * EXPONENT_STEP;
        LEVELS_OFF
            .into_iter()
            .flat_map(move |off| WHITE.into_iter().map(move |white| of(exponent, off, white)))
    })
}

/// Sizes around the likeliest.
fn sizes(likeliest: f64) -> impl Iterator<Item = f64> {
    (-SIZES..=SIZES).map(move |step| likeliest * SIZE_FACTOR.powi(step))
}

impl Explanations {
    /// Probability of a slope as great by chance, over all forms of noise, nT/day.
    pub fn p_of(&self, slope: f64) -> f64 {
        stats::two_sided_p(slope / self.straight_nt_per_day.std().unwrap_or(f64::INFINITY), f64::INFINITY)
    }

    /// Whether a slope that was fitted is a drift, by the weight of a drift and by its size.
    pub fn is_drift(&self, slope: f64) -> bool {
        self.drift >= SURE && self.p_of(slope) < LEVEL
    }

    /// As a document has it.
    pub fn document(&self) -> DriftExplanations {
        DriftExplanations {
            drift: self.drift,
            noise_alone: 1.0 - self.drift,
            straight_nt_per_day: self.straight_nt_per_day.clone(),
            exponent_alone: self.exponent_alone.clone(),
            ..DriftExplanations::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use noise::Stream;

    const DAYS: f64 = 10.0;

    /// Coefficients of a straight line of one unit a day over ten days in 4000 rows: odd ones alone.
    fn line() -> Vec<f64> {
        let scale = -DAYS * (4000.0_f64 * 8.0).sqrt() / std::f64::consts::PI.powi(2);
        (1..=400).map(|k| if k % 2 == 1 { scale / (k * k) as f64 } else { 0.0 }).collect()
    }

    /// Weights of a drift in noise of density k^−α of which coefficient 64 has one.
    fn weights(exponent: f64, slope: f64) -> Vec<Explanations> {
        let days = line();
        let of = |seed: u64| {
            let mut stream = Stream::new(seed, "explanations");
            let left: Vec<f64> = (1..=400)
                .map(|k| (k as f64 / 64.0).powf(-0.5 * exponent) * stream.normal() + slope * days[k - 1])
                .collect();
            let rms = (left.iter().map(|c| c * c).sum::<f64>() / 4000.0).sqrt();
            explanations(&left, &days, (rms, DAYS)).expect("enough")
        };
        (0..200).map(of).collect()
    }

    #[test]
    fn noise_alone_is_seldom_taken_for_a_drift() {
        for exponent in [0.0, 1.0, 1.5, 2.0] {
            let sure = weights(exponent, 0.0).iter().filter(|found| found.drift > SURE).count();
            println!("1/f^{exponent}: {sure} of 200 drifts");
            assert!(sure <= 10, "{exponent}: {sure}");
        }
    }

    #[test]
    fn a_drift_is_seen_in_noise_that_does_not_wander_as_far() {
        for exponent in [0.0, 1.0] {
            let found = weights(exponent, 1.5);
            let sure = found.iter().filter(|found| found.drift > SURE).count();
            let within = |of: &Explanations| {
                let std = of.straight_nt_per_day.std().expect("a std");
                (of.straight_nt_per_day.value() - 1.5).abs() < 1.96 * std
            };
            let held = found.iter().filter(|found| within(found)).count();
            println!("1/f^{exponent}: {sure} of 200 seen, {held} within the 95 % interval");
            assert!(sure > 180 && testkit::agrees(held, 200, [0.92, 0.98], 2), "{exponent}: {sure}, {held}");
        }
    }
}
