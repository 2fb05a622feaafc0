//! What the weighed sets say: which names, how sure, what share, and what the others lack.

use common::number::{p_value, probability, significant};
use common::{Axis, ExplainedFamily, Rival, Verdict};
use estimate::stats::chi_squared_quantile;
use physics::ParameterInfo;
use std::collections::BTreeSet;

use crate::additions::additions;
use crate::atoms::{Atom, Atoms};
use crate::candidates::Shape;
use crate::decide::{AS_MUCH, EXPLAINED, NEGLIGIBLE, PARTLY, SURE, TEMPERATURE};
use crate::families;
use crate::level::{Rest, at_least_one};
use crate::proposal::{Addition, Proposal, What};
use crate::sets::{Member, Set, Sets};
use crate::stacked::Stacked;

/// Most names that are told as undecided.
const UNDECIDED: usize = 6;
/// Probability by chance at which a further unknown of a fuller form is needed.
const NEEDED: f64 = 0.01;
/// Sets behind the best by no more, in log probability, may be fitted again, so many at most.
const NEARLY: f64 = 15.0;
const REFITTED: usize = 5;
/// Share of single readings at edges of others from which they are a matter of these.
const AT_EDGES: f64 = 0.5;
/// Rivals that are told of a name.
const RIVALS: usize = 5;

/// A name of an answer, and what was said against it.
#[derive(Clone, Debug, Default)]
pub struct NamedEffect {
    pub name: String,
    /// What comes in: one thing, or a list of such at moments.
    pub additions: Vec<Addition>,
    /// Whether it touches few rows, so that rows left out say nothing.
    pub local: bool,
    /// Probability of such a gain by chance, all that was searched counted.
    pub p: f64,
    /// Probability of the name.
    pub probability: f64,
    /// Share of what can be explained.
    pub share: f64,
    /// Share of its energy by which it departs from its form.
    pub departure: f64,
    /// How far it may depart from its form, for each group of departures.
    pub departs: Vec<f64>,
    /// By how much it lowers the sum of squares beside all others: whitened, and in nT².
    pub gain: f64,
    pub gain_nt2: f64,
    /// By how much it lowers the sum of squares of readings left out, part by part.
    pub held_out: Vec<f64>,
    /// Names that explain as well.
    pub equal: Vec<Alternative>,
    /// Others, and why they lost.
    pub lost: Vec<Rival>,
}

/// A name that could stand in the place of another, with what would come in.
#[derive(Clone, Debug)]
pub struct Alternative {
    pub name: String,
    pub additions: Vec<Addition>,
}

/// Structure of the best set that has no name.
#[derive(Clone, Debug)]
pub struct Unnamed {
    /// What it follows.
    pub covariate: String,
    pub axis: Axis,
    /// A threshold of what it follows, or how many rows back it goes where it follows a past.
    pub shape: Option<f64>,
    /// What it makes of each reading, nT.
    pub values: Stacked,
    /// Share of what can be explained.
    pub share: f64,
}

#[derive(Clone, Debug)]
pub struct Answer {
    pub verdict: Verdict,
    /// The names of the best set, one of each that are undecided.
    pub names: Vec<NamedEffect>,
    /// What looked like an answer, and why it is none.
    pub refused: Vec<(String, String)>,
    /// By how much its names lower the sum of squares where all is linear.
    pub gain: f64,
    /// The members of the best set that stand.
    pub members: Vec<Member>,
    /// Moments, lines and codes in what they leave.
    pub events: Vec<Proposal>,
    /// What other sets that are nearly as probable hold.
    pub rivals: Vec<Vec<Addition>>,
    pub unnamed: Vec<Unnamed>,
    pub families: Vec<ExplainedFamily>,
    /// Probability that nothing is there: the empty set against the best one, the evidence tempered.
    pub nothing: f64,
}

impl Answer {
    /// The same where nothing is there.
    pub fn agrees(mut self) -> Self {
        self.names.clear();
        self.unnamed.clear();
        self.families.clear();
        self.verdict = Verdict::Agrees;
        self
    }

