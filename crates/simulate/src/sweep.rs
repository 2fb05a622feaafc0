//! The same plan for many seeds or parameter values.

use common::Error;
use serde_json::Value;

use crate::Plan;

/// One value of a plan in several versions.
#[derive(Clone, Debug, PartialEq)]
pub struct Variation {
    /// Where it stands: `truth.model.effects[0].parameters.lag_s`.
    pub path: String,
    /// Its versions.
    pub values: Vec<Value>,
}

/// One campaign of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The seed; absent: the plan's.
    pub seed: Option<u64>,
    /// What is set, by path.
    pub set: Vec<(String, Value)>,
}

/// Every seed with every combination of values; the seed changes fastest.
pub fn cases(seeds: &[u64], variations: &[Variation]) -> Vec<Case> {
    let mut sets = vec![Vec::new()];
    for variation in variations {
        sets = sets
            .into_iter()
            .flat_map(|set: Vec<(String, Value)>| {
                variation.values.iter().map(move |value| {
                    let mut set = set.clone();
                    set.push((variation.path.clone(), value.clone()));
                    set
                })
            })
            .collect();
    }
    let seeds: Vec<Option<u64>> =
        if seeds.is_empty() { vec![None] } else { seeds.iter().copied().map(Some).collect() };
    sets.into_iter()
        .flat_map(|set| seeds.iter().map(move |seed| Case { seed: *seed, set: set.clone() }))
        .collect()
}

/// The plan of a case: the text's plan with what the case sets.
pub fn plan_of(text: &str, case: &Case) -> Result<Plan, Error> {
    let mut plan = if case.set.is_empty() {
        Plan::parse(text)?
    } else {
        let mut plan: Value = common::parse(text)?;
        for (path, value) in &case.set {
            *place(&mut plan, path)? = value.clone();
        }
        Plan::parse(&plan.to_string())?
    };
    plan.seed = case.seed.unwrap_or(plan.seed);
    Ok(plan)
}

/// The place of a path; a key that is not there yet is made, an index is not.
fn place<'a>(plan: &'a mut Value, path: &str) -> Result<&'a mut Value, Error> {
    let wrong = |part: &str| {
        Error::Request(format!(
            "--set {path}: the plan has no \"{part}\" there; give a path as in `truth.model.effects[0].parameters.lag_s`"
        ))
    };
    let mut here = plan;
    for part in path.replace('[', ".[").split('.') {
        here = match part.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            Some(index) => index
                .parse::<usize>()
                .ok()
                .and_then(|index| here.get_mut(index))
                .ok_or_else(|| wrong(part))?,
            None => here
                .as_object_mut()
                .filter(|_| !part.is_empty())
                .ok_or_else(|| wrong(part))?
                .entry(part)
                .or_insert(Value::Object(Default::default())),
        };
    }
    Ok(here)
}
