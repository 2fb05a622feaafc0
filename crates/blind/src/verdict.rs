//! What an answer claims, held against the truth.

use concealed::case::{TrueEffect, Truth};
use serde::Serialize;
use serde_json::Value;

/// Half the width of an interval of 95 %, in standard uncertainties.
pub const HALF_95: f64 = 1.959_964;

/// What came of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// All that was concealed is named, and nothing else; where nothing was, nothing is claimed; where the
    /// catalogue has no name, structure is told and no name given.
    Right,
    /// What was concealed is among the effects that are indistinguishable, and nothing else is claimed.
    InSet,
    /// A part of what was concealed is named, and nothing else.
    Incomplete,
    /// Structure is told, and no name given, though the catalogue has one.
    Unexplained,
    /// Nothing is said.
    Missed,
    /// Beside what is right, or alone, a set of effects is told of which none is there.
    WrongSet,
    /// An effect is named that is not there.
    Wrong,
}

impl Class {
    /// All of them, the best first.
    pub const ALL: [Class; 7] = [
        Class::Right,
        Class::InSet,
        Class::Incomplete,
        Class::Unexplained,
        Class::Missed,
        Class::WrongSet,
        Class::Wrong,
    ];

    /// In a word or two.
    pub fn words(self) -> &'static str {
        match self {
            Class::Right => "right",
            Class::InSet => "in the ambiguity set",
            Class::Incomplete => "some of them",
            Class::Unexplained => "unexplained",
            Class::Missed => "not seen",
            Class::WrongSet => "a wrong set told as undecided",
            Class::Wrong => "wrong name",
        }
    }
}

/// A parameter of an effect named rightly.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sized {
    /// The effect and the parameter.
    pub name: String,
    /// By how much it is off, in units in which half of the interval of 95 % is [`HALF_95`].
    pub off: f64,
    /// Whether its uncertainty is stated as a lower bound.
    pub at_least: bool,
}

/// An answer in short.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// What was concealed.
    pub truth: Truth,
    /// The answer's verdict.
    pub verdict: String,
    /// For each effect of the answer the names that are indistinguishable; one, where it is named.
    pub claims: Vec<Vec<String>>,
    /// What it comes to.
    pub class: Class,
    /// Whether the place is right; None where nothing was concealed or nothing is told.
    pub located: Option<bool>,
    /// Of each name that is given: its printed probability, and whether it is right.
    pub names: Vec<(f64, bool)>,
    /// Of each parameter of effects named rightly, how it lies to its interval.
    pub parameters: Vec<Sized>,
    /// Rms before, after, and of readings left out after, nT.
    pub rms_nt: [f64; 3],
}

impl Outcome {
    /// Of an answered document.
    pub fn of(truth: Truth, answer: &Value) -> Self {
        let entry = &answer["diagnosis"][0];
        let claims = claims(entry);
        let verdict = entry["verdict"].as_str().unwrap_or("none").to_string();
        let class = classify(&truth, &verdict, &claims);
        let fit = |key: &str| entry["fit"][key].as_f64().unwrap_or(f64::NAN);
        Self {
            class,
            located: located(&truth, entry),
            names: names(&truth, entry),
            parameters: if class == Class::Right { parameters(&truth, entry) } else { Vec::new() },
            rms_nt: [fit("rms_before_nt"), fit("rms_after_nt"), fit("held_out_after_nt")],
            verdict,
            claims,
            truth,
        }
    }

    /// Rms of readings left out over that of the noise which was drawn.
    pub fn over_floor(&self) -> f64 {
        self.rms_nt[2] / self.truth.noise_nt
    }

    /// What is claimed, in words.
    pub fn said(&self) -> String {
        if self.claims.is_empty() {
            return self.verdict.replace('_', " ");
        }
        let claims: Vec<String> = self.claims.iter().map(|names| names.join(" or ")).collect();
        format!("{}: {}", self.verdict.replace('_', " "), claims.join("; "))
    }
}

/// Name and target of an effect in an answer.
fn named(effect: &Value) -> String {
    let name = effect["effect"].as_str().unwrap_or_default();
    if name == "dependence" {
        let of = |key: &str| effect[key].as_str().unwrap_or_default().to_string();
        return format!("dependence of {} on {}", of("sensor"), of("column"));
    }
    let target = ["sensor", "coil", "column"].iter().find_map(|key| effect[*key].as_str());
    target.map_or_else(|| name.to_string(), |target| format!("{name} {target}"))
}