    /// The same without its names, for a reason.
    pub fn unexplained(mut self, why: &str) -> Self {
        self.refused.extend(self.names.drain(..).map(|name| (name.name, why.to_string())));
        self.verdict = Verdict::Unexplained;
        self
    }
}

/// Weights of ranked sets, the evidence tempered, adding up to one.
fn weights(ranked: &[Set]) -> Vec<f64> {
    let most = ranked[0].log;
    // That nothing is there is judged by itself.
    let weight =
        |set: &Set| if set.members.is_empty() { 0.0 } else { ((set.log - most) / TEMPERATURE).exp() };
    let raw: Vec<f64> = ranked.iter().map(weight).collect();
    let sum: f64 = raw.iter().sum();
    raw.into_iter().map(|weight| weight / sum).collect()
}

/// The answer of ranked sets, the empty one among them. A name that chance allows at a level is none.
pub fn answer(sets: &Sets<'_, '_, '_>, ranked: &[Set], level: f64) -> Answer {
    let (atoms, rest) = (sets.atoms, sets.rest);
    let weights = weights(ranked);
    let nothing = 1.0 / (1.0 + (ranked[0].log / TEMPERATURE).exp());
    let best = simplest(sets, ranked, &ranked[0]);
    let whole = rest.sum_of_squares;
    let all = sets.gain(&best.members);
    let beyond = rest.excess(whole - all);
    let explicable = (all + beyond).max(f64::MIN_POSITIVE);
    let coefficients = sets.coefficients(&best.members).unwrap_or_default();
    let departures = sets.departures(&best.members);
    let ranks: Vec<usize> =
        best.members.iter().enumerate().map(|(k, _)| coefficients.get(k).map_or(1, Vec::len)).collect();
    let (core, mut refused) = core(sets, (&best.members, &ranks), level);
    let members = |which: &dyn Fn(&usize) -> bool| -> Vec<Member> {
        core.iter().filter(|number| which(number)).map(|number| best.members[*number].clone()).collect()
    };
    let whole_core = sets.gain(&members(&|_| true));
    let mut names = Vec::new();
    let mut unnamed = Vec::new();
    let mut kept: Vec<usize> = Vec::new();
    let mut undecided = false;
    for &number in &core {
        let member = &best.members[number];
        let (atom, shape) = (sets.atom(member), sets.shape(member));
        if let What::Smooth { covariate, axis } = &atom.what {
            let columns = shape.columns.iter().map(|column| atoms.column(*column));
            unnamed.push(Unnamed {
                covariate: covariate.clone(),
                axis: *axis,
                shape: shape.value,
                values: Stacked::sum(&columns.zip(coefficients[number].iter().copied()).collect::<Vec<_>>()),
                share: (whole_core - sets.gain(&members(&|other| *other != number))) / explicable,
            });
            continue;
        }
        let slot = Slot::of(atoms, ranked, &weights, (best, member.atom));
        let by_others = sets.gain(&members(&|other| *other != number));
        let gain = whole_core - by_others;
        let others = core.iter().filter(|other| **other != number).map(|other| ranks[*other]).sum();
        let p = by_chance(&rest.beside(by_others, others), atom, gain, ranks[number]);
        let Some(equal) = slot.equal else {
            let why = format!(
                "its probability is {}; unidentified structure and other sets of effects have the rest",
                significant(slot.probability, 2)
            );
            refused.push((atom.name.clone(), why));
            continue;
        };
        let equal: Vec<Alternative> =
            equal.into_iter().map(|(atom, set)| alternative(sets, set, atom)).collect();
        undecided |= !equal.is_empty();
        kept.push(number);
        names.push(NamedEffect {
            name: atom.name.clone(),
            additions: additions(&atom.what, shape, &coefficients[number]),
            local: is_local(atom),
            probability: slot.probability,
            p,
            share: gain / explicable,
            departure: departures[number],
            departs: member.departs.clone(),
            equal,
            lost: lost(atoms, best, ranked, member.atom),
            ..NamedEffect::default()
        });
    }
    // What a form leaves counts as what its effect explains; what structure could explain as well does not.
    let nameless = members(&|number| !atoms.all[best.members[*number].atom].is_named());
    let named = sets.gain(&members(&|number| kept.contains(number)));
    let share = named.min(whole_core - sets.gain(&nameless)) / explicable;
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
                "its probability is {}, but it explains only {} of the explicable variance (all effects together {})",
                probability(name.probability),
                significant(name.share, 2),
                significant(share, 2)
            );
            refused.push((name.name, why));
        }
    }
    let rivals = rivals(sets, ranked);
    let share = |own: &[usize]| {
        let beside = |number: &usize| !own.contains(&best.members[*number].atom);
        (whole_core - sets.gain(&members(&beside))) / explicable
    };
    let families = families::families(atoms, (ranked, &weights), best, share);
    let members = members(&|_| true);
    Answer {
        verdict,
        names,
        refused,
        gain: named,
        members,
        events: Vec::new(),
        rivals,
        unnamed,
        families,
        nothing,
    }
}

