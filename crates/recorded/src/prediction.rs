//! How well a part that was left out is predicted, by hand and by the programs.

use common::number;

/// The programs predict as well as a careful person by hand if what they leave is larger by no more than this
/// factor.
const WITHIN: f64 = 1.05;

/// What is left of a part that was left out, about its own mean, by hand and by the programs.
#[derive(Clone, Debug, Default)]
pub struct Prediction {
    /// Which part, in words; empty where the set has one.
    pub of: String,
    /// The way by hand of each component: the best on a part of what was fitted.
    pub ways: Vec<String>,
    /// What it leaves of each component, nT.
    pub by_hand_nt: Vec<f64>,
    /// What the programs leave, nT; None where they refuse.
    pub programs_nt: Option<Vec<f64>>,
    /// Why the programs leave more, in words; shown where they do, empty where nobody knows.
    pub why: String,
}

impl Prediction {
    /// What the programs leave over what is left by hand.
    fn ratios(&self) -> Option<Vec<f64>> {
        let programs = self.programs_nt.as_ref()?.iter();
        Some(programs.zip(&self.by_hand_nt).map(|(programs, hand)| programs / hand).collect())
    }

    /// Whether they predict each component as well.
    fn holds(&self) -> bool {
        self.ratios().is_some_and(|ratios| ratios.iter().all(|ratio| *ratio <= WITHIN))
    }

    /// A row of a table: the part, the way by hand, what is left by it and by the programs, the ratio, the
    /// verdict.
    fn row(&self, set: &str) -> Vec<String> {
        let each =
            |values: &[f64]| values.iter().map(|nt| number::figures(*nt, 3)).collect::<Vec<_>>().join("; ");
        let ratios =
            self.ratios().map(|all| all.iter().map(|ratio| format!("{ratio:.2}")).collect::<Vec<_>>());
        let mut ways = self.ways.clone();
        ways.dedup();
        vec![
            if self.of.is_empty() { set.to_string() } else { format!("{set} – {}", self.of) },
            ways.join("; "),
            each(&self.by_hand_nt),
            self.programs_nt.as_deref().map_or("refused".into(), each),
            ratios.map_or(String::new(), |ratios| ratios.join("; ")),
            match self.why.as_str() {
                _ if self.holds() => "yes".into(),
                "" => "**no**; the reason is not known".into(),
                why => format!("**no**: {why}"),
            },
        ]
    }
}

/// How many predictions hold of how many, and a row for each.
pub fn rows<'a>(sets: impl Iterator<Item = (&'a str, &'a [Prediction])>) -> ([usize; 2], Vec<Vec<String>>) {
    let (mut rows, mut hold) = (Vec::new(), 0);
    for (set, predictions) in sets {
        hold += predictions.iter().filter(|one| one.holds()).count();
        rows.extend(predictions.iter().map(|one| one.row(set)));
    }
    ([hold, rows.len()], rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prediction(programs: Option<[f64; 2]>) -> Prediction {
        Prediction {
            ways: vec!["matrix".into(), "matrix".into()],
            by_hand_nt: vec![2.0, 0.004],
            programs_nt: programs.map(Vec::from),
            why: "for a reason".into(),
            ..Prediction::default()
        }
    }

    #[test]
    fn the_verdict_is_that_of_the_worst_component() {
        assert!(prediction(Some([2.09, 0.004])).holds());
        assert!(!prediction(Some([1.0, 0.0043])).holds());
        assert!(!prediction(None).holds());
    }

    #[test]
    fn the_reason_stands_where_it_is_needed() {
        let all = [prediction(Some([2.0, 0.004])), prediction(Some([3.0, 0.004])), prediction(None)];
        let (count, rows) = rows([("a set", &all[..])].into_iter());
        assert_eq!(count, [1, 3]);
        assert_eq!(rows[0], ["a set", "matrix", "2.00; 0.00400", "2.00; 0.00400", "1.00; 1.00", "yes"]);
        assert_eq!(rows[1][4..], ["1.50; 1.00", "**no**: for a reason"]);
        assert_eq!(rows[2][3..], ["refused", "", "**no**: for a reason"]);
    }
}
