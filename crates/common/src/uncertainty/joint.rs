//! Independent sources of uncertainty, and how one standard deviation of each moves the parameters.

use faer::{Col, ColRef, Mat, Scale};
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::Extra;

/// A move that adds less than this share to a standard uncertainty is not kept.
const NEGLIGIBLE: f64 = 1e-9;
/// What is less than this share of a variance in a root is rounding.
const ROUNDING: f64 = 1e-14;
/// Two standard uncertainties that differ by less than this share are the same.
pub(super) const SAME: f64 = 1e-6;

/// Independent sources of uncertainty and what they move.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Uncertainty {
    /// The sources.
    #[serde(default)]
    pub sources: Vec<Source>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// One source: a quantity of mean zero and standard deviation one, independent of every other source.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Source {
    /// What it is. Sources of one name were estimated together, with one variance.
    pub name: String,
    /// Degrees of freedom of the variance of all sources of this name; absent: the variance is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degrees_of_freedom: Option<f64>,
    /// By how much one standard deviation of it moves each parameter, by the path of the parameter, in the
    /// parameter's unit.
    pub moves: IndexMap<String, f64>,
}

/// Quantities by how they move with parameters of the document: each parameter's path, with the derivative of
/// every quantity by it.
pub type By = Vec<(String, Vec<f64>)>;

/// Parameters as a program estimates them.
#[derive(Clone, Debug)]
pub struct Block {
    /// What their own covariance comes from.
    pub name: String,
    /// Degrees of freedom of its size; infinite: it is known.
    pub degrees_of_freedom: f64,
    /// The paths of the parameters.
    pub parameters: Vec<String>,
    /// Their covariance by what is new: the scatter of the readings.
    pub covariance: Mat<f64>,
    /// The parameters that they were estimated with, each with the derivative of every parameter of the block
    /// by it.
    pub by: By,
}

impl Uncertainty {
    /// Takes parameters in as they were estimated, in place of what was known of them.
    ///
    /// # Errors
    ///
    /// What is wrong with the block's own covariance.
    pub fn put(&mut self, block: Block) -> Result<(), String> {
        let own = root(&block.covariance)?;
        // By the derivatives, from what the sources move before anything is forgotten.
        let carried = self.moved(&block.by, block.parameters.len());
        let std: Vec<f64> = (own.row_iter().zip(carried.row_iter()))
            .map(|(own, carried)| own.norm_l2().hypot(carried.norm_l2()))
            .collect();
        self.forget(&block.parameters);
        let kept = |moves: ColRef<'_, f64>| -> Vec<(String, f64)> {
            let named = block.parameters.iter().cloned().zip(moves.iter().copied()).zip(&std);
            named.filter(|((_, moved), std)| moved.abs() > NEGLIGIBLE * **std).map(|(pair, _)| pair).collect()
        };
        for (source, moves) in self.sources.iter_mut().zip(carried.col_iter()) {
            source.moves.extend(kept(moves));
        }
        let degrees_of_freedom = Some(block.degrees_of_freedom).filter(|freedom| freedom.is_finite());
        self.sources.extend(own.col_iter().map(|moves| Source {
            name: block.name.clone(),
            degrees_of_freedom,
            moves: kept(moves).into_iter().collect(),
        }));
        self.sources.retain(|source| !source.moves.is_empty());
        Ok(())
    }

    /// Forgets what is known of parameters.
    pub fn forget(&mut self, parameters: &[String]) {
        for source in &mut self.sources {
            source.moves.retain(|path, _| !parameters.contains(path));
        }
    }

    /// The standard uncertainty of a parameter; zero where no source moves it.
    pub fn std(&self, parameter: &str) -> f64 {
        let moves = self.sources.iter().filter_map(|source| source.moves.get(parameter));
        moves.map(|moved| moved * moved).sum::<f64>().sqrt()
    }

    /// The effective degrees of freedom of a parameter's standard uncertainty (Welch and Satterthwaite, JCGM
    /// 100 G.4).
    pub fn degrees_of_freedom(&self, parameter: &str) -> f64 {
        let mut of_name: IndexMap<&str, (f64, f64)> = IndexMap::new();
        for source in &self.sources {
            if let (Some(freedom), Some(moved)) = (source.degrees_of_freedom, source.moves.get(parameter)) {
                of_name.entry(&source.name).or_insert((freedom, 0.0)).1 += moved * moved;
            }
        }
        let sum: f64 = of_name.values().map(|(freedom, variance)| variance * variance / freedom).sum();
        if sum > 0.0 { self.std(parameter).powi(4) / sum } else { f64::INFINITY }
    }

    /// By how much each source moves each of `count` quantities: a column for each source.
    fn moved(&self, by: &By, count: usize) -> Mat<f64> {
        let mut moved = Mat::zeros(count, self.sources.len());
        for (source, mut column) in self.sources.iter().zip(moved.col_iter_mut()) {
            for (path, derivatives) in by {
                if let Some(moved) = source.moves.get(path) {
                    column += ColRef::from_slice(derivatives) * Scale(*moved);
                }
            }
        }
        moved
    }

    /// The covariance of quantities.
    pub fn covariance_by(&self, by: &By) -> Mat<f64> {
        let root = self.moved(by, by.first().map_or(0, |(_, derivatives)| derivatives.len()));
        &root * root.transpose()
    }

    /// The covariance of parameters.
    pub fn covariance(&self, parameters: &[String]) -> Mat<f64> {
        self.covariance_by(&by_themselves(parameters))
    }
}

