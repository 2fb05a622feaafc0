//! Cases: a host as it came, and a host with an effect added.

use concealed::case::{self, Case, TrueEffect, Truth};
use concealed::draw::Draw;
use concealed::effect::Effect;
use concealed::form;
use concealed::kinds::Single;
use concealed::scene::{AXES, Readings};
use concealed::sets::neutral;
use serde_json::json;

use crate::host::{Host, Watched};
use crate::suits;

/// Name of the set.
pub const SET: &str = "real";
/// Times the scatter of the host.
pub const STRENGTHS: [f64; 4] = [3.0, 1.0, 10.0, 0.3];
/// Sensors and moments that are drawn until an effect shows.
const TRIES: usize = 12;
/// Departure from the wanted strength that is accepted.
const CLOSE: f64 = 0.1;
/// Decimals of readings without codes of their own, nT.
const PRINTED_NT: f64 = 1e-6;

/// A host as it came: right is to claim nothing.
pub fn untouched(host: &Host, seed: u64) -> Case {
    let mut draw = Draw::new(&format!("real/{}/untouched", host.candidate.name), seed);
    let case = neutral(&format!("real/{seed}/{}", host.candidate.name));
    let truth = truth(host, case, (seed, 0, 0.0), Vec::new(), &mut draw);
    let mut document = host.document.clone();
    document["title"] = json!(truth.case);
    Case { document, truth }
}

/// Each kind that a host can carry once, the first `most` of an order that is drawn; strengths take turns.
/// Kinds that do not show in the host, or do not reach their strength, are left out by the rule of [`suits`].
pub fn injected(host: &Host, seed: u64, round: usize, most: usize) -> Vec<Case> {
    let name = host.candidate.name;
    let mut order = Draw::new(&format!("real/{name}/order/{round}"), seed);
    let mut kinds = suits::kinds_of(host);
    let mut cases = Vec::new();
    while cases.len() < most && !kinds.is_empty() {
        let kind = kinds.swap_remove(order.below(kinds.len()));
        let turn = cases.len() + round;
        let strength = STRENGTHS[turn % STRENGTHS.len()];
        let number = 1000 * round + cases.len() + 1;
        let mut draw = Draw::new(&format!("real/{name}/{}/{}/{round}", kind.name, kind.form), seed);
        cases.extend(with(host, &kind, (seed, number, strength), &mut draw));
    }
    cases
}

/// A host with an effect added.
fn with(
    host: &Host,
    kind: &Single,
    (seed, number, strength): (u64, usize, f64),
    draw: &mut Draw,
) -> Option<Case> {
    let made =
        (0..TRIES).map(|_| (kind.make)(&host.campaign, draw)).find(|effect| suits::shows(host, effect))?;
    let (effect, form_error) = form::inexact(kind.name, made, &host.campaign, draw);
    let added = |size: f64| (effect.act)(&host.campaign, &host.plain, size);
    let wanted = strength * host.scatter_nt;
    let size = case::sized(|size| host.size(&added(size)), wanted);
    let added = added(size);
    let left_nt = host.size(&added);
    if (left_nt / wanted - 1.0).abs() > CLOSE || !suits::stays(host, &added) {
        return None;
    }
    let told = TrueEffect {
        name: kind.name.into(),
        physics: effect.physics.into(),
        accepted: accepted(host, &effect),
        sensors: sensors(host, &effect),
        parameters: parameters(host, &effect, size),
        form_error,
        left_nt,
    };
    let case = neutral(&format!("real/{seed}/{}/{number}", host.candidate.name));
    let truth = truth(host, case, (seed, number, strength), vec![told], draw);
    Some(Case { document: document(host, &added, &truth.case), truth })
}

/// The names that are right. The length of a vector that points one way does not tell in which sensor
/// something is: there the same name is right on any of them and without one.
fn accepted(host: &Host, effect: &Effect) -> Vec<String> {
    if host.watched == Watched::Vectors {
        return effect.accepted.clone();
    }
    let mut all: Vec<String> = Vec::new();
    for name in &effect.accepted {
        let bare = name.split(' ').next().unwrap_or_default();
        all.push(bare.into());
        all.extend(AXES.map(|axis| format!("{bare} {axis}")));
    }
    all
}

fn sensors(host: &Host, effect: &Effect) -> Vec<String> {
    let own = effect.sensors.iter().filter(|_| host.watched == Watched::Vectors);
    own.map(|sensor| AXES[*sensor].to_string()).collect()
}

