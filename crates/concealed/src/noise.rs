//! Noise of a reading, made by itself.

use nalgebra::Complex;
use rustfft::FftPlanner;

use crate::draw::Draw;

/// White noise and flicker noise of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Rms of the white part, nT.
    pub white_nt: f64,
    /// One-sided density of the flicker part at 1 Hz, nT²/Hz.
    pub flicker_nt2_per_hz: f64,
    /// Its exponent α: P(f) = A f^−α.
    pub exponent: f64,
    /// Whether it began long before the recording.
    pub old: bool,
}

/// Sines to each line of the record's own Fourier series.
const FINER: usize = 8;

impl Noise {
    /// `rows` readings at a step, nT.
    pub fn series(&self, rows: usize, step_s: f64, draw: &mut Draw) -> Vec<f64> {
        if self.old { self.of_old(rows, step_s, draw) } else { self.of_record(rows, step_s, draw) }
    }

    /// The same for thousands of rows, all sines at once: the same numbers to rounding.
    pub fn long_series(&self, rows: usize, step_s: f64, draw: &mut Draw) -> Vec<f64> {
        if self.old { self.long_of_old(rows, step_s, draw) } else { self.long_of_record(rows, step_s, draw) }
    }

    /// As documents declare noise: P(f) = A f^−α down to one over the record's length, and nothing below.
    ///
    /// A sum of sines of normal amplitudes, [`FINER`] times as dense as the record's Fourier series and not
    /// on it: the noise neither repeats nor closes on itself.
    fn of_record(&self, rows: usize, step_s: f64, draw: &mut Draw) -> Vec<f64> {
        let mut series = self.white(rows, draw);
        if self.flicker_nt2_per_hz <= 0.0 {
            return series;
        }
        for (frequency, mut wave) in self.waves(rows, step_s, draw) {
            let turn = Complex::from_polar(1.0, std::f64::consts::TAU * frequency * step_s);
            for value in &mut series {
                *value += wave.re;
                wave *= turn;
            }
        }
        series
    }

    /// The sines of a record of `rows`: frequency, Hz, and what they are at its beginning.
    fn waves(&self, rows: usize, step_s: f64, draw: &mut Draw) -> impl Iterator<Item = (f64, Complex<f64>)> {
        let width = 1.0 / (FINER as f64 * rows as f64 * step_s);
        let shift = draw.between(0.0, 1.0);
        (FINER..FINER * rows / 2).map(move |line| {
            let frequency = (line as f64 + shift) * width;
            let size = (self.flicker_nt2_per_hz * frequency.powf(-self.exponent) * width).sqrt();
            let (sine, cosine) = (size * draw.normal(), size * draw.normal());
            (frequency, Complex::new(cosine, -sine))
        })
    }

    /// [`Self::of_record`] by one transform: lines that all lie by the same shift beside a series of
    /// [`FINER`] records, and the shift's own turn after it.
    fn long_of_record(&self, rows: usize, step_s: f64, draw: &mut Draw) -> Vec<f64> {
        let mut series = self.white(rows, draw);
        if self.flicker_nt2_per_hz <= 0.0 {
            return series;
        }
        let mut lines = vec![Complex::new(0.0, 0.0); FINER * rows];
        let mut first = 0.0;
        for (line, (frequency, wave)) in (FINER..).zip(self.waves(rows, step_s, draw)) {
            if line == FINER {
                first = frequency * step_s - 1.0 / rows as f64;
            }
            lines[line] = wave;
        }
        FftPlanner::new().plan_fft_inverse(lines.len()).process(&mut lines);
        for (n, (value, sum)) in series.iter_mut().zip(lines).enumerate() {
            *value += (sum * Complex::from_polar(1.0, std::f64::consts::TAU * first * n as f64)).re;
        }
        series
    }

    /// The same noise of an instrument that has been running for long: its slow part does not end at one over
    /// the record's length, so that levels of recordings differ and drift. White noise integrated α/2 times
    /// over a past of [`FINER`] records,
    ///
    /// ```text
    /// x_n = Σ_j h_j w_(n−j),   h_0 = 1,   h_j = h_(j−1) (j − 1 + α/2) / j,   var w = A (2π Δt)^α / (2 Δt)
    /// ```
    ///
    /// Source: Kasdin 1995, Discrete simulation of colored noise, Proc. IEEE 83, 802.
    fn of_old(&self, rows: usize, step_s: f64, draw: &mut Draw) -> Vec<f64> {
        let past = (FINER - 1) * rows;
        let (weights, driven) = self.past(past + rows, step_s, draw);
        let mut series = self.white(rows, draw);
        for (n, value) in series.iter_mut().enumerate() {
            *value += (0..=past + n).map(|j| weights[j] * driven[past + n - j]).sum::<f64>();
        }
        series
    }

