//! What the weighed sets say: which names, how sure, what share, and what the others lack.

use common::Verdict;
use common::number::{probability, significant};

use estimate::stats::chi_squared_quantile;

use crate::Error;
use crate::atoms::{Atom, Atoms, Thing};
use crate::course::additions;
use crate::decide::{CRUMB, EXPLAINED, OF_THE_REST, PARTLY, SURE, TEMPERATURE};
use crate::level::{Rest, at_least_one};
use crate::model::Model;
use crate::search::{Addition, Proposal};
use crate::sets::{Member, Set, Sets};

/// Most names that are told as undecided.
const UNDECIDED: usize = 6;
/// Probability by chance at which a further unknown of a fuller form is needed.
const NEEDED: f64 = 0.01;
/// Sets whose log probability is behind the best by no more are fitted again with the calibration, and so many of them at most.
const NEARLY: f64 = 15.0;
const REFITTED: usize = 5;
/// Rivals that are told of a name.
const RIVALS: usize = 5;

/// A name of the answer.
#[derive(Clone, Debug)]
pub struct Name {
    /// The name with its target.
    pub name: String,
    /// What comes in.
    pub additions: Vec<Addition>,
    /// Whether it touches few rows.
    pub local: bool,
    /// Probability of the name.
    pub probability: f64,
    /// Probability of such a gain by chance, all that was searched counted.
    pub p: f64,
    /// Share of what can be explained.
    pub share: f64,
    /// Names that explain as well.
    pub equal: Vec<String>,
    /// Others, and why they lost.
    pub lost: Vec<(String, String)>,
}

/// The answer of a search.
#[derive(Clone, Debug)]
pub struct Answer {
    /// What it comes to.
    pub verdict: Verdict,
    /// The names of the best set, one of each that are undecided.
    pub names: Vec<Name>,
    /// What looked like an answer, and why it is none.
    pub refused: Vec<(String, String)>,
    /// Moments, lines and codes in what the best set leaves.
    pub events: Vec<Proposal>,
    /// What other sets that are nearly as probable hold.
    pub rivals: Vec<Vec<Addition>>,
}

/// Weights of the sets, the evidence tempered, adding up to one.
fn weights(ranked: &[Set]) -> Vec<f64> {
    let most = ranked.first().map_or(0.0, |set| set.log);
    // That nothing is there was judged before, by all that was searched.
    let weight =
        |set: &Set| if set.members.is_empty() { 0.0 } else { ((set.log - most) / TEMPERATURE).exp() };
    let raw: Vec<f64> = ranked.iter().map(weight).collect();
    let sum: f64 = raw.iter().sum();
    raw.into_iter().map(|weight| weight / sum).collect()
}