/// For each effect of an answer the names that are indistinguishable. The list of sets goes through the
/// effects in order, and each begins with the effect's own name.
fn claims(entry: &Value) -> Vec<Vec<String>> {
    let effects = entry["effects"].as_array().map(|effects| effects.iter().map(named).collect::<Vec<_>>());
    let bare = |name: &str| name.split(" in \"").next().unwrap_or_default().to_string();
    let sets: Vec<String> = entry["ambiguity"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|set| {
            let members: Vec<String> = set.as_array()?.iter().filter_map(|m| m.as_str().map(bare)).collect();
            Some(members.join(" with "))
        })
        .collect();
    let mut claims: Vec<Vec<String>> =
        effects.unwrap_or_default().into_iter().map(|name| vec![name]).collect();
    let mut open: Option<usize> = None;
    for member in sets {
        let begins = claims.iter().position(|names| names.len() == 1 && names[0] == member);
        match (begins, open) {
            (Some(effect), _) if open.is_none_or(|at| effect > at) => open = Some(effect),
            (_, Some(effect)) => claims[effect].push(member),
            _ => claims.push(vec![member]),
        }
    }
    claims
}

fn classify(truth: &Truth, verdict: &str, claims: &[Vec<String>]) -> Class {
    let mut unmatched: Vec<&TrueEffect> = truth.effects.iter().filter(|e| !e.accepted.is_empty()).collect();
    let expected = unmatched.len();
    let (mut undecided, mut worst) = (false, Class::Right);
    // What is named comes first, so that a set does not take the truth away from a name.
    let (named, sets): (Vec<_>, Vec<_>) = claims.iter().partition(|names| names.len() == 1);
    for names in named.into_iter().chain(sets) {
        let right = unmatched.iter().position(|e| names.iter().any(|name| e.accepted.contains(name)));
        match right {
            Some(which) => {
                let effect = unmatched.remove(which);
                // A set of right names alone is right, but where the point is that they cannot be told apart.
                undecided |= !names.iter().all(|name| effect.accepted.contains(name));
                undecided |= names.len() > 1 && truth.set == "ambiguous";
            }
            // A second name for what is named already, such as a second bit of the same converter.
            None if names.iter().all(|name| truth.effects.iter().any(|e| e.accepted.contains(name))) => {}
            None if names.len() == 1 => worst = worst.max(Class::Wrong),
            None => worst = worst.max(Class::WrongSet),
        }
    }
    if worst != Class::Right {
        return worst;
    }
    let silent = |told: Class| if verdict == "unexplained" { told } else { Class::Missed };
    match (expected, unmatched.len()) {
        (0, _) if truth.effects.is_empty() => {
            if verdict == "agrees" {
                Class::Right
            } else {
                Class::WrongSet
            }
        }
        (0, _) => silent(Class::Right),
        (_, 0) if undecided => Class::InSet,
        (_, 0) => Class::Right,
        (expected, left) if left == expected => silent(Class::Unexplained),
        _ => Class::Incomplete,
    }
}

/// Whether the places of an answer are the sensors that show it, or, for what is in the field, GEO or more
/// than one sensor.
fn located(truth: &Truth, entry: &Value) -> Option<bool> {
    let places = entry["where"].as_array().filter(|places| !places.is_empty())?;
    if truth.effects.is_empty() {
        return None;
    }
    let sensors = |place: &Value| -> Vec<String> {
        let list = place["sensors"].as_array().into_iter().flatten();
        list.filter_map(|sensor| sensor.as_str().map(str::to_string)).collect()
    };
    let mut told: Vec<String> = places.iter().flat_map(&sensors).collect();
    told.sort();
    told.dedup();
    let everywhere = places.iter().any(|place| sensors(place).is_empty());
    let mut own: Vec<&String> = truth.effects.iter().flat_map(|effect| &effect.sensors).collect();
    own.sort();
    own.dedup();
    let field = truth.effects.iter().any(|effect| effect.sensors.is_empty());
    Some(match field {
        true => everywhere || told.len() > 1,
        false => !everywhere && told.iter().eq(own),
    })
}

fn names(truth: &Truth, entry: &Value) -> Vec<(f64, bool)> {
    let one = |effect: &Value| {
        let name = named(effect);
        let right = truth.effects.iter().any(|own| own.accepted.contains(&name));
        Some((effect["probability"].as_f64()?, right))
    };
    entry["effects"].as_array().into_iter().flatten().filter_map(one).collect()
}

