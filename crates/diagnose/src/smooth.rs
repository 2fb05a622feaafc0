//! A slow vector signal from noisy samples: local parabolas, as wide as the samples themselves allow.

use estimate::stats::median;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// Rows to either side of one, tried in turn.
const REACHES: [usize; 5] = [2, 4, 8, 16, 32];
/// A signal that its neighbours do not tell to this share of its length is too fast: it stays as it was
/// sampled.
const TOLD: f64 = 1e-3;

/// The signal at times that rise; missing samples are filled from their neighbours. Of several widths the one
/// from which left-out samples are told best is taken (by the median, so that a few wild samples count no
/// more than others).
pub fn smooth(time_s: &[f64], samples: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let there: Vec<usize> =
        (0..samples.len()).filter(|row| samples[*row].iter().all(|value| value.is_finite())).collect();
    let tried = REACHES.iter().filter(|reach| 2 * **reach < there.len()).map(|reach| {
        let told: Vec<Local> = (0..samples.len())
            .into_par_iter()
            .map(|row| local(time_s, samples, &there, row, *reach))
            .collect();
        let missed: Vec<f64> = there.iter().map(|row| told[*row].missed(&samples[*row])).collect();
        (median(&missed), told)
    });
    let length = median(&there.iter().map(|row| samples[*row].norm()).collect::<Vec<_>>());
    let best = tried.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(missed, _)| *missed < TOLD * length);
    match best {
        Some((_, told)) => told.into_iter().map(|local| local.value).collect(),
        None => samples.to_vec(),
    }
}

/// A signal at one row, and the share of the row's own sample in it.
struct Local {
    value: Vector3<f64>,
    own: f64,
}

impl Local {
    /// How far a sample is from what its neighbours alone tell.
    fn missed(&self, sample: &Vector3<f64>) -> f64 {
        (sample - self.value).norm() / (1.0 - self.own).max(f64::EPSILON)
    }
}

/// The parabola through the samples that are there up to `reach` rows to either side, at a row; fewer towards
/// the ends, for beside its middle a parabola is off by the signal's third derivative.
fn local(time_s: &[f64], samples: &[Vector3<f64>], there: &[usize], row: usize, reach: usize) -> Local {
    let middle = there.partition_point(|other| *other < row);
    let reach = reach.min(middle).min(there.len() - 1 - middle.min(there.len() - 1)).max(REACHES[0]);
    let from = middle.saturating_sub(reach).min(there.len() - 2 * reach - 1);
    let window = &there[from..=from + 2 * reach];
    let span = time_s[window[2 * reach]] - time_s[window[0]];
    let powers = |at: usize| {
        let x = (time_s[at] - time_s[row]) / span;
        Vector3::new(1.0, x, x * x)
    };
    let (mut products, mut along) = (Matrix3::zeros(), Matrix3::zeros());
    for at in window {
        let powers = powers(*at);
        products += powers * powers.transpose();
        along += powers * samples[*at].transpose();
    }
    match products.try_inverse() {
        Some(inverse) => Local { value: (inverse * along).row(0).transpose(), own: inverse[(0, 0)] },
        None => Local { value: samples[row], own: 0.0 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wave of 40 samples a period with errors that alternate: half of them are gone, gaps are filled, and
    /// a signal of three samples a period is left alone.
    #[test]
    fn slow_signals_lose_their_noise_and_fast_ones_stay() {
        let time: Vec<f64> = (0..200).map(f64::from).collect();
        let wave = |period: f64, t: f64| Vector3::new((t / period).sin(), (t / period).cos(), 2.0) * 1000.0;
        let error = |row: usize| if row.is_multiple_of(2) { 0.1 } else { -0.1 };
        let mut samples: Vec<Vector3<f64>> =
            time.iter().enumerate().map(|(row, t)| wave(40.0, *t).add_scalar(error(row))).collect();
        samples[50] = Vector3::repeat(f64::NAN);
        let smooth_samples = smooth(&time, &samples);
        for (row, found) in smooth_samples.iter().enumerate().skip(4).take(190) {
            assert!((found - wave(40.0, time[row])).norm() < 0.09, "{row}: {found}");
        }
        let fast: Vec<Vector3<f64>> = time.iter().map(|t| wave(0.5, *t)).collect();
        assert_eq!(smooth(&time, &fast), fast);
    }
}