/// The answer of ranked sets.
pub fn answer(
    model: &Model<'_>,
    atoms: &Atoms<'_>,
    sets: &Sets<'_, '_, '_>,
    ranked: &[Set],
    rest: Rest,
) -> Result<Answer, Error> {
    let weights = weights(ranked);
    let Some(best) = ranked.first().map(|set| simplest(atoms, sets, ranked, set)) else {
        return Ok(Answer {
            verdict: Verdict::Unexplained,
            names: Vec::new(),
            refused: Vec::new(),
            events: Vec::new(),
            rivals: Vec::new(),
        });
    };
    let whole = rest.sum_of_squares;
    let all = sets.gain(&best.members);
    let beyond = rest.excess(whole - all);
    let explicable = (all + beyond).max(f64::MIN_POSITIVE);
    let coefficients = sets.coefficients(&best.members).unwrap_or_default();
    let gains: Vec<f64> =
        (0..best.members.len()).map(|number| all - sets.gain(&best.without(number))).collect();
    let mut names = Vec::new();
    let mut refused = Vec::new();
    let mut kept: Vec<Member> = Vec::new();
    let mut undecided = false;
    for (number, member) in best.members.iter().enumerate() {
        let atom = &atoms.all[member.atom];
        if !atom.is_named() {
            continue;
        }
        let slot = Slot::of(atoms, ranked, &weights, member.atom);
        let gain = gains[number];
        if let Some(of) = crumb_of(atoms, sets, &best.members, &gains, number, beyond) {
            let why = format!(
                "it says no more than the form of {} leaves: {} of what they explain together",
                of.0,
                significant(of.1, 2)
            );
            refused.push((atom.name.clone(), why));
            continue;
        }
        let rank = coefficients.get(number).map_or(1, Vec::len);
        let p = at_least_one(rest.p(gain, rank), (-member_prior(atom)).exp());
        if slot.equal.is_none() {
            let why = format!(
                "its probability is {}, and that of structure without a name the rest",
                significant(slot.probability, 2)
            );
            refused.push((atom.name.clone(), why));
            continue;
        }
        let equal = slot.equal.unwrap_or_default();
        undecided |= !equal.is_empty();
        kept.push(member.clone());
        names.push(Name {
            name: atom.name.clone(),
            additions: additions(model, &atom.thing, &atom.shapes[member.shape], &coefficients[number]),
            local: is_local(atom),
            probability: slot.probability,
            p,
            share: gain / explicable,
            equal,
            lost: lost(atoms, best, ranked, member.atom),
        });
    }
    // What a form leaves counts as what its effect explains; what structure could explain as well does not, unless that is a mere crumb.
    let nameless =
        |number: &usize| !atoms.all[best.members[*number].atom].is_named() && gains[*number] > CRUMB * all;
    let nameless: Vec<Member> =
        (0..best.members.len()).filter(nameless).map(|number| best.members[number].clone()).collect();
    let share = sets.gain(&kept).min(all - sets.gain(&nameless)) / explicable;
    let verdict = match (names.is_empty(), share) {
        (true, _) => Verdict::Unexplained,
        (_, share) if share < PARTLY => Verdict::Unexplained,
        _ if undecided => Verdict::Ambiguous,
        (_, share) if share < EXPLAINED => Verdict::PartlyExplained,
        _ => Verdict::Explained,
    };
    if verdict == Verdict::Unexplained {
        for name in names.drain(..) {
            let why = format!(
                "with a probability of {} it explains {} of what can be explained, all names {}",
                probability(name.probability),
                significant(name.share, 2),
                significant(share, 2)
            );
            refused.push((name.name, why));
        }
    }
    Ok(Answer { verdict, names, refused, events: Vec::new(), rivals: rivals(model, atoms, sets, ranked) })
}

/// The set with simpler forms in the place of fuller ones, as long as they lack no more than a further unknown would by chance.
fn simplest<'r>(atoms: &Atoms<'_>, sets: &Sets<'_, '_, '_>, ranked: &'r [Set], best: &'r Set) -> &'r Set {
    let mut chosen = best;
    loop {
        let simpler = ranked.iter().find(|set| {
            let (own, theirs) = (chosen.key(), set.key());
            let gone: Vec<usize> = own.iter().copied().filter(|atom| !theirs.contains(atom)).collect();
            let come: Vec<usize> = theirs.iter().copied().filter(|atom| !own.contains(atom)).collect();
            match (&gone[..], &come[..]) {
                ([gone], [come]) if atoms.all[*gone].is_fuller(&atoms.all[*come]) => {
                    sets.gain(&chosen.members) - sets.gain(&set.members)
                        < chi_squared_quantile(1.0 - NEEDED, 1.0)
                }
                _ => false,
            }
        });
        match simpler {
            Some(set) => chosen = set,
            None => return chosen,
        }
    }
}

/// The largest effect of the same sensor, where a name is no more than what the forms of the sensor's effects leave, and the share of what they
/// explain together.
fn crumb_of(
    atoms: &Atoms<'_>,
    sets: &Sets<'_, '_, '_>,
    members: &[Member],
    gains: &[f64],
    number: usize,
    beyond: f64,
) -> Option<(String, f64)> {
    let own = &atoms.all[members[number].atom];
    if own.is_event() && gains[number] > OF_THE_REST * (gains[number] + beyond) {
        return None;
    }
    let shares_sensor = |other: &usize| {
        let atom = &atoms.all[members[*other].atom];
        let together = atom.sensor().is_none() || own.sensor().is_none() || atom.sensor() == own.sensor();
        atom.is_named() && together
    };
    let apart: Vec<Member> = (0..members.len())
        .filter(|other| !shares_sensor(other))
        .map(|other| members[other].clone())
        .collect();
    let whole = sets.gain(members) - sets.gain(&apart);
    let others = (0..members.len()).filter(|other| *other != number).filter(shares_sensor);
    let largest = others.max_by(|a, b| gains[*a].total_cmp(&gains[*b]))?;
    let share = gains[number] / whole;
    (share < CRUMB).then(|| (atoms.all[members[largest].atom].name.clone(), share))
}