fn parameters(truth: &Truth, entry: &Value) -> Vec<Sized> {
    let mut all = Vec::new();
    for effect in entry["effects"].as_array().into_iter().flatten() {
        let name = named(effect);
        let Some(own) = truth.effects.iter().find(|own| own.accepted.contains(&name)) else { continue };
        for (parameter, value) in &own.parameters {
            let found = &effect["parameters"][parameter];
            let Some(off) = value.as_f64().and_then(|value| off(found, value)) else { continue };
            let name = format!("{}.{parameter}", effect["effect"].as_str().unwrap_or_default());
            all.push(Sized { name, off, at_least: found["at_least"] == true });
        }
    }
    all
}

/// By how much a quantity is off the truth, half of its interval of 95 % being [`HALF_95`]: as it is stated,
/// else by its coverage factor.
fn off(found: &Value, truth: f64) -> Option<f64> {
    let (value, std) = (found["value"].as_f64()?, found["std"].as_f64()?);
    let end = found["interval_95"][usize::from(truth > value)].as_f64();
    let half = end.map_or_else(
        || std * found["coverage_factor_95"].as_f64().unwrap_or(HALF_95),
        |end| (end - value).abs(),
    );
    Some((value - truth) / half * HALF_95)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn truth(accepted: &[&[&str]]) -> Truth {
        let effects = accepted.iter().map(|names| {
            json!({"name": "a", "physics": "", "accepted": names, "sensors": ["x"], "parameters": {"c": 1.0}, "left_nt": 1.0})
        });
        serde_json::from_value(json!({"case": "a", "set": "single", "seed": 1, "number": 0, "strength": 1.0, "length": "short",
            "covariates": "apart", "scene": "", "readings": 9, "noise_nt": 0.3, "effects": effects.collect::<Vec<_>>(),
            "nonce": ""}))
        .expect("a truth")
    }

    fn class(truth: Truth, verdict: &str, effects: Value, ambiguity: Value) -> Class {
        let entry = json!({"verdict": verdict, "effects": effects, "ambiguity": ambiguity});
        Outcome::of(truth, &json!({"diagnosis": [entry]})).class
    }

    fn lag(sensor: &str) -> Value {
        json!({"effect": "delay", "sensor": sensor, "probability": 0.97, "parameters": {"c": {"value": 1.1, "std": 0.06}}})
    }

    #[test]
    fn one_effect() {
        let one = || truth(&[&["delay x", "loop_bandwidth x"]]);
        assert_eq!(class(one(), "explained", json!([lag("x")]), json!([])), Class::Right);
        assert_eq!(class(one(), "explained", json!([lag("y")]), json!([])), Class::Wrong);
        assert_eq!(class(one(), "explained", json!([lag("x"), lag("z")]), json!([])), Class::Wrong);
        assert_eq!(class(one(), "agrees", json!([]), json!([])), Class::Missed);
        assert_eq!(class(one(), "unexplained", json!([]), json!([])), Class::Unexplained);
        let set = json!([["delay x"], ["spike x in \"run-1\""]]);
        assert_eq!(class(one(), "ambiguous", json!([lag("x")]), set), Class::InSet);
        let set = json!([["delay y"], ["spike y in \"run-1\""]]);
        assert_eq!(class(one(), "ambiguous", json!([lag("x"), lag("y")]), set), Class::WrongSet);
    }

    #[test]
    fn two_effects() {
        let two = || truth(&[&["delay x"], &["delay y"]]);
        assert_eq!(class(two(), "explained", json!([lag("y"), lag("x")]), json!([])), Class::Right);
        assert_eq!(class(two(), "partly_explained", json!([lag("y")]), json!([])), Class::Incomplete);
    }

    #[test]
    fn nothing_and_nothing_with_a_name() {
        assert_eq!(class(truth(&[]), "agrees", json!([]), json!([])), Class::Right);
        assert_eq!(class(truth(&[]), "unexplained", json!([]), json!([])), Class::WrongSet);
        assert_eq!(class(truth(&[&[]]), "unexplained", json!([]), json!([])), Class::Right);
        assert_eq!(class(truth(&[&[]]), "agrees", json!([]), json!([])), Class::Missed);
        assert_eq!(class(truth(&[&[]]), "explained", json!([lag("x")]), json!([])), Class::Wrong);
    }

    #[test]
    fn parameters_and_names_are_held_against_the_truth() {
        let entry = json!({"verdict": "explained", "effects": [lag("x")], "where": [{"sensors": ["x"]}]});
        let outcome = Outcome::of(truth(&[&["delay x"]]), &json!({"diagnosis": [entry]}));
        assert!(outcome.parameters.len() == 1 && (outcome.parameters[0].off - 0.1 / 0.06).abs() < 1e-9);
        assert_eq!(outcome.names, [(0.97, true)]);
        assert_eq!(outcome.located, Some(true));
    }
}