/// What the parameters should come out as; beside a scalar magnetometer those alone that say nothing of a
/// sensor's share of the field, which are those that do not grow with the size.
fn parameters(host: &Host, effect: &Effect, size: f64) -> serde_json::Map<String, serde_json::Value> {
    let (own, twice) = ((effect.parameters)(size), (effect.parameters)(2.0 * size));
    let fixed = |(own, twice): &(&(&str, f64), &(&str, f64))| own.1 == twice.1;
    let all = own.iter().zip(&twice).filter(|pair| host.watched == Watched::Vectors || fixed(pair));
    all.map(|((name, value), _)| (name.to_string(), json!(value))).collect()
}

/// The host's document with something added to its readings; those of an instrument that was read code by
/// code are codes again.
fn document(host: &Host, added: &Readings, title: &str) -> serde_json::Value {
    let code = if host.candidate.code_nt > 0.0 { host.candidate.code_nt } else { PRINTED_NT };
    let mut document = host.document.clone();
    document["title"] = json!(title);
    let columns = &mut document["recordings"][0]["columns"];
    for sensor in 0..AXES.len() {
        let readings = host.plain[0][sensor].iter().zip(&added[0][sensor]);
        let inverse = 1.0 / code;
        let rounded = |value: f64| (value * inverse).round() / inverse;
        // What nothing was added to stays as it was printed.
        let sum = readings.map(|(was, more)| if *more == 0.0 { *was } else { rounded(was + more) });
        columns[host.column(sensor)] = json!(sum.collect::<Vec<f64>>());
    }
    document
}

fn truth(
    host: &Host,
    case: String,
    (seed, number, strength): (u64, usize, f64),
    effects: Vec<TrueEffect>,
    draw: &mut Draw,
) -> Truth {
    Truth {
        case,
        set: SET.into(),
        seed,
        number,
        strength,
        length: "real".into(),
        covariates: "apart".into(),
        scene: host.candidate.name.into(),
        readings: host.readings(),
        recorded: Vec::new(),
        noise_nt: host.scatter_nt,
        effects,
        without: Vec::new(),
        nonce: case::nonce(draw),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up::{Beside, CANDIDATE, series};

    fn host(beside: &Beside) -> Host {
        Host::of(&CANDIDATE, &series(beside)).expect("a host")
    }

    /// Every case has its strength by the measure of the others, and a document that differs from the host's
    /// in the readings alone.
    #[test]
    fn an_effect_is_added_to_what_was_recorded() {
        for beside in [Beside::Vector, Beside::Scalar, Beside::Thermometer] {
            let host = host(&beside);
            let cases = injected(&host, 3, 0, 6);
            assert_eq!(cases.len(), 6);
            for Case { document, truth } in &cases {
                let [effect] = &truth.effects[..] else { panic!("one effect") };
                let times = effect.left_nt / host.scatter_nt;
                assert!((times / truth.strength - 1.0).abs() <= CLOSE, "{}: {times}", effect.name);
                let (mut ours, mut own) = (document.clone(), host.document.clone());
                assert_ne!(ours["recordings"], own["recordings"], "{}", effect.name);
                for sensor in 0..3 {
                    ours["recordings"][0]["columns"][host.column(sensor)] = json!(null);
                    own["recordings"][0]["columns"][host.column(sensor)] = json!(null);
                }
                assert_eq!(ours["recordings"], own["recordings"]);
                assert_eq!(ours["title"], truth.case.as_str());
            }
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_cases() {
        let host = host(&Beside::Scalar);
        let text =
            || injected(&host, 5, 1, 3).iter().map(|case| case.document.to_string()).collect::<String>();
        assert_eq!(text(), text());
        assert_ne!(untouched(&host, 5).truth.case, untouched(&host, 6).truth.case);
    }

    #[test]
    fn beside_a_scalar_the_name_counts_and_not_the_sensor() {
        let cases = injected(&host(&Beside::Scalar), 3, 0, 6);
        for effect in cases.iter().flat_map(|case| &case.truth.effects) {
            assert!(effect.sensors.is_empty());
            let names = |name: String| effect.accepted.contains(&name);
            assert!(
                names(effect.name.clone())
                    && AXES.iter().all(|axis| names(format!("{} {axis}", effect.name)))
            );
        }
    }
}