/// The names of sets nearly as probable as the best.
fn rivals(
    model: &Model<'_>,
    atoms: &Atoms<'_>,
    sets: &Sets<'_, '_, '_>,
    ranked: &[Set],
) -> Vec<Vec<Addition>> {
    let near = |set: &&Set| ranked[0].log - set.log < NEARLY;
    let of = |set: &Set| -> Vec<Addition> {
        let coefficients = sets.coefficients(&set.members).unwrap_or_default();
        let named =
            set.members.iter().zip(&coefficients).filter(|(member, _)| atoms.all[member.atom].is_named());
        let additions = named.flat_map(|(member, sizes)| {
            let atom = &atoms.all[member.atom];
            additions(model, &atom.thing, &atom.shapes[member.shape], sizes)
        });
        additions.collect()
    };
    ranked.iter().skip(1).filter(near).take(REFITTED).map(of).collect()
}

fn member_prior(atom: &Atom) -> f64 {
    atom.log_prior - (atom.shapes.len() as f64).ln()
}

fn is_local(atom: &Atom) -> bool {
    let one = |addition: &Addition| match addition {
        Addition::Effect(effect) => effect.kind.parameters().iter().any(physics::ParameterInfo::is_moment),
        Addition::Column(_) => true,
    };
    matches!(&atom.thing, Thing::Event(additions) if additions.iter().any(one))
}

/// What may stand in the place of a name.
struct Slot {
    probability: f64,
    /// Names that together with it have the probability asked for; None where they have not.
    equal: Option<Vec<String>>,
}

impl Slot {
    fn of(atoms: &Atoms<'_>, ranked: &[Set], weights: &[f64], atom: usize) -> Self {
        // A fuller form that is not needed says the same.
        let says = |own: usize, atom: usize| own == atom || atoms.all[own].is_fuller(&atoms.all[atom]);
        let holds = |set: &Set, atom: usize| set.members.iter().any(|member| says(member.atom, atom));
        let mut left: Vec<(&Set, f64)> =
            ranked.iter().zip(weights.iter().copied()).filter(|(set, _)| !holds(set, atom)).collect();
        let probability = 1.0 - left.iter().map(|(_, weight)| weight).sum::<f64>();
        let mut together = probability;
        let mut equal = Vec::new();
        while together < SURE && equal.len() + 1 < UNDECIDED {
            // The further name that is in most of what is left.
            let mut names: Vec<usize> = left
                .iter()
                .flat_map(|(set, _)| set.members.iter().map(|member| member.atom))
                .filter(|atom| atoms.all[*atom].is_named())
                .collect();
            names.sort_unstable();
            names.dedup();
            let weight = |atom: usize| -> f64 {
                left.iter().filter(|(set, _)| holds(set, atom)).map(|(_, weight)| weight).sum()
            };
            let all: Vec<(f64, usize)> = names.into_iter().map(|atom| (weight(atom), atom)).collect();
            let most = all.iter().max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
            let Some((weight, next)) = most.copied() else { break };
            together += weight;
            equal.push(atoms.all[next].name.clone());
            left.retain(|(set, _)| !holds(set, next));
        }
        Self { probability, equal: (together >= SURE).then_some(equal) }
    }
}

/// Rivals of a name: what sets without it have, and how far behind they are.
fn lost(atoms: &Atoms<'_>, best: &Set, ranked: &[Set], atom: usize) -> Vec<(String, String)> {
    let mut told: Vec<(String, String)> = Vec::new();
    for set in ranked.iter().filter(|set| set.members.iter().all(|member| member.atom != atom)) {
        let fresh = |member: &&Member| {
            let other = &atoms.all[member.atom];
            let in_best = best.members.iter().any(|own| own.atom == member.atom);
            other.is_named() && !in_best && told.iter().all(|(name, _)| *name != other.name)
        };
        let Some(rival) = set.members.iter().find(fresh) else { continue };
        let behind = best.log - set.log;
        told.push((
            atoms.all[rival.atom].name.clone(),
            format!("log odds of {} against it", significant(behind, 3)),
        ));
        if told.len() == RIVALS {
            break;
        }
    }
    told
}
