//! Residuals before and after along something, as a few points for plots.

use common::ResidualSeries;
use estimate::grouped::{Grouped, grouped};
use indexmap::IndexMap;

/// Most points of a series.
const POINTS: usize = 160;

/// What is drawn of some readings along one thing.
#[derive(Default)]
pub struct Drawn {
    /// What they are drawn along.
    pub x: Vec<f64>,
    /// The residual before and after, nT.
    pub before: Vec<f64>,
    /// See `before`.
    pub after: Vec<f64>,
    /// The readings, nT; empty where they are not drawn.
    pub recorded: Vec<f64>,
    /// By how much the residual is larger without an effect, with the effect's label, nT.
    pub contributions: Vec<(String, Vec<f64>)>,
}

impl Drawn {
    /// Adds what is drawn of other readings, of the same effects.
    pub fn append(&mut self, other: Self) {
        self.x.extend(other.x);
        self.before.extend(other.before);
        self.after.extend(other.after);
        self.recorded.extend(other.recorded);
        if self.contributions.is_empty() {
            self.contributions = other.contributions;
        } else {
            let pairs = self.contributions.iter_mut().zip(other.contributions);
            pairs.for_each(|((_, own), (_, other))| own.extend(other));
        }
    }

    /// Means of neighbours; None where all stand at one place.
    pub fn series(&self, recording: Option<String>, column: &str, along: &str) -> Option<ResidualSeries> {
        let recorded = Some(&self.recorded).filter(|recorded| !recorded.is_empty());
        let of_effects = self.contributions.iter().map(|(_, of)| of);
        let columns = [&self.before, &self.after].into_iter().chain(recorded).chain(of_effects);
        let columns: Vec<&[f64]> = columns.map(Vec::as_slice).collect();
        let Grouped { x, columns, points } = grouped(&self.x, &columns, POINTS)?;
        let mut columns = columns.into_iter();
        let mut next = || columns.next().unwrap_or_default();
        let (before_nt, after_nt) = (next(), next());
        let recorded_nt = if recorded.is_some() { next() } else { Vec::new() };
        // Several of one label are one contribution.
        let mut contributions_nt: IndexMap<String, Vec<f64>> = IndexMap::new();
        for ((label, _), values) in self.contributions.iter().zip(columns) {
            let sum = contributions_nt.entry(label.clone()).or_insert_with(|| vec![0.0; values.len()]);
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        }
        Some(ResidualSeries {
            recording,
            column: column.into(),
            along: along.into(),
            x,
            before_nt,
            after_nt,
            recorded_nt,
            contributions_nt,
            readings: points,
            ..ResidualSeries::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_column_keeps_its_place() {
        let one = |at: f64| Drawn {
            x: vec![at],
            before: vec![2.0],
            after: vec![1.0],
            recorded: vec![9.0],
            contributions: vec![("a".into(), vec![at]), ("b".into(), vec![-at])],
        };
        let mut drawn = one(1.0);
        drawn.append(one(2.0));
        let series = drawn.series(None, "sensor_x_nt", "time_s").expect("a series");
        assert_eq!(
            [series.recorded_nt, series.before_nt, series.after_nt].concat(),
            [9.0, 9.0, 2.0, 2.0, 1.0, 1.0]
        );
        assert_eq!(series.contributions_nt["b"], [-1.0, -2.0]);
        assert_eq!(one(1.0).series(None, "", ""), None);
    }
}