    /// [`Self::of_old`] by transforms.
    fn long_of_old(&self, rows: usize, step_s: f64, draw: &mut Draw) -> Vec<f64> {
        let past = (FINER - 1) * rows;
        let (weights, driven) = self.past(past + rows, step_s, draw);
        let mut planner = FftPlanner::new();
        let count = 2 * (past + rows);
        let (forward, back) = (planner.plan_fft_forward(count), planner.plan_fft_inverse(count));
        let [mut sum, driven] = [weights, driven].map(|values| {
            let mut padded: Vec<Complex<f64>> = values.into_iter().map(Complex::from).collect();
            padded.resize(count, Complex::new(0.0, 0.0));
            forward.process(&mut padded);
            padded
        });
        sum.iter_mut().zip(driven).for_each(|(sum, driven)| *sum *= driven / count as f64);
        back.process(&mut sum);
        let mut series = self.white(rows, draw);
        series.iter_mut().zip(&sum[past..]).for_each(|(value, sum)| *value += sum.re);
        series
    }

    /// Weights h and drive w of so many rows.
    fn past(&self, rows: usize, step_s: f64, draw: &mut Draw) -> (Vec<f64>, Vec<f64>) {
        let half = self.exponent / 2.0;
        let mut weights = vec![1.0; rows];
        for j in 1..weights.len() {
            weights[j] = weights[j - 1] * (j as f64 - 1.0 + half) / j as f64;
        }
        let drive = self.flicker_nt2_per_hz * (std::f64::consts::TAU * step_s).powf(self.exponent);
        let size = (drive / (2.0 * step_s)).sqrt();
        let driven = (0..rows).map(|_| size * draw.normal()).collect();
        (weights, driven)
    }

    fn white(&self, rows: usize, draw: &mut Draw) -> Vec<f64> {
        (0..rows).map(|_| self.white_nt * draw.normal()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean of many periodograms has the stated density in the middle of the band, whichever way it is
    /// made.
    #[test]
    fn the_density_is_the_stated_one() {
        let noise = Noise { white_nt: 0.0, flicker_nt2_per_hz: 0.02, exponent: 1.0, old: false };
        for make in [Noise::of_record, Noise::of_old] {
            let (rows, step) = (128_usize, 2.0);
            let mut draw = Draw::new("density", 1);
            let mut density = [0.0; 3];
            let harmonics = [6, 10, 14];
            let records = 1500;
            for _ in 0..records {
                let series = make(&noise, rows, step, &mut draw);
                for (sum, k) in density.iter_mut().zip(harmonics) {
                    let angle = |n: usize| std::f64::consts::TAU * (k * n) as f64 / rows as f64;
                    // A sine window keeps the step between the record's ends out.
                    let window = |n: usize| (std::f64::consts::PI * (n as f64 + 0.5) / rows as f64).sin();
                    let (c, s) = series.iter().enumerate().fold((0.0, 0.0), |(c, s), (n, x)| {
                        (c + window(n) * x * angle(n).cos(), s + window(n) * x * angle(n).sin())
                    });
                    *sum += 2.0 * (c * c + s * s) * step / (0.5 * rows as f64) / f64::from(records);
                }
            }
            for (found, k) in density.iter().zip(harmonics) {
                let stated = 0.02 / (f64::from(k as u32) / (rows as f64 * step));
                // 1500 records: 2.6 % standard deviation; the window's own width adds about 2 %.
                assert!((found / stated - 1.0).abs() < 0.1, "harmonic {k}: {found} for {stated}");
            }
        }
    }

    #[test]
    fn all_sines_at_once_are_the_same_noise() {
        for (old, exponent) in [(false, 1.0), (false, 1.5), (true, 1.0)] {
            let noise = Noise { white_nt: 0.1, flicker_nt2_per_hz: 0.02, exponent, old };
            let one = noise.series(150, 7.0, &mut Draw::new("same", 1));
            let other = noise.long_series(150, 7.0, &mut Draw::new("same", 1));
            assert!(one.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-9), "{noise:?}");
        }
    }

    /// Below one over the record's length there is nothing in the one, and much in the other: the means of
    /// records tell.
    #[test]
    fn levels_wander_in_old_noise_alone() {
        let noise = Noise { white_nt: 0.0, flicker_nt2_per_hz: 0.02, exponent: 1.5, old: false };
        let mut draw = Draw::new("levels", 1);
        let mut level = |make: fn(&Noise, usize, f64, &mut Draw) -> Vec<f64>| {
            let mean = |_| make(&noise, 100, 2.0, &mut draw).iter().sum::<f64>() / 100.0;
            (0..200).map(mean).map(|mean: f64| mean * mean).sum::<f64>() / 200.0
        };
        let (declared, old) = (level(Noise::of_record), level(Noise::of_old));
        assert!(old > 5.0 * declared, "{old} {declared}");
    }
}
