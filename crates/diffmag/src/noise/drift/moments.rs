//! Sums of a series with exponentials of any time constant, from the moments of its blocks: each takes as
//! long for a month as for an hour.

/// Terms of e^(−r x) within a block, where |r x| is at most one: what they leave is 1/19! of it.
const TERMS: usize = 19;

/// Terms so small beside the first do not count.
const SMALL: f64 = 1e-18;

/// Moments Σ y_k u^m/m! of blocks of rows, u the row from the middle of its block over half the block's
/// length.
pub struct Moments {
    /// Half a block, in rows.
    half: f64,
    /// The middle row of each, and its moments.
    blocks: Vec<(f64, [f64; TERMS + 1])>,
}

impl Moments {
    /// Of a series, for exponentials e^(−r k) of row k with r up to `highest`.
    pub fn of(values: &[f64], highest: f64) -> Self {
        let rows = ((2.0 / highest) as usize).max(1);
        let half = 0.5 * rows as f64;
        let block = |(number, values): (usize, &[f64])| {
            let mut moments = [0.0; TERMS + 1];
            for (row, value) in values.iter().enumerate() {
                let u = (row as f64 - 0.5 * (rows as f64 - 1.0)) / half;
                let mut term = *value;
                for (m, moment) in moments.iter_mut().enumerate() {
                    *moment += term;
                    term *= u / (m + 1) as f64;
                }
            }
            ((number * rows) as f64 + 0.5 * (rows as f64 - 1.0), moments)
        };
        Self { half, blocks: values.chunks(rows).enumerate().map(block).collect() }
    }

    /// Those of the series less others times coefficients.
    pub fn less(&self, others: &[Self; 3], coefficients: [f64; 3]) -> Self {
        let mut blocks = self.blocks.clone();
        for (other, coefficient) in others.iter().zip(coefficients) {
            for ((_, moments), (_, other)) in blocks.iter_mut().zip(&other.blocks) {
                moments.iter_mut().zip(other).for_each(|(moment, other)| *moment -= coefficient * other);
            }
        }
        Self { half: self.half, blocks }
    }

    /// Σ y_k e^(−r k), and Σ r k y_k e^(−r k), its derivative with respect to −ln r.
    pub fn sums(&self, rate: f64) -> [f64; 2] {
        let step = -rate * self.half;
        let powers: Vec<f64> =
            std::iter::successors(Some(1.0), |power| Some(power * step)).take(TERMS).collect();
        // Of slow exponentials few terms count.
        let count = powers.iter().take_while(|power: &&f64| power.abs() > SMALL).count();
        let counted: Vec<f64> = powers.iter().zip(1..).map(|(power, m)| power * f64::from(m)).collect();
        let product = |powers: &[f64], moments: &[f64]| -> f64 {
            powers[..count].iter().zip(moments).map(|(power, moment)| power * moment).sum()
        };
        let mut sums = [0.0; 2];
        for (middle, moments) in &self.blocks {
            let size = (-rate * middle).exp();
            let plain = size * product(&powers, moments);
            let beside = size * product(&counted, &moments[1..]);
            sums[0] += plain;
            sums[1] += rate * (middle * plain + self.half * beside);
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_over_all_rows() {
        let values: Vec<f64> = (0..1234).map(|k| (0.7 * f64::from(k)).sin() + 0.3).collect();
        let moments = Moments::of(&values, 0.02);
        for rate in [0.02, 0.003, 1e-5] {
            let expected = values.iter().enumerate().fold([0.0; 2], |[plain, slope], (k, y)| {
                let term = y * (-rate * k as f64).exp();
                [plain + term, slope + rate * k as f64 * term]
            });
            for (found, expected) in moments.sums(rate).iter().zip(expected) {
                assert!((found / expected - 1.0).abs() < 1e-12, "{rate}: {found} {expected}");
            }
        }
    }
}
