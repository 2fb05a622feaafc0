//! The group lasso, from the products of the columns alone.
//!
//! ```text
//! min over β of  1/(2n) |y − X β|² + λ Σ √r_g |β_g|
//! ```
//!
//! with r_g the columns of group g. Source: Yuan & Lin 2006, Model selection and estimation in regression
//! with grouped variables, J. R. Stat. Soc. B, volume 68, p. 49. Group after group goes to the minimum of a
//! bound of the first term that is the same in all directions of the group. Source: Yang & Zou 2015, A fast
//! unified algorithm for solving group-lasso penalized learning problems, Stat. Comput. 25, 1129.

use faer::Side;
use std::collections::BTreeSet;
use std::ops::Range;

use crate::blocks::Sample;

/// Coefficients are found when none moves by more than this share of the largest.
const TOLERANCE: f64 = 1e-4;
/// Most rounds over the groups.
const ROUNDS: usize = 2000;
/// From one penalty of a path to the next.
const STEP: f64 = 0.9;
/// The least penalty of a path, as a share of the one at which the first group comes in.
const LIGHTEST: f64 = 1e-3;

/// A sample with what the descent needs of it.
#[derive(Clone, Debug)]
pub struct Lasso<'s> {
    sample: &'s Sample,
    groups: &'s [Range<usize>],
    /// Largest eigenvalue of each group's products, over the rows.
    steep: Vec<f64>,
}

/// Where a descent stands: the coefficients, and the products of the columns with what is left, over the
/// rows.
#[derive(Clone, Debug)]
struct At {
    coefficients: Vec<f64>,
    along: Vec<f64>,
}

impl<'s> Lasso<'s> {
    /// Of a sample whose columns stand in groups.
    pub fn of(sample: &'s Sample, groups: &'s [Range<usize>]) -> Self {
        let steep = |group: &Range<usize>| {
            let own = sample.gram.submatrix(group.start, group.start, group.len(), group.len());
            let values = own.self_adjoint_eigenvalues(Side::Lower).unwrap_or_default();
            values.last().copied().unwrap_or(0.0) / sample.rows
        };
        Self { sample, groups, steep: groups.iter().map(steep).collect() }
    }

    fn begin(&self) -> At {
        let along = self.sample.along.iter().map(|along| along / self.sample.rows).collect();
        At { coefficients: vec![0.0; self.sample.along.len()], along }
    }

    /// The penalty at which the first group comes in.
    fn heaviest(&self) -> f64 {
        let at = self.begin();
        let of = |group: &Range<usize>| length(&at.along[group.clone()]) / (group.len() as f64).sqrt();
        self.groups.iter().filter(|group| !group.is_empty()).map(of).fold(0.0, f64::max)
    }

    /// Moves one group; gives by how much.
    fn descend(&self, at: &mut At, number: usize, penalty: f64) -> f64 {
        let (group, steep) = (&self.groups[number], self.steep[number]);
        if group.is_empty() || steep <= 0.0 {
            return 0.0;
        }
        let towards: Vec<f64> = group.clone().map(|j| steep * at.coefficients[j] + at.along[j]).collect();
        let kept = (1.0 - penalty * (group.len() as f64).sqrt() / length(&towards)).max(0.0) / steep;
        let mut most = 0.0_f64;
        for (j, towards) in group.clone().zip(towards) {
            let moved = kept * towards - at.coefficients[j];
            if moved != 0.0 {
                at.coefficients[j] += moved;
                let share = moved / self.sample.rows;
                let column = self.sample.gram.col_as_slice(j);
                at.along.iter_mut().zip(column).for_each(|(along, product)| *along -= share * product);
                most = most.max(moved.abs());
            }
        }
        most
    }

    /// The minimum at a penalty, from where a descent stands: groups that are in until they stand, then all
    /// of them.
    fn minimum(&self, at: &mut At, penalty: f64, tolerance: f64) {
        let largest = |at: &At| at.coefficients.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
        for _ in 0..ROUNDS {
            let moved = (0..self.groups.len()).map(|g| self.descend(at, g, penalty)).fold(0.0, f64::max);
            if moved <= tolerance * largest(at) {
                return;
            }
            let inside = self.inside(at);
            for _ in 0..ROUNDS {
                let moved = inside.iter().map(|g| self.descend(at, *g, penalty)).fold(0.0, f64::max);
                if moved <= tolerance * largest(at) {
                    break;
                }
            }
        }
    }

    fn inside(&self, at: &At) -> Vec<usize> {
        let is_in = |g: &usize| at.coefficients[self.groups[*g].clone()].iter().any(|c| *c != 0.0);
        (0..self.groups.len()).filter(is_in).collect()
    }

    /// The groups that come in at any penalty of a path from the heaviest down, as long as there are no more
    /// of them than some.
    pub fn first(&self, most: usize) -> BTreeSet<usize> {
        let (mut at, heaviest) = (self.begin(), self.heaviest());
        let mut found = BTreeSet::new();
        let mut penalty = heaviest;
        while penalty > LIGHTEST * heaviest && heaviest > 0.0 {
            penalty *= STEP;
            self.minimum(&mut at, penalty, TOLERANCE);
            let with: BTreeSet<usize> = found.iter().copied().chain(self.inside(&at)).collect();
            if with.len() > most {
                break;
            }
            found = with;
        }
        found
    }
}

fn length(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::Blocks;
    use serde_json::Value;

    /// The minimum that skglm finds on the same columns: fixtures/reference/group_lasso.py.
    #[test]
    fn the_minimum_is_that_of_skglm() {
        let text = testkit::read_fixture("reference/group_lasso.json");
        let reference: Value = serde_json::from_str(&text).expect("JSON");
        let list = |value: &Value| -> Vec<f64> {
            value.as_array().expect("a list").iter().filter_map(Value::as_f64).collect()
        };
        for case in reference["cases"].as_array().expect("cases") {
            let rows: Vec<Vec<f64>> = case["rows"].as_array().expect("rows").iter().map(list).collect();
            let mut from = 0;
            let groups: Vec<Range<usize>> = list(&case["sizes"])
                .into_iter()
                .map(|size| {
                    from += size as usize;
                    from - size as usize..from
                })
                .collect();
            let blocks = Blocks::of_rows(&rows);
            let sample = blocks.sample(&vec![1.0; rows.len()]).expect("finite");
            let lasso = Lasso::of(&sample, &groups);
            for (penalty, expected) in
                list(&case["penalties"]).iter().zip(case["coefficients"].as_array().expect("lists"))
            {
                let mut at = lasso.begin();
                lasso.minimum(&mut at, *penalty, 1e-12);
                for (found, expected) in at.coefficients.iter().zip(list(expected)) {
                    assert!((found - expected).abs() < 1e-7, "{found} for {expected} at {penalty}");
                }
            }
        }
    }
}
