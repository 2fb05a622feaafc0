//! How offsets wander from date to date, which nobody knows beforehand: every size of it, by its probability.

use estimate::mixture::{Component, Mixture};
use estimate::wander::Wander;
use faer::{Mat, MatRef};

use crate::allowed::{Memory, undetermined};
use crate::{Error, Result};

/// Probabilities beforehand that what has memory is flicker noise or a random walk. A walk makes the widest
/// intervals, and a year shows little of it: so intervals hold under either.
const FORMS: [(&str, f64); 2] = [("flicker", 0.1), ("random_walk", 0.9)];
/// Probability beforehand that the dates' own errors are as stated. The rest is spread over octaves of a
/// factor of their variance: what else differs from date to date without memory.
const AS_STATED: f64 = 0.8;
const LARGER_OCTAVES: i32 = 10;
/// Octaves of the variance of what has memory over that of a date's own error.
const WANDER_OCTAVES: [i32; 2] = [-4, 14];

/// What offsets follow, under every noise that is allowed for.
pub struct Wandering {
    /// Under all, averaged.
    pub all: Mixture,
    /// Under white noise, flicker noise and a random walk, each alone.
    pub alone: Vec<(&'static str, Mixture)>,
    /// Probability of flicker noise and of a random walk.
    pub weights: Vec<(&'static str, f64)>,
    /// Probability of a random walk with less variance than the dates' own errors, if there is one.
    pub unseen: f64,
    /// Its 95 % upper bound.
    pub walk_below_nt_per_sqrt_s: f64,
}

impl Wandering {
    /// y = X β with own variances `own` at times `time_s`; `shared` is the common covariance of β.
    ///
    /// The covariances are s D + q K, D the own variances, K of flicker noise or of a random walk. q has the
    /// reference prior of the restricted likelihood at s = 1, alike for both; s is 1 or octaves more.
    pub fn of(
        design: MatRef<'_, f64>,
        y: &[f64],
        own: &[f64],
        time_s: &[f64],
        shared: &Mat<f64>,
    ) -> Result<Self> {
        let count = y.len();
        let mean = own.iter().sum::<f64>() / count as f64;
        let largest = y.iter().map(|value| value.abs()).fold(0.0, f64::max);
        if mean <= 1e-24 * largest * largest {
            return Err(Error::Unanswerable(
                "the offsets of all dates are identical; were they copied?".into(),
            ));
        }
        let own: Vec<f64> = own.iter().map(|variance| variance.max(1e-6 * mean)).collect();
        // Scatter that is far above the own errors is within the range.
        let level = y.iter().sum::<f64>() / count as f64;
        let scatter = y.iter().map(|value| (value - level).powi(2)).sum::<f64>() / count as f64;
        let above = (scatter / mean).log2().ceil().clamp(0.0, 60.0) as i32;
        let factors: Vec<f64> = (0..=LARGER_OCTAVES.max(above + 2)).map(octave).collect();
        let ratios: Vec<f64> = (WANDER_OCTAVES[0]..=WANDER_OCTAVES[1].max(above + 4)).map(octave).collect();
        let stated = |number: usize| match number {
            0 => AS_STATED,
            _ => (1.0 - AS_STATED) / (factors.len() - 1) as f64,
        };
        let mut parts: Vec<Vec<Part>> = Vec::new();
        let mut white = Vec::new();
        let mut scale = 1.0;
        for (memory, (_, probability)) in [Memory::Flicker, Memory::Walk].into_iter().zip(FORMS) {
            let covariance =
                noise::covariance(&memory.noise(1.0), count, Some(time_s)).map_err(undetermined)?;
            let wander = Wander::of(design, y, &own, &covariance)?;
            scale = wander.scale();
            // Over the logarithm of q.
            let prior: Vec<f64> = ratios
                .iter()
                .map(|ratio| Ok(ratio * wander.reference_prior(*ratio)?))
                .collect::<Result<_>>()?;
            let sum: f64 = prior.iter().sum();
            let fit = |factor: f64, ratio: f64, prior: f64| -> Result<Component> {
                let mut one = wander.fit(factor, ratio)?;
                one.log_weight += prior.ln();
                one.covariance += shared;
                Ok(one)
            };
            if white.is_empty() {
                let each = factors.iter().enumerate().map(|(number, s)| fit(*s, 0.0, stated(number)));
                white = each.collect::<Result<_>>()?;
            }
            let mut all = Vec::new();
            for (number, s) in factors.iter().enumerate() {
                for (q, prior) in ratios.iter().zip(&prior) {
                    let component = fit(*s, *q, probability * stated(number) * prior / sum)?;
                    all.push(Part { component, own: *s, wander: *q });
                }
            }
            parts.push(all);
        }
        let mixture = |parts: &mut dyn Iterator<Item = &Part>| {
            Mixture::of(parts.map(|part| part.component.clone()).collect(), f64::INFINITY)
        };
        let all = mixture(&mut parts.iter().flatten());
        let mut weights = all.weights().iter();
        let share = |parts: &Vec<Part>| weights.by_ref().take(parts.len()).sum::<f64>();
        let weights = FORMS.iter().map(|(name, _)| *name).zip(parts.iter().map(share)).collect();
        let mut alone = vec![("white", Mixture::of(white, f64::INFINITY))];
        alone.extend(FORMS.iter().zip(&parts).map(|((name, _), parts)| (*name, mixture(&mut parts.iter()))));
        let (walk, probabilities) = (&parts[1], alone[2].1.weights());
        let probability = |of: &dyn Fn(&Part) -> bool| -> f64 {
            walk.iter().zip(probabilities).filter(|(part, _)| of(part)).map(|(_, weight)| weight).sum()
        };
        let unseen = probability(&|part| part.wander < part.own);
        let bound = ratios.iter().find(|ratio| probability(&|part| part.wander <= **ratio) >= 0.95);
        let bound = bound.or(ratios.last()).copied().unwrap_or(0.0);
        Ok(Self { all, weights, unseen, walk_below_nt_per_sqrt_s: (bound / scale).sqrt(), alone })
    }
}

/// One fit with the factors of its covariance.
struct Part {
    component: Component,
    own: f64,
    wander: f64,
}

fn octave(number: i32) -> f64 {
    2f64.powi(number)
}
