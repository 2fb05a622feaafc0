//! Whether printed probabilities hold: of the names given with some probability that share must be right, and
//! intervals of some level must hold as often.

use std::collections::BTreeMap;

use crate::verdict::{HALF_95, Outcome};
use crate::wilson::Share;

/// Edges of the classes of probabilities of names.
const EDGES: [f64; 5] = [0.5, 0.9, 0.99, 0.999, 1.0];
/// Levels of intervals, with half their width in standard uncertainties.
const LEVELS: [(f64, f64); 4] = [(0.5, 0.674_490), (0.9, 1.644_854), (0.95, HALF_95), (0.99, 2.575_829)];
/// The least and the most probability that a logarithmic score takes: one wrong name is not all that counts.
const SUREST: f64 = 0.999;

/// Names whose probability was in a class: from and to, its mean, and how many were right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Class {
    /// The least probability.
    pub from: f64,
    /// The largest.
    pub to: f64,
    /// Mean of those printed.
    pub mean: f64,
    /// How many of the names are right.
    pub right: Share,
}

/// Names by the probability that was printed, classes without any left out.
pub fn of_names<'o>(outcomes: impl Iterator<Item = &'o Outcome>) -> Vec<Class> {
    let all: Vec<(f64, bool)> = outcomes.flat_map(|outcome| outcome.names.iter().copied()).collect();
    let class = |number: usize| {
        let (from, to) = (if number == 0 { 0.0 } else { EDGES[number - 1] }, EDGES[number]);
        let own: Vec<&(f64, bool)> =
            all.iter().filter(|(p, _)| *p >= from && (*p < to || to == EDGES[EDGES.len() - 1])).collect();
        let mean = own.iter().map(|(p, _)| p).sum::<f64>() / own.len() as f64;
        Class { from, to, mean, right: Share::of(own, |(_, right)| *right) }
    };
    (0..EDGES.len()).map(class).filter(|class| class.right.trials > 0).collect()
}

/// How often intervals of the parameters hold, level by level; those that are stated as lower bounds apart.
pub fn of_intervals<'o>(outcomes: impl Iterator<Item = &'o Outcome>) -> Vec<(f64, Share)> {
    let parameters = outcomes.flat_map(|outcome| &outcome.parameters);
    let off: Vec<f64> = parameters.filter(|one| !one.at_least).map(|one| one.off).collect();
    LEVELS.map(|(level, half)| (level, Share::of(&off, |off| off.abs() <= half))).to_vec()
}

/// How often intervals of 95 % hold, parameter by parameter, and whether their uncertainties are stated as
/// lower bounds; the farthest of each.
pub fn by_parameter<'o>(
    outcomes: impl Iterator<Item = &'o Outcome>,
) -> BTreeMap<(bool, &'o str), (Share, f64)> {
    let mut all: BTreeMap<(bool, &str), (Share, f64)> = BTreeMap::new();
    for one in outcomes.flat_map(|outcome| &outcome.parameters) {
        let (share, farthest) = all.entry((one.at_least, &one.name)).or_default();
        share.trials += 1;
        share.hits += usize::from(one.off.abs() <= HALF_95);
        if one.off.abs() > farthest.abs() {
            *farthest = one.off;
        }
    }
    all
}

/// Mean of −ln of the probability that was given to what is true, over names; None where no name was given.
/// ln 2 is a guess.
pub fn logarithmic_score<'o>(outcomes: impl Iterator<Item = &'o Outcome>) -> Option<f64> {
    let loss = |(p, right): &(f64, bool)| {
        let p = p.clamp(1.0 - SUREST, SUREST);
        -(if *right { p } else { 1.0 - p }).ln()
    };
    let all: Vec<f64> =
        outcomes.flat_map(|outcome| outcome.names.iter().map(loss).collect::<Vec<_>>()).collect();
    (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
}

/// The same as two tables and a sentence.
pub fn section<'o>(outcomes: impl Iterator<Item = &'o Outcome> + Clone) -> String {
    let mut text = String::from(
        "## Calibration of the probabilities\n\n| names printed with | mean of what was printed | right |\n| --- | --- | --- |\n",
    );
    for class in of_names(outcomes.clone()) {
        text +=
            &format!("| {} to {} | {:.4} | {} |\n", class.from, class.to, class.mean, class.right.words());
    }
    if let Some(score) = logarithmic_score(outcomes.clone()) {
        text += &format!(
            "\nLogarithmic score {score:.3}: the mean of −ln of the probability given to the truth; a guess at one half has 0.693. Every \
            name of every answer counts, including those of ambiguous answers.\n"
        );
    }
    text += "\n| intervals of parameters | hold |\n| --- | --- |\n";
    for (level, share) in of_intervals(outcomes) {
        text += &format!("| {:.0} % | {} |\n", 100.0 * level, share.words());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::Sized;
    use serde_json::json;

    fn outcome(names: &[(f64, bool)], parameters: &[f64]) -> Outcome {
        let truth = serde_json::from_value(
            json!({"case": "a", "set": "single", "seed": 1, "number": 0, "strength": 1.0,
            "length": "short", "covariates": "apart", "scene": "", "readings": 9, "noise_nt": 0.3, "effects": [],
            "baselines": [[], []], "nonce": ""}),
        );
        let outcome = Outcome::of(truth.expect("a truth"), &json!({"diagnosis": [{}]}));
        let parameters =
            parameters.iter().map(|off| Sized { name: "lag.lag_s".into(), off: *off, at_least: *off > 9.0 });
        Outcome { names: names.to_vec(), parameters: parameters.collect(), ..outcome }
    }

    #[test]
    fn names_fall_in_classes_and_intervals_in_levels() {
        let all = [outcome(&[(0.95, true), (0.97, false), (1.0, true)], &[0.1, -1.8, 3.0, 10.0])];
        let classes = of_names(all.iter());
        assert_eq!(classes.len(), 2);
        assert_eq!((classes[0].from, classes[0].right), (0.9, Share { hits: 1, trials: 2 }));
        assert_eq!((classes[1].from, classes[1].right), (0.999, Share { hits: 1, trials: 1 }));
        let held: Vec<usize> = of_intervals(all.iter()).iter().map(|(_, share)| share.hits).collect();
        assert_eq!(held, [1, 1, 2, 2]);
        let by_name: Vec<_> = by_parameter(all.iter()).into_values().collect();
        assert_eq!(by_name, [(Share { hits: 2, trials: 3 }, 3.0), (Share { hits: 0, trials: 1 }, 10.0)]);
    }

    #[test]
    fn a_sure_name_that_is_right_costs_little_and_a_wrong_one_much() {
        let score = |p, right| logarithmic_score([outcome(&[(p, right)], &[])].iter()).expect("a name");
        assert!((score(0.9, true) - 0.105).abs() < 1e-3 && (score(0.9, false) - 2.303).abs() < 1e-3);
        assert!((score(1.0, false) - 1000.0_f64.ln()).abs() < 1e-9);
    }
}
