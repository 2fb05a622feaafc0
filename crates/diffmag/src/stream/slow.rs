use estimate::haar;
use faer::Mat;

use super::moments::CHANNELS;
use super::profile::Profile;

/// What is slow: the steps from each stretch's means to the next one's, and how noise covaries in them.
pub struct Slow {
    /// Places of a stretch that is whole, 2^level.
    pub length: f64,
    /// Differences of the means, a row from each stretch to the next.
    pub steps: Mat<f64>,
    /// Samples and means of each stretch.
    pub means: Vec<(f64, [f64; CHANNELS])>,
    /// Where each begins and ends, in lengths from the first.
    spans: Vec<[f64; 2]>,
}

impl Slow {
    pub fn of(profile: &Profile) -> Self {
        let length = 2.0_f64.powi(i32::from(profile.level));
        let stretches = &profile.stretches;
        let origin = stretches.first().map_or(0, |first| first.first);
        let place = |at: i64| (at - origin) as f64 / length;
        let spans = stretches.iter().map(|s| [place(s.first), place(s.last + 1)]).collect();
        let steps = Mat::from_fn(stretches.len().saturating_sub(1), CHANNELS, |i, j| {
            let [before, after] = [&stretches[i].block, &stretches[i + 1].block];
            after.sums[j].over(after.count as f64).less(before.sums[j].over(before.count as f64))
        });
        let means = stretches.iter().map(|s| (s.block.count as f64, s.block.means())).collect();
        Slow { length, steps, means, spans }
    }

    /// Covariance of the steps for white noise of variance one.
    pub fn white(&self) -> Mat<f64> {
        steps_of(self.means.len(), |i, j| if i == j { 1.0 / self.means[i].0 } else { 0.0 })
    }

    /// The same for noise of the density Δt (f Δt)^-α, as if samples were missing at the ends of a stretch
    /// only.
    pub fn power_law(&self, exponent: f64) -> Mat<f64> {
        let of = haar::sum_covariance(exponent);
        // Stretches begin and end at whole lengths but for the first and the last.
        let longest = self.spans.last().map_or(0.0, |[_, end]| *end);
        let whole: Vec<f64> =
            (0..=(longest as usize).min(16 * self.spans.len())).map(|length| of(length as f64)).collect();
        let g = |h: f64| {
            whole.get(h.abs() as usize).copied().filter(|_| h.fract() == 0.0).unwrap_or_else(|| of(h))
        };
        let scale = self.length.powf(exponent - 1.0);
        steps_of(self.means.len(), |i, j| {
            let ([a, b], [c, d]) = (self.spans[i], self.spans[j]);
            scale * (g(b - c) + g(a - d) - g(b - d) - g(a - c)) / ((b - a) * (d - c))
        })
    }

    /// The steps' coefficients in Σ n x° u: columns of a cross product with the mean u of each stretch.
    pub fn weights(&self, channels: &[usize]) -> Mat<f64> {
        let count: f64 = self.means.iter().map(|(count, _)| count).sum();
        let mut weights = Mat::zeros(self.steps.nrows(), channels.len());
        for (column, channel) in channels.iter().enumerate() {
            let mean = self.means.iter().map(|(n, means)| n * means[*channel]).sum::<f64>() / count;
            let mut before = 0.0;
            for (row, (n, means)) in self.means.iter().take(self.steps.nrows()).enumerate() {
                before += n * (means[*channel] - mean);
                weights[(row, column)] = -before;
            }
        }
        weights
    }
}

/// Covariance of the steps from that of the means.
fn steps_of(count: usize, covariance: impl Fn(usize, usize) -> f64) -> Mat<f64> {
    let means = Mat::from_fn(count, count, |i, j| if i <= j { covariance(i, j) } else { 0.0 });
    let of = |i: usize, j: usize| means[(i.min(j), i.max(j))];
    let steps = count.saturating_sub(1);
    Mat::from_fn(steps, steps, |i, j| of(i + 1, j + 1) - of(i + 1, j) - of(i, j + 1) + of(i, j))
}
