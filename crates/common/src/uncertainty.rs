//! The joint uncertainty of all that is calibrated, `calibration.uncertainty`: independent sources, and how one standard deviation of each
//! moves the parameters.
//!
//! With the moves s of a source as a column over the parameters, their covariance is Σ s sᵀ: a root of it, which stays small and positive
//! whatever is added. A program that estimates parameters hands in a [`Block`]: their own covariance, and how they move with
//! the parameters that they were estimated with. By those derivatives every source that moves the latter moves the former. A program that uses
//! parameters takes the [`Uncertainty::root`] of what it makes of them. So what two parameters have in common stays in common, through any number of stages.

use indexmap::IndexMap;
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{AdoptedEffect, Axis, Document, Error, Extra, Recording};

mod stated;

/// A move that adds less than this share to a standard uncertainty is not kept.
const NEGLIGIBLE: f64 = 1e-9;
/// What is less than this share of a variance in a root is rounding.
const ROUNDING: f64 = 1e-14;
/// Two standard uncertainties that differ by less than this share are the same.
const SAME: f64 = 1e-6;

/// Independent sources of uncertainty and what they move.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
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
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Source {
    /// What it is. Sources of one name were estimated together, with one variance.
    pub name: String,
    /// Degrees of freedom of the variance of all sources of this name; absent: the variance is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degrees_of_freedom: Option<f64>,
    /// By how much one standard deviation of it moves each parameter, by the path of the parameter, in the parameter's unit.
    pub moves: IndexMap<String, f64>,
}

/// Quantities by how they move with parameters of the document: each parameter's path, with the derivative of every quantity by it.
pub type By = Vec<(String, Vec<f64>)>;

/// Parameters as a program estimates them.
#[derive(Clone, Debug, Default)]
pub struct Block {
    /// What their own covariance comes from.
    pub name: String,
    /// Degrees of freedom of its size; infinite: it is known.
    pub degrees_of_freedom: f64,
    /// The paths of the parameters.
    pub parameters: Vec<String>,
    /// Their covariance by what is new: the scatter of the readings.
    pub covariance: Vec<Vec<f64>>,
    /// The parameters that they were estimated with, each with the derivative of every parameter of the block by it.
    pub by: By,
}

impl Uncertainty {
    /// Of all that a document states with an uncertainty: what `calibration.uncertainty` says, and where a stated standard uncertainty
    /// is not (or no longer) the one that follows from it, what is stated, with the covariance that stands beside it.
    ///
    /// # Errors
    ///
    /// A stated covariance that none can be.
    pub fn of(document: &Document) -> Result<Self, Error> {
        let mut joint = document
            .calibration
            .as_ref()
            .and_then(|calibration| calibration.uncertainty.clone())
            .unwrap_or_default();
        for group in stated::groups(document)? {
            joint.state(group)?;
        }
        Ok(joint)
    }

    /// What is stated of parameters counts where it is not what the sources say.
    fn state(&mut self, group: stated::Group) -> Result<(), Error> {
        let std = |place: usize| group.covariance[place][place].max(0.0).sqrt();
        let largest = (0..group.parameters.len()).map(std).fold(0.0, f64::max);
        let anew: Vec<usize> = (0..group.parameters.len())
            .filter(|place| {
                let apart = (self.std(&group.parameters[*place]) - std(*place)).abs();
                apart > SAME * if group.alike { largest } else { std(*place) }
            })
            .collect();
        if anew.is_empty() {
            return Ok(());
        }
        // Of directions, one cosine that is not the same is another set of directions.
        let anew = if group.alike { (0..group.parameters.len()).collect() } else { anew };
        let block = Block {
            name: group.name,
            degrees_of_freedom: f64::INFINITY,
            parameters: anew.iter().map(|place| group.parameters[*place].clone()).collect(),
            covariance: anew
                .iter()
                .map(|a| anew.iter().map(|b| group.covariance[*a][*b]).collect())
                .collect(),
            by: Vec::new(),
        };
        self.put(block).map_err(|found| {
            let expected = "covariances no larger than the product of the two standard uncertainties";
            Error::document(group.path, found, expected)
        })
    }

