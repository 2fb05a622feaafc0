//! A size of the noise for each stretch of a recording: one is made on a quiet night, another by day beside
//! traffic, and a night ends while a temperature run goes on.

use estimate::{linear, stats};
use faer::Mat;
use statrs::function::gamma::digamma;

use crate::Result;
use crate::allowed::Allowed;
use crate::fit::Fit;
use crate::readings::Run;
use crate::shape::{Place, Shape};

/// Readings in a stretch, at least: a recording of fewer than twice as many is one.
const STRETCH: usize = 45;

/// The noise with each stretch's size, and the degrees of freedom of these.
pub struct Sized {
    pub allowed: Allowed,
    /// How many readings are in each stretch, and the degrees of freedom of its size; none: one size for all.
    stretches: Vec<(usize, f64)>,
}

impl Sized {
    /// Of the readings of a fit, with the noise that it called for.
    ///
    /// s² = r'r/d for each stretch, with the residuals r whitened by the likeliest covariance and their
    /// degrees of freedom d (readings less the trace of their part of the projection on the design). The
    /// variances behind them scatter like σ₀² ν/χ²(ν), with σ₀ and ν from the scatter of ln s² (Smyth 2004,
    /// Stat. Appl. Genet. Mol. Biol. 3, 3), so that σ² = (ν σ₀² + d s²)/(ν + d). Where the s² scatter by
    /// chance, or the sensor's own noise explains the readings, all have one size.
    pub fn of(
        allowed: Allowed,
        fit: &Fit,
        runs: &[Run<'_>],
        (shape, place): (&Shape, Place),
    ) -> Result<Self> {
        let same = |allowed| Ok(Self { allowed, stretches: Vec::new() });
        if allowed.is_own() {
            return same(allowed);
        }
        // In one pass over many readings, noise with memory has one size in each recording.
        let whole = runs.iter().map(|run| run.rows.len()).sum::<usize>() > shape.full;
        let cut = |run: &Run<'_>| if whole { vec![run.rows.len()] } else { stretches(run.rows.len()) };
        let rows: Vec<usize> = runs.iter().flat_map(cut).collect();
        let own = scatter(&allowed, fit, &rows)?;
        let Some((common, prior)) = spread(&own) else { return same(allowed) };
        let size = |(s2, freedom): &(f64, f64)| ((prior * common + freedom * s2) / (prior + freedom)).sqrt();
        let mut each = rows.iter().zip(&own).map(|(rows, own)| vec![size(own) / common.sqrt(); *rows]);
        let of_run = |run: &Run<'_>| each.by_ref().take(cut(run).len()).collect::<Vec<_>>().concat();
        let sizes: Vec<Vec<f64>> = runs.iter().map(of_run).collect();
        let stretches = rows.iter().zip(&own).map(|(rows, (_, freedom))| (*rows, prior + freedom)).collect();
        let recordings: Vec<_> = runs.iter().map(|run| (run.rows.len(), run.times())).collect();
        let weights = fit.linear.mixture.weights();
        Ok(Self { allowed: shape.allowed(&recordings, place, Some((&sizes, weights)))?, stretches })
    }

    /// The smallest of the effective degrees of freedom of some unknowns of a fit under this noise (Welch and
    /// Satterthwaite), and the factor from standard uncertainty to 95 % interval.
    pub fn freedom(&self, fit: &Fit, unknowns: &[usize]) -> Result<(f64, f64)> {
        let white = &self.allowed.whitenings[self.allowed.best(&fit.linear)];
        let design = white.apply(fit.design.as_ref());
        let none = vec![0.0; design.nrows()];
        let along: Mat<f64> = &design * &linear::fit(design.as_ref(), &none, None)?.covariance;
        let effective = |unknown: &usize| {
            let mut from = 0;
            let (mut sum, mut squares) = (0.0, 0.0);
            for (rows, freedom) in &self.stretches {
                let part: f64 = (from..from + rows).map(|i| along[(i, *unknown)].powi(2)).sum();
                sum += part;
                squares += part * part / freedom;
                from += rows;
            }
            if squares > 0.0 { sum * sum / squares } else { f64::INFINITY }
        };
        let freedom = unknowns.iter().map(effective).fold(fit.linear.freedom, f64::min);
        Ok((freedom, stats::coverage_factor(0.95, freedom)))
    }
}

/// So many readings in stretches of about the same length.
fn stretches(rows: usize) -> Vec<usize> {
    let count = (rows / STRETCH).max(1);
    (0..count).map(|at| (at + 1) * rows / count - at * rows / count).collect()
}

/// Mean square of the whitened residuals of each stretch, with its degrees of freedom.
fn scatter(allowed: &Allowed, fit: &Fit, rows: &[usize]) -> Result<Vec<(f64, f64)>> {
    let white = &allowed.whitenings[allowed.best(&fit.linear)];
    let design = white.apply(fit.design.as_ref());
    let left = linear::fit(design.as_ref(), &white.apply_to(&fit.linear.residuals), None)?;
    let along = &design * &left.covariance;
    let mut from = 0;
    let one = |rows: &usize| {
        let of = from..from + rows;
        from += rows;
        let squares: f64 = left.residuals[of.clone()].iter().map(|r| r * r).sum();
        let taken: f64 =
            of.map(|i| (0..design.ncols()).map(|j| along[(i, j)] * design[(i, j)]).sum::<f64>()).sum();
        let freedom = (*rows as f64 - taken).max(0.0);
        (if freedom > 0.0 { squares / freedom } else { 0.0 }, freedom)
    };
    Ok(rows.iter().map(one).collect())
}

/// σ₀² and ν of variances that scatter like σ₀² ν/χ²(ν), from estimates of them with their degrees of
/// freedom; None where the estimates scatter no more than their own freedom makes them.
fn spread(own: &[(f64, f64)]) -> Option<(f64, f64)> {
    let known: Vec<(f64, f64)> =
        own.iter().filter(|(s2, freedom)| *s2 > 0.0 && *freedom >= 1.0).copied().collect();
    let count = known.len() as f64;
    if count < 2.0 {
        return None;
    }
    let level = |half: f64| digamma(half) - half.ln();
    let logs: Vec<f64> = known.iter().map(|(s2, freedom)| s2.ln() - level(0.5 * freedom)).collect();
    let mean = logs.iter().sum::<f64>() / count;
    let beyond: f64 = known
        .iter()
        .zip(&logs)
        .map(|((_, freedom), log)| (log - mean).powi(2) * count / (count - 1.0) - trigamma(0.5 * freedom))
        .sum::<f64>()
        / count;
    if beyond <= 0.0 {
        return None;
    }
    let half = trigamma_inverse(beyond);
    Some(((mean + level(half)).exp(), 2.0 * half))
}

/// ψ'(x) = ψ'(x + 1) + 1/x² for x > 0, up to the asymptotic series (Abramowitz and Stegun 6.4.12).
fn trigamma(x: f64) -> f64 {
    let steps = (10.0 - x).ceil().max(0.0) as usize;
    let below: f64 = (0..steps).map(|step| (x + step as f64).powi(-2)).sum();
    let (x, square) = (x + steps as f64, (x + steps as f64).powi(-2));
    below + (1.0 + 0.5 / x + square * (1.0 / 6.0 - square * (1.0 / 30.0 - square / 42.0))) / x
}

/// x with ψ'(x) = y: Newton's steps on 1/ψ', which is almost straight (Smyth 2004, appendix).
fn trigamma_inverse(y: f64) -> f64 {
    let mut x = 0.5 + 1.0 / y;
    for _ in 0..50 {
        let value = trigamma(x);
        let slope = (trigamma(x * (1.0 + 1e-6)) - trigamma(x * (1.0 - 1e-6))) / (2e-6 * x);
        let step = value * (1.0 - value / y) / slope;
        x += step;
        if step.abs() < 1e-8 * x {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trigamma_and_its_inverse() {
        // ψ'(1) = π²/6, ψ'(½) = π²/2.
        let square = std::f64::consts::PI.powi(2);
        assert!((trigamma(1.0) - square / 6.0).abs() < 1e-10 && (trigamma(0.5) - square / 2.0).abs() < 1e-10);
        for x in [0.3, 1.0, 4.0, 60.0] {
            assert!((trigamma_inverse(trigamma(x)) / x - 1.0).abs() < 1e-6, "{x}");
        }
    }

    #[test]
    fn sizes_that_differ_by_chance_are_one() {
        // Quantiles of χ²(18)/18, alike or half of them four times as large.
        let quantiles = |size: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
            let one = |at: usize| {
                let p = (at as f64 + 0.5) / 12.0;
                (size(at) * stats::chi_squared_quantile(p, 18.0) / 18.0, 18.0)
            };
            (0..12).map(one).collect()
        };
        assert_eq!(spread(&quantiles(&|_| 3.0)), None);
        let (common, prior) = spread(&quantiles(&|at| [1.0, 4.0][at % 2])).expect("two sizes");
        assert!((1.2..2.5).contains(&common) && (2.0..8.0).contains(&prior), "{common} {prior}");
    }
}