/// The set with simpler forms in the place of fuller ones, as long as they lack no more than a further
/// unknown would by chance, none departing from its equation.
fn simplest<'r>(sets: &Sets<'_, '_, '_>, ranked: &'r [Set], best: &'r Set) -> &'r Set {
    let all = &sets.atoms.all;
    let mut chosen = best;
    loop {
        let simpler = ranked.iter().find(|set| {
            let (own, theirs) = (chosen.key(), set.key());
            let gone: Vec<usize> = own.iter().copied().filter(|atom| !theirs.contains(atom)).collect();
            let come: Vec<usize> = theirs.iter().copied().filter(|atom| !own.contains(atom)).collect();
            match (&gone[..], &come[..]) {
                ([gone], [come]) if all[*gone].is_fuller(&all[*come]) => {
                    sets.gain_exact(&chosen.members) - sets.gain_exact(&set.members)
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

/// The members whose gain beside the others chance does not have too, and which explain more than a
/// negligible share of what all explain; and the names of the rest: the one that
/// explains least goes first, and the others are looked at again without it.
fn core(
    sets: &Sets<'_, '_, '_>,
    (members, ranks): (&[Member], &[usize]),
    level: f64,
) -> (Vec<usize>, Vec<(String, String)>) {
    let mut core: Vec<usize> = (0..members.len()).collect();
    let mut refused = Vec::new();
    let atom = |number: usize| sets.atom(&members[number]);
    // A single reading at which others jump is a matter of their timing.
    if let Some(contributions) = sets.contributions(members) {
        core.retain(|number| {
            let mut columns = sets.shape(&members[*number]).columns.iter();
            if !is_local(atom(*number)) || columns.any(|column| sets.atoms.column(*column).readings() != 1) {
                return true;
            }
            let others = contributions.iter().enumerate().filter(|(other, _)| other != number);
            let others = Stacked::sum(&others.map(|(_, column)| (column, 1.0)).collect::<Vec<_>>());
            let stands = contributions[*number].share_at_edges(&others) < AT_EDGES;
            if !stands {
                let why = "other effects change by more than it in the same readings: it may be their timing";
                refused.push((atom(*number).name.clone(), why.to_string()));
            }
            stands
        });
    }
    let gain =
        |some: &[usize]| sets.gain(&some.iter().map(|number| members[*number].clone()).collect::<Vec<_>>());
    loop {
        let all = gain(&core);
        // Beside structure without a name, which could do what any name does, no name would add anything.
        let names: Vec<usize> = core.iter().copied().filter(|number| atom(*number).is_named()).collect();
        let by_names = gain(&names);
        let chance = names.iter().map(|number| {
            let others = others_of(&names, *number);
            let by_others = gain(&others);
            let rest = sets.rest.beside(by_others, others.iter().map(|other| ranks[*other]).sum());
            (by_chance(&rest, atom(*number), by_names - by_others, ranks[*number]), *number)
        });
        if let Some((p, number)) = chance.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(p, _)| *p > level) {
            core.retain(|other| *other != number);
            let why = format!("its improvement on the other effects is within chance ({})", p_value(p));
            refused.push((atom(number).name.clone(), why));
            continue;
        }
        let share = |own: usize| {
            let others = others_of(&core, own);
            let lasting: Vec<usize> =
                others.iter().copied().filter(|other| !is_local(atom(*other))).collect();
            let alone = all - gain(&others);
            alone / (alone + gain(&lasting).max(0.0))
        };
        let shares = core.iter().map(|number| (share(*number), *number));
        let least = shares.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(share, _)| *share < NEGLIGIBLE);
        let Some((share, number)) = least else { return (core, refused) };
        core.retain(|other| *other != number);
        if atom(number).is_named() {
            let why = format!(
                "it explains only {} % of the explained variance, within the model error of the other effects",
                significant(100.0 * share, 2)
            );
            refused.push((atom(number).name.clone(), why));
        }
    }
}

/// What comes in for a member of a set with these coefficients.
fn additions_of(sets: &Sets<'_, '_, '_>, member: &Member, sizes: &[f64]) -> Vec<Addition> {
    additions(&sets.atom(member).what, sets.shape(member), sizes)
}

fn alternative(sets: &Sets<'_, '_, '_>, set: &Set, atom: usize) -> Alternative {
    let of = &sets.atoms.all[atom];
    let says = |member: &Member| member.atom == atom || sets.atom(member).is_fuller(of);
    let sizes = sets.coefficients(&set.members).unwrap_or_default();
    let own = set.members.iter().zip(&sizes).find(|(member, _)| says(member));
    let additions = own.map(|(member, sizes)| additions_of(sets, member, sizes));
    Alternative { name: of.name.clone(), additions: additions.unwrap_or_default() }
}

/// The names of sets nearly as probable as the best, sets of names alone that explain nearly as much, and names of
/// the kind of physics that structure of the best set is: they may do better at the shapes that they come to.
fn rivals(sets: &Sets<'_, '_, '_>, ranked: &[Set]) -> Vec<Vec<Addition>> {
    let (atoms, best) = (&sets.atoms.all, &ranked[0]);
    let is_named = |member: &Member| sets.atom(member).is_named();
    let of = |set: &Set| -> Vec<Addition> {
        let coefficients = sets.coefficients(&set.members).unwrap_or_default();
        let named = set.members.iter().zip(&coefficients).filter(|(member, _)| is_named(member));
        named.flat_map(|(member, sizes)| additions_of(sets, member, sizes)).collect()
    };
    let gain = sets.gain(&best.members);
    let explains = |set: &Set| set.members.iter().all(is_named) && sets.gain(&set.members) > AS_MUCH * gain;
    // One set for each name whose shapes no fit has found yet.
    let mut known: Vec<usize> = best.members.iter().map(|member| member.atom).collect();
    let mut chosen = Vec::new();
    let is_fresh = |number: usize, known: &[usize]| {
        let atom = &atoms[number];
        let fitted = atom.shapes.iter().any(Shape::is_fitted);
        atom.is_named() && atom.shapes.len() > 1 && !fitted && !known.contains(&number)
    };
    for structure in best.members.iter().filter(|member| !is_named(member)).map(|member| sets.atom(member)) {
        for (number, atom) in atoms.iter().enumerate() {
            let is_of = families::of(atom) == families::of(structure) && atom.sensor() == structure.sensor();
            if !is_of || !is_fresh(number, &known) {
                continue;
            }
            known.push(number);
            if let Some((shape, coefficients)) = sets.nearest(number) {
                chosen.push(additions(&atom.what, &atom.shapes[shape], &coefficients));
            }
        }
    }
    let most = chosen.len() + REFITTED;
    for set in ranked.iter().filter(|set| best.log - set.log < NEARLY || explains(set)) {
        let members = set.members.iter().map(|member| member.atom);
        let fresh: Vec<usize> = members.filter(|number| is_fresh(*number, &known)).collect();
        if !fresh.is_empty() {
            known.extend(fresh);
            chosen.push(of(set));
        }
        if chosen.len() == most {
            break;
        }
    }
    chosen
}

fn others_of(all: &[usize], own: usize) -> Vec<usize> {
    all.iter().copied().filter(|other| *other != own).collect()
}

/// Probability that chance gains as much anywhere among what an atom was chosen from.
fn by_chance(rest: &Rest, atom: &Atom, gain: f64, rank: usize) -> f64 {
    at_least_one(rest.p(gain, rank), ((atom.tried as f64).ln() - atom.log_prior).exp())
}

fn is_local(atom: &Atom) -> bool {
    let one = |addition: &Addition| match addition {
        Addition::Effect(effect) => effect.kind.parameters().iter().any(ParameterInfo::is_moment),
        Addition::Single(_) => true,
    };
    matches!(&atom.what, What::Event(additions) if additions.iter().any(one))
}

/// What may stand in the place of a name.
struct Slot<'r> {
    probability: f64,
    /// Names that make it sure together with it, each with the best set that has it; None where they do not.
    equal: Option<Vec<(usize, &'r Set)>>,
}

impl<'r> Slot<'r> {
    fn of(atoms: &Atoms<'_>, ranked: &'r [Set], weights: &[f64], (best, atom): (&Set, usize)) -> Self {
        // A fuller form that is not needed says the same, and of the name itself one that is left open.
        let says = |own: usize, atom: usize| own == atom || atoms.all[own].is_fuller(&atoms.all[atom]);
        let holds = |set: &Set, atom: usize| set.members.iter().any(|member| says(member.atom, atom));
        let open = |set: &Set| {
            set.members.iter().any(|member| atoms.all[atom].is_open_form(&atoms.all[member.atom]))
        };
        let lacks = |set: &Set| !holds(set, atom) && !open(set);
        let mut left: Vec<(&'r Set, f64)> =
            ranked.iter().zip(weights.iter().copied()).filter(|(set, _)| lacks(set)).collect();
        let probability = 1.0 - left.iter().map(|(_, weight)| weight).sum::<f64>();
        let mut together = probability;
        let mut equal = Vec::new();
        while together < SURE && equal.len() + 1 < UNDECIDED {
            // The further name that is in most of what is left; one of the best set stands for itself.
            let names = left.iter().flat_map(|(set, _)| set.members.iter().map(|member| member.atom));
            let is_other = |atom: &usize| atoms.all[*atom].is_named() && !best.key().contains(atom);
            let names: BTreeSet<usize> = names.filter(is_other).collect();
            let weight = |atom: usize| -> f64 {
                left.iter().filter(|(set, _)| holds(set, atom)).map(|(_, weight)| weight).sum()
            };
            let all: Vec<(f64, usize)> = names.into_iter().map(|atom| (weight(atom), atom)).collect();
            let most = all.iter().max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
            let Some((weight, next)) = most.copied() else { break };
            together += weight;
            equal.extend(left.iter().find(|(set, _)| holds(set, next)).map(|(set, _)| (next, *set)));
            left.retain(|(set, _)| !holds(set, next));
        }
        Self { probability, equal: (together >= SURE).then_some(equal) }
    }
}

/// Rivals of a name: what sets without it have, and how far behind they are.
fn lost(atoms: &Atoms<'_>, best: &Set, ranked: &[Set], atom: usize) -> Vec<Rival> {
    let mut told: Vec<Rival> = Vec::new();
    for set in ranked.iter().filter(|set| set.members.iter().all(|member| member.atom != atom)) {
        let fresh = |member: &&Member| {
            let other = &atoms.all[member.atom];
            let in_best = best.members.iter().any(|own| own.atom == member.atom);
            other.is_named() && !in_best && told.iter().all(|one| one.effect != other.name)
        };
        let Some(rival) = set.members.iter().find(fresh) else { continue };
        told.push(Rival {
            effect: atoms.all[rival.atom].name.clone(),
            why_not: format!("log odds of {} against it", significant(best.log - set.log, 3)),
        });
        if told.len() == RIVALS {
            break;
        }
    }
    told
}
