//! How great gains are by chance, when every candidate is searched over all its shapes.

use faer::Mat;
use rayon::prelude::*;

use super::projection::{Part, Screen};
use crate::{Error, stats};

/// Share of the draws below which the tail of the distribution is matched.
const MATCHED: f64 = 0.9;

/// A candidate: groups of columns, one for each shape that is tried, of which the best counts.
pub type Search = Vec<Vec<usize>>;

/// Distribution by chance of the best gain of each candidate, and of the least probable of all.
#[derive(Clone, Debug)]
pub struct Chance {
    /// Degrees of freedom of each candidate.
    ranks: Vec<f64>,
    /// Independent looks that the search of each candidate amounts to.
    looks: Vec<f64>,
    /// Independent candidates that all amount to.
    candidates: f64,
}

impl Chance {
    /// By residuals of independent errors of variance one; the search is gone through for each. `draws` has a row for
    /// each of them: its products with the columns.
    ///
    /// The gain of a candidate of rank k in m looks is taken as the greatest of m of χ²(k), m matched to the
    /// draws at their 90 % point; so is the number of candidates. This keeps the far tail, of which no draws
    /// are at hand (max-T, Westfall and Young 1993, with a parametric tail).
    ///
    /// Errors: [`Error::Decomposition`] for products that are not finite.
    pub fn of(screen: &Screen, searches: &[Search], draws: &Mat<f64>) -> Result<Self, Error> {
        let (gains, ranks): (Vec<Vec<f64>>, Vec<f64>) = searches
            .par_iter()
            .map(|search| -> Result<(Vec<f64>, f64), Error> {
                let mut best = vec![0.0_f64; draws.nrows()];
                let mut rank = 0;
                for group in search {
                    let part = Part::of(screen, group)?;
                    rank = rank.max(part.rank());
                    let picked = Mat::from_fn(draws.nrows(), group.len(), |i, j| draws[(i, group[j])]);
                    let along = picked * &part.directions;
                    for (i, best) in best.iter_mut().enumerate() {
                        let gain: f64 = (0..part.rank()).map(|k| along[(i, k)] * along[(i, k)]).sum();
                        *best = best.max(gain);
                    }
                }
                Ok((best, rank as f64))
            })
            .collect::<Result<Vec<_>, Error>>()?
            .into_iter()
            .unzip();
        let looked = |(gains, rank): (&Vec<f64>, &f64)| match *rank {
            rank if rank > 0.0 => looks(stats::chi_squared_p(quantile(gains, MATCHED), rank)),
            _ => 1.0,
        };
        let searched = gains.iter().zip(&ranks).map(looked).collect();
        let mut chance = Self { ranks, looks: searched, candidates: 1.0 };
        let least: Vec<f64> = (0..draws.nrows())
            .into_par_iter()
            .map(|i| (0..gains.len()).map(|c| chance.p(c, gains[c][i])).fold(1.0, f64::min))
            .collect();
        let negative: Vec<f64> = least.iter().map(|p| -p).collect();
        chance.candidates = looks(-quantile(&negative, MATCHED));
        Ok(chance)
    }

    /// Probability of such a gain of one candidate by chance, its search included.
    pub fn p(&self, candidate: usize, gain: f64) -> f64 {
        let rank = self.ranks[candidate];
        if rank > 0.0 { self.searched(candidate, stats::chi_squared_p(gain, rank)) } else { 1.0 }
    }

    /// The same from the probability of the best of its shapes as if that alone had been tried.
    pub fn searched(&self, candidate: usize, p: f64) -> f64 {
        at_least_one(p, self.looks[candidate])
    }

    /// The probability of one shape at which a candidate's comes to `level` with all that is searched.
    pub fn threshold(&self, candidate: usize, level: f64) -> f64 {
        -((-level).ln_1p() / (self.looks[candidate] * self.candidates)).exp_m1()
    }

    /// Probability that any of the candidates is so improbable by chance.
    pub fn adjusted(&self, p: f64) -> f64 {
        at_least_one(p, self.candidates)
    }
}

/// 1 − (1 − p)^m.
fn at_least_one(p: f64, count: f64) -> f64 {
    if p >= 1.0 {
        return 1.0;
    }
    -(count * (-p).ln_1p()).exp_m1()
}

/// The m at which the best of m has the probability p a tenth of the time.
fn looks(p: f64) -> f64 {
    (MATCHED.ln() / (-p).ln_1p()).max(1.0)
}

fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1);
    sorted.get((share * last as f64).round() as usize).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::super::left_out;
    use super::*;
    use crate::linear;

    /// A deterministic stream of nearly normal numbers.
    fn normals(rows: usize, columns: usize, mut state: u64) -> Mat<f64> {
        let mut uniform = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 11) as f64 + 0.5) / (1u64 << 53) as f64
        };
        Mat::from_fn(rows, columns, |_, _| {
            let (a, b) = (uniform(), uniform());
            (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
        })
    }

    #[test]
    fn gains_are_those_of_least_squares() {
        let block = normals(120, 7, 1);
        let screen = Screen::of_rows(block.as_ref()).given(&[0, 1]).expect("projected");
        let gain = screen.gain(&[3, 5]).expect("a gain");
        let fit = |columns: &[usize]| {
            let design = Mat::from_fn(120, columns.len(), |i, j| block[(i, columns[j])]);
            let y: Vec<f64> = (0..120).map(|i| block[(i, 6)]).collect();
            linear::fit(design.as_ref(), &y, None).expect("a fit")
        };
        let (without, with) = (fit(&[0, 1]), fit(&[0, 1, 3, 5]));
        assert!((gain.gain - (without.sum_of_squares - with.sum_of_squares)).abs() < 1e-10);
        assert!((screen.sum_of_squares() - without.sum_of_squares).abs() < 1e-10);
        for k in 0..2 {
            assert!((gain.coefficients[k] - with.coefficients[2 + k]).abs() < 1e-12);
            assert!((gain.covariance[(k, k)] - with.covariance[(2 + k, 2 + k)]).abs() < 1e-12);
        }
        let both = screen.given(&[3]).and_then(|screen| screen.gain(&[5])).expect("a gain").gain;
        let first = screen.gain(&[3]).expect("a gain").gain;
        assert!((both + first - gain.gain).abs() < 1e-10);
        assert_eq!(screen.gain(&[3, 3]).expect("a gain").rank, 1);
        assert_eq!(screen.gain(&[0]).expect("a gain").rank, 0);

        let blocks: Vec<Mat<f64>> = (0..4).map(|part| crate::gram(block.subrows(30 * part, 30))).collect();
        let held = left_out(&blocks, &[0, 3]).expect("fitted");
        let training = Mat::from_fn(90, 2, |i, j| block[(i + 30, [0, 3][j])]);
        let y: Vec<f64> = (30..120).map(|i| block[(i, 6)]).collect();
        let direct = linear::fit(training.as_ref(), &y, None).expect("a fit").coefficients;
        assert!(held[0].iter().zip(&direct).all(|(a, b)| (a - b).abs() < 1e-10));
    }

    /// The best of many overlapping candidates is claimed at the rate that is asked for.
    #[test]
    fn adjusted_probabilities_are_those_of_chance() {
        let (rows, columns, trials) = (60, 24, 600);
        let design = normals(rows, columns, 2);
        // Neighbouring columns are alike, as those of neighbouring time constants are.
        let design = Mat::from_fn(rows, columns, |i, j| (0..=j % 6).map(|k| design[(i, j - k)]).sum::<f64>());
        let errors = normals(rows, trials, 3);
        let searches: Vec<Search> =
            (0..4).map(|c| (0..5).map(|k| vec![6 * c + k, 6 * c + k + 1]).collect()).collect();
        let draws = normals(999, rows, 4) * &design;
        let mut below = [0usize; 2];
        for trial in 0..trials {
            let block = Mat::from_fn(rows, columns + 1, |i, j| {
                if j < columns { design[(i, j)] } else { errors[(i, trial)] }
            });
            let screen = Screen::of_rows(block.as_ref());
            let chance = Chance::of(&screen, &searches, &draws).expect("drawn");
            let least = searches.iter().enumerate().map(|(c, search)| {
                let gains = search.iter().map(|group| screen.gain(group).expect("a gain").gain);
                chance.p(c, gains.fold(0.0, f64::max))
            });
            let adjusted = chance.adjusted(least.fold(1.0, f64::min));
            for (count, level) in below.iter_mut().zip([0.1, 0.02]) {
                *count += usize::from(adjusted < level);
            }
        }
        let [ten, two] = below.map(|count| count as f64 / trials as f64);
        assert!((0.07..=0.13).contains(&ten), "{ten}");
        assert!((0.008..=0.035).contains(&two), "{two}");
    }
}
