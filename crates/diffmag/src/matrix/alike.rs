//! The band in which two instruments answer alike: up to where the matrix of an octave is that of longer
//! periods.

use common::covariance::between;
use estimate::positive::Positive;
use estimate::stats;
use faer::Mat;

use crate::Error;
use crate::drift::Columns;

/// An octave whose matrix is so improbable, over all octaves that are held against longer periods, is not
/// alike.
const DISAGREE_BELOW: f64 = 0.01;
/// The band is not narrowed to fewer coefficients.
const LEAST_KEPT: usize = 256;
/// Below so many octaves in succession that agree with longer periods nothing is left out: the longest have
/// drifts, tilts and temperatures.
const AGREED: usize = 2;
/// The lowest octave has so many at least.
const LOWEST: usize = 8;
/// The noise of the octaves and the matrix by it are fitted in turn, so often.
const ROUNDS: usize = 12;
/// The reference's axes; a straight drift is the column after them.
const AXES: usize = 3;
const WIDTH: usize = AXES + 1;

/// How many of the lowest cosine coefficients of a test axis, `y`, belong to periods at which the instruments
/// answer alike.
///
/// The matrix of each octave, by least squares in it, is held against that of all longer periods, weighted by
/// a noise level of each octave: filters, and noise of the reference where the field is weak, pull the matrix
/// of short periods. No form of the noise is assumed, and nothing is said of octaves in which the field is
/// not seen.
pub fn band(columns: &Columns<'_>, y: &[f64]) -> Result<usize, Error> {
    let octaves = Octave::all(&columns.base(), y);
    let tested = octaves.iter().filter(|octave| octave.from >= LEAST_KEPT).count();
    let (mut kept, mut agreed) = (y.len(), 0);
    for (number, octave) in octaves.iter().enumerate().rev().take(tested) {
        let Some(own) = octave.alone() else { continue };
        if disagreement_p(&own, &weighted(&octaves[..number])?)? < DISAGREE_BELOW / tested as f64 {
            (kept, agreed) = (octave.from, 0);
        } else {
            agreed += 1;
        }
        if agreed == AGREED {
            break;
        }
    }
    Ok(kept)
}

/// Probability of two matrices of independent octaves so far apart by chance.
fn disagreement_p(one: &Fit, other: &Fit) -> Result<f64, Error> {
    let sum = Mat::from_fn(AXES, AXES, |i, j| one.1[(i, j)] + other.1[(i, j)]);
    let apart: [f64; AXES] = std::array::from_fn(|i| one.0[i] - other.0[i]);
    let distance = between(&Positive::of(&sum)?.inverse, &apart, &apart);
    Ok(stats::chi_squared_p(distance.max(0.0), AXES as f64))
}

/// Coefficients and their covariance.
type Fit = (Vec<f64>, Mat<f64>);

/// Sums of products over the coefficients of one octave.
struct Octave {
    /// The first coefficient, and how many there are.
    from: usize,
    count: usize,
    /// Of the columns, and of y as the last.
    products: [[f64; WIDTH + 1]; WIDTH + 1],
}

impl Octave {
    /// From the lowest frequencies on.
    fn all(columns: &[&[f64]], y: &[f64]) -> Vec<Self> {
        let mut edges = vec![y.len()];
        while edges[edges.len() - 1] / 2 >= LOWEST {
            edges.push(edges[edges.len() - 1] / 2);
        }
        edges.push(0);
        edges.reverse();
        let all = |i: usize| if i < WIDTH { columns[i] } else { y };
        let of = |edge: &[usize]| {
            let mut products = [[0.0; WIDTH + 1]; WIDTH + 1];
            for (i, row) in products.iter_mut().enumerate() {
                for (j, product) in row.iter_mut().enumerate() {
                    let (a, b) = (&all(i)[edge[0]..edge[1]], &all(j)[edge[0]..edge[1]]);
                    *product = estimate::dot(a, b);
                }
            }
            Self { from: edge[0], count: edge[1] - edge[0], products }
        };
        edges.windows(2).map(of).collect()
    }

    /// What coefficients of the columns leave, as a sum of squares.
    fn left(&self, coefficients: &[f64]) -> f64 {
        let with_y = |i: usize| coefficients.get(i).map_or(1.0, |coefficient| -coefficient);
        let row = |i: usize| -> f64 { (0..=WIDTH).map(|j| with_y(j) * self.products[i][j]).sum() };
        (0..=WIDTH).map(|i| with_y(i) * row(i)).sum()
    }

    /// Least squares of the reference's axes in this octave; None where the field is not seen.
    fn alone(&self) -> Option<Fit> {
        let inverse = Positive::of(&Mat::from_fn(AXES, AXES, |i, j| self.products[i][j])).ok()?.inverse;
        let coefficient = |i: usize| (0..AXES).map(|j| inverse[(i, j)] * self.products[j][WIDTH]).sum();
        let found: Vec<f64> = (0..AXES).map(coefficient).chain([0.0]).collect();
        let freedom = self.count.checked_sub(AXES).filter(|freedom| *freedom > 0)?;
        let variance = self.left(&found).max(0.0) / freedom as f64;
        let covariance = Mat::from_fn(AXES, AXES, |i, j| variance * inverse[(i, j)]);
        Some((found[..AXES].to_vec(), covariance))
    }
}

/// Least squares of the reference's axes and a straight drift over some octaves, each weighted by what is
/// left in it.
fn weighted(octaves: &[Octave]) -> Result<Fit, Error> {
    let mut variances = vec![1.0; octaves.len()];
    let mut found = (Vec::new(), Mat::new());
    for _ in 0..ROUNDS {
        let sum = |i: usize, j: usize| -> f64 {
            octaves.iter().zip(&variances).map(|(octave, variance)| octave.products[i][j] / variance).sum()
        };
        let covariance = Positive::of(&Mat::from_fn(WIDTH, WIDTH, sum))?.inverse;
        let right: Vec<f64> = (0..WIDTH).map(|j| sum(j, WIDTH)).collect();
        let coefficient = |i: usize| (0..WIDTH).map(|j| covariance[(i, j)] * right[j]).sum();
        let coefficients: Vec<f64> = (0..WIDTH).map(coefficient).collect();
        for (octave, variance) in octaves.iter().zip(&mut variances) {
            let leverage: f64 = (0..WIDTH)
                .flat_map(|i| (0..WIDTH).map(move |j| (i, j)))
                .map(|(i, j)| covariance[(i, j)] * octave.products[i][j] / *variance)
                .sum();
            let least = f64::EPSILON * octave.products[WIDTH][WIDTH] / octave.count as f64;
            let freedom = (octave.count as f64 - leverage).max(1.0);
            *variance = (octave.left(&coefficients) / freedom).max(least).max(f64::MIN_POSITIVE);
        }
        found = (coefficients, covariance);
    }
    Ok(found)
}