    /// Takes parameters in as they were estimated, in place of what was known of them.
    ///
    /// # Errors
    ///
    /// What is wrong with the block's own covariance.
    pub fn put(&mut self, block: Block) -> Result<(), String> {
        let own = root(&block.covariance)?;
        // By the derivatives, from what the sources move before anything is forgotten.
        let carried: Vec<Vec<f64>> =
            self.sources.iter().map(|source| source.moves_of(&block.by, block.parameters.len())).collect();
        let std: Vec<f64> = (0..block.parameters.len())
            .map(|at| own.iter().chain(&carried).map(|moves| moves[at] * moves[at]).sum::<f64>().sqrt())
            .collect();
        self.forget(&block.parameters);
        let kept = |moves: Vec<f64>| -> Vec<(String, f64)> {
            let named = block.parameters.iter().cloned().zip(moves).zip(&std);
            named.filter(|((_, moved), std)| moved.abs() > NEGLIGIBLE * **std).map(|(pair, _)| pair).collect()
        };
        for (source, moves) in self.sources.iter_mut().zip(carried) {
            source.moves.extend(kept(moves));
        }
        let degrees_of_freedom = Some(block.degrees_of_freedom).filter(|freedom| freedom.is_finite());
        self.sources.extend(own.into_iter().map(|moves| Source {
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

    /// The effective degrees of freedom of a parameter's standard uncertainty (Welch and Satterthwaite, JCGM 100 G.4).
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

    /// For each source that moves one of the quantities, by how much it moves each.
    pub fn root(&self, by: &By) -> Vec<Vec<f64>> {
        let count = by.first().map_or(0, |(_, derivatives)| derivatives.len());
        let all = self.sources.iter().map(|source| source.moves_of(by, count));
        all.filter(|moves| moves.iter().any(|moved| *moved != 0.0)).collect()
    }

    /// The covariance of quantities.
    pub fn covariance_by(&self, by: &By) -> Vec<Vec<f64>> {
        let root = self.root(by);
        let count = by.first().map_or(0, |(_, derivatives)| derivatives.len());
        let entry = |a: usize, b: usize| root.iter().map(|moves| moves[a] * moves[b]).sum();
        (0..count).map(|a| (0..count).map(|b| entry(a, b)).collect()).collect()
    }

    /// The covariance of parameters.
    pub fn covariance(&self, parameters: &[String]) -> Vec<Vec<f64>> {
        let one = |at: usize| (0..parameters.len()).map(|other| f64::from(u8::from(other == at))).collect();
        self.covariance_by(&parameters.iter().enumerate().map(|(at, path)| (path.clone(), one(at))).collect())
    }
}

impl Source {
    /// By how much it moves each of `count` quantities.
    fn moves_of(&self, by: &By, count: usize) -> Vec<f64> {
        let mut moves = vec![0.0; count];
        for (path, derivatives) in by {
            if let Some(moved) = self.moves.get(path) {
                moves.iter_mut().zip(derivatives).for_each(|(sum, by)| *sum += by * moved);
            }
        }
        moves
    }
}

/// What the calculated field k I + B0 of a coil rests on in these recordings, by the changes of k and of B0 that one unit of each parameter acts like: constant and
/// offset, and where currents were read as voltages, resistor and voltmeter. Where one recording has currents, all count as known apart from
/// the constant.
pub fn drive<'r>(
    document: &Document,
    coil: Axis,
    k: f64,
    mut recordings: impl Iterator<Item = &'r Recording>,
) -> By {
    let mut by = vec![(coil_constant(coil), vec![1.0, 0.0]), (coil_offset(coil), vec![0.0, 1.0])];
    if !recordings.any(|recording| recording.axis_column("coil", coil, "a").is_some()) {
        by.extend(of_current(document, coil, k));
    }
    by
}

/// What a current that was read as a voltage rests on, I = V/R, and how it changes the calculated field k I + B0 of a coil: each parameter,
/// with the changes of k and of B0 that one unit of it acts like. A voltmeter that reads high by the share ε acts like k ε, a
/// resistance stated high by ρ like −k ρ/R, a voltmeter that adds v like k v/R on B0. Where the constant was measured with the same two, they
/// moved it the other way.
pub fn of_current(document: &Document, coil: Axis, k: f64) -> By {
    let coils = document.facility.as_ref().and_then(|facility| facility.coils.as_ref());
    let ohm = coils.and_then(|coils| coils.get(coil)).and_then(|of| of.resistor_ohm);
    let of = |ohm: f64| {
        [
            (VOLTMETER_RELATIVE.to_string(), vec![k, 0.0]),
            (resistor(coil), vec![-k / ohm, 0.0]),
            (VOLTMETER_ABSOLUTE.to_string(), vec![0.0, k / ohm]),
        ]
    };
    ohm.filter(|ohm| *ohm > 0.0).map(of).into_iter().flatten().collect()
}

/// Columns whose outer products add up to a covariance: Cholesky's factor with the largest variance first, until what is left is
/// rounding.
///
/// # Errors
///
/// What is wrong with it.
pub fn root(covariance: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, String> {
    let count = covariance.len();
    if covariance.iter().flatten().any(|value| !value.is_finite()) {
        return Err("a covariance that is not finite".into());
    }
    let variance: Vec<f64> = (0..count).map(|at| covariance[at][at]).collect();
    let mut left = covariance.to_vec();
    let mut columns = Vec::new();
    let share =
        |left: &[Vec<f64>], at: usize| if variance[at] > 0.0 { left[at][at] / variance[at] } else { 0.0 };
    while columns.len() < count {
        let Some(pivot) = (0..count).max_by(|a, b| share(&left, *a).total_cmp(&share(&left, *b))) else {
            break;
        };
        if share(&left, pivot) <= ROUNDING {
            break;
        }
        let scale = left[pivot][pivot].sqrt();
        let column: Vec<f64> = (0..count).map(|row| left[row][pivot] / scale).collect();
        for a in 0..count {
            for b in 0..count {
                left[a][b] -= column[a] * column[b];
            }
        }
        columns.push(column);
    }
    let beyond = |a: usize, b: usize| {
        left[a][b].abs() > SAME * (variance[a] * variance[b]).max(0.0).sqrt() && left[a][b] != 0.0
    };
    if (0..count).any(|a| (0..count).any(|b| beyond(a, b))) {
        return Err("a covariance that cannot be".into());
    }
    Ok(columns)
}

/// The path of the share by which the voltmeter reads high.
pub const VOLTMETER_RELATIVE: &str = "facility.voltmeter.relative";
/// The path of what the voltmeter adds.
pub const VOLTMETER_ABSOLUTE: &str = "facility.voltmeter.absolute_v";

/// The path of a coil's precision resistor.
pub fn resistor(coil: Axis) -> String {
    format!("facility.coils.{coil}.resistor_ohm")
}

/// The path of a coil's gradient.
pub fn gradient(coil: Axis) -> String {
    format!("facility.coils.{coil}.gradient_nt_per_m_a")
}

/// The path of a coordinate of a sensor's place.
pub fn place(sensor: Axis, k: usize) -> String {
    format!("instrument.positions_m.{sensor}[{k}]")
}

/// The path of a coil's constant.
pub fn coil_constant(coil: Axis) -> String {
    format!("calibration.coils.{coil}.constant_nt_per_a")
}

/// The path of a coil's offset.
pub fn coil_offset(coil: Axis) -> String {
    format!("calibration.coils.{coil}.offset_nt")
}

/// The path of a sensor's sensitivity, `unit` being `v` or `nt`.
pub fn sensitivity(sensor: Axis, unit: &str) -> String {
    format!("calibration.sensors.{sensor}.sensitivity_nt_per_{unit}")
}

/// The path of a sensor's offset.
pub fn sensor_offset(sensor: Axis) -> String {
    format!("calibration.sensors.{sensor}.offset_nt")
}

/// The path of what axescal adds to a sensor's offset; the sources move the sum.
pub fn added_offset(sensor: Axis) -> String {
    format!("calibration.axes.offsets_nt.{sensor}")
}

/// The path of a component of the residual field; the sources move its sum with the offset of the coil.
pub fn residual_field(axis: Axis) -> String {
    format!("calibration.axes.residual_field_nt.{axis}")
}

/// The paths of the nine cosines of the directions of `sensors` or `coils`, column by column.
pub fn directions(of: &str) -> Vec<String> {
    (0..9).map(|k| format!("calibration.axes.{of}.matrix[{}][{}]", k % 3, k / 3)).collect()
}

/// The path of a parameter of an effect of the model, by what the effect is and what it belongs to, not by its place in the list. Of two that
/// happen in one sensor the moments tell which is which.
pub fn effect(effect: &AdoptedEffect, parameter: &str) -> String {
    let axis = effect.sensor.or(effect.coil).map(|axis| format!(" {axis}")).unwrap_or_default();
    let of = |what: &Option<String>| what.as_ref().map(|name| format!(" {name}")).unwrap_or_default();
    let times =
        [effect.from_s, effect.to_s].map(|time| time.map(|t| format!(" {t}")).unwrap_or_default()).concat();
    let moment =
        effect.parameters.get("time_s").map(|time| format!(" at {}", time.value())).unwrap_or_default();
    format!(
        "model.effects[{}{axis}{}{}{times}{moment}].{parameter}",
        effect.effect,
        of(&effect.column),
        of(&effect.recording)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_string()).collect()
    }

    fn block(names: &[&str], covariance: Vec<Vec<f64>>, by: &[(&str, Vec<f64>)]) -> Block {
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
        joint.put(block(&["coil"], vec![vec![4.0]], &[])).expect("found");
        joint.put(block(&["a"], vec![vec![1.0]], &[("coil", vec![0.5])])).expect("found");
        joint.put(block(&["b"], vec![vec![9.0]], &[("coil", vec![-1.0])])).expect("found");
        // a = own + coil/2, b = own − coil.
        assert_eq!(joint.covariance(&paths(&["a", "b"])), [[2.0, -2.0], [-2.0, 13.0]]);
        // c = a + b/2: by either way from the coil, one half less one half is nothing.
        joint.put(block(&["c"], vec![vec![0.0]], &[("a", vec![1.0]), ("b", vec![0.5])])).expect("found");
        assert!((joint.std("c").powi(2) - (1.0 + 9.0 / 4.0)).abs() < 1e-12);
    }

    #[test]
    fn a_parameter_that_is_estimated_again_with_itself_keeps_its_sources() {
        let mut joint = Uncertainty::default();
        joint.put(block(&["k"], vec![vec![4.0]], &[])).expect("found");
        joint.put(block(&["k"], vec![vec![0.25]], &[("k", vec![0.5])])).expect("found");
        assert!((joint.std("k").powi(2) - 1.25).abs() < 1e-12);
        joint.put(block(&["k"], vec![vec![0.25]], &[])).expect("found");
        assert_eq!(joint.sources.len(), 1);
    }

    #[test]
    fn a_root_is_one_of_the_covariance_also_where_it_is_short_of_rank() {
        let columns = [[1.0, 2.0, -1.0], [0.5, 0.0, 3.0]];
        let covariance: Vec<Vec<f64>> =
            (0..3).map(|a| (0..3).map(|b| columns.iter().map(|c| c[a] * c[b]).sum()).collect()).collect();
        let root = root(&covariance).expect("found");
        assert_eq!(root.len(), 2);
        for a in 0..3 {
            for b in 0..3 {
                let again: f64 = root.iter().map(|column| column[a] * column[b]).sum();
                assert!((again - covariance[a][b]).abs() < 1e-12);
            }
        }
        assert!(super::root(&[vec![1.0, 2.0], vec![2.0, 1.0]]).is_err());
    }

    #[test]
    fn degrees_of_freedom_of_one_name_go_together() {
        let mut joint = Uncertainty::default();
        let scatter = Block {
            degrees_of_freedom: 5.0,
            ..block(&["a", "b"], vec![vec![1.0, 0.5], vec![0.5, 1.0]], &[])
        };
        joint.put(scatter).expect("found");
        assert!((joint.degrees_of_freedom("b") - 5.0).abs() < 1e-12);
        joint.put(block(&["c"], vec![vec![1.0]], &[("b", vec![1.0])])).expect("found");
        // Half of the variance has five: 2²/(1²/5).
        assert!((joint.degrees_of_freedom("c") - 20.0).abs() < 1e-12);
    }
}