/// Parameters as quantities: each moves with itself alone.
pub fn by_themselves(parameters: &[String]) -> By {
    let one = |at: usize| (0..parameters.len()).map(|other| f64::from(u8::from(other == at))).collect();
    parameters.iter().enumerate().map(|(at, path)| (path.clone(), one(at))).collect()
}

/// A matrix of columns whose outer products add up to a covariance: Cholesky's factor with the largest
/// variance first, until what is left is rounding.
///
/// # Errors
///
/// What is wrong with it.
pub fn root(covariance: &Mat<f64>) -> Result<Mat<f64>, String> {
    let count = covariance.nrows();
    if !covariance.is_all_finite() {
        return Err("a covariance that is not finite".into());
    }
    let variance: Vec<f64> = (0..count).map(|at| covariance[(at, at)]).collect();
    let mut left = covariance.clone();
    let mut columns: Vec<Col<f64>> = Vec::new();
    let share =
        |left: &Mat<f64>, at: usize| if variance[at] > 0.0 { left[(at, at)] / variance[at] } else { 0.0 };
    while columns.len() < count {
        let Some(pivot) = (0..count).max_by(|a, b| share(&left, *a).total_cmp(&share(&left, *b))) else {
            break;
        };
        if share(&left, pivot) <= ROUNDING {
            break;
        }
        let scale = left[(pivot, pivot)].sqrt();
        let column = Col::from_fn(count, |row| left[(row, pivot)] / scale);
        left -= &column * column.transpose();
        columns.push(column);
    }
    let beyond = |a: usize, b: usize| {
        left[(a, b)].abs() > SAME * (variance[a] * variance[b]).max(0.0).sqrt() && left[(a, b)] != 0.0
    };
    if (0..count).any(|a| (0..count).any(|b| beyond(a, b))) {
        return Err("a covariance that cannot be".into());
    }
    Ok(Mat::from_fn(count, columns.len(), |row, column| columns[column][row]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::mat;

    fn paths(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_string()).collect()
    }

    fn block(names: &[&str], covariance: Mat<f64>, by: &[(&str, Vec<f64>)]) -> Block {
        Block {
            name: names.join(" and "),
            degrees_of_freedom: f64::INFINITY,
            parameters: paths(names),
            covariance,
            by: by.iter().map(|(path, derivatives)| ((*path).to_string(), derivatives.clone())).collect(),
        }
    }

    #[test]
    fn what_two_owe_to_one_is_in_both_and_counts_once() {
        let mut joint = Uncertainty::default();
        joint.put(block(&["coil"], mat![[4.0]], &[])).expect("found");
        joint.put(block(&["a"], mat![[1.0]], &[("coil", vec![0.5])])).expect("found");
        joint.put(block(&["b"], mat![[9.0]], &[("coil", vec![-1.0])])).expect("found");
        // a = own + coil/2, b = own − coil.
        assert_eq!(joint.covariance(&paths(&["a", "b"])), mat![[2.0, -2.0], [-2.0, 13.0]]);
        // c = a + b/2: by either way from the coil, one half less one half is nothing.
        joint.put(block(&["c"], mat![[0.0]], &[("a", vec![1.0]), ("b", vec![0.5])])).expect("found");
        assert!((joint.std("c").powi(2) - (1.0 + 9.0 / 4.0)).abs() < 1e-12);
    }

    #[test]
    fn a_parameter_that_is_estimated_again_with_itself_keeps_its_sources() {
        let mut joint = Uncertainty::default();
        joint.put(block(&["k"], mat![[4.0]], &[])).expect("found");
        joint.put(block(&["k"], mat![[0.25]], &[("k", vec![0.5])])).expect("found");
        assert!((joint.std("k").powi(2) - 1.25).abs() < 1e-12);
        joint.put(block(&["k"], mat![[0.25]], &[])).expect("found");
        assert_eq!(joint.sources.len(), 1);
    }

    #[test]
    fn a_root_is_one_of_the_covariance_also_where_it_is_short_of_rank() {
        let columns = mat![[1.0, 0.5], [2.0, 0.0], [-1.0, 3.0]];
        let covariance = &columns * columns.transpose();
        let root = root(&covariance).expect("found");
        assert_eq!(root.ncols(), 2);
        assert!((&root * root.transpose() - covariance).norm_max() < 1e-12);
        assert!(super::root(&mat![[1.0, 2.0], [2.0, 1.0]]).is_err());
    }

    #[test]
    fn degrees_of_freedom_of_one_name_go_together() {
        let mut joint = Uncertainty::default();
        let scatter =
            Block { degrees_of_freedom: 5.0, ..block(&["a", "b"], mat![[1.0, 0.5], [0.5, 1.0]], &[]) };
        joint.put(scatter).expect("found");
        assert!((joint.degrees_of_freedom("b") - 5.0).abs() < 1e-12);
        joint.put(block(&["c"], mat![[1.0]], &[("b", vec![1.0])])).expect("found");
        // Half of the variance has five: 2²/(1²/5).
        assert!((joint.degrees_of_freedom("c") - 20.0).abs() < 1e-12);
    }
}
