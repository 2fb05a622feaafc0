//! What the weighed sets say: which names, how sure, what share, and what the others lack.

use common::number::{p_value, probability, significant};
use common::{Axis, ExplainedFamily, Verdict};

use estimate::stats::chi_squared_quantile;

use crate::additions::additions;
use crate::atoms::{Atom, Atoms, Shape, Thing};
use crate::decide::{AS_MUCH, EXPLAINED, NEGLIGIBLE, PARTLY, SURE, TEMPERATURE};
use crate::families;
use crate::level::{Rest, at_least_one};
use crate::proposal::{Addition, Proposal};
use crate::sets::{Member, Set, Sets};
use crate::stacked::Stacked;

/// Most names that are told as undecided.
const UNDECIDED: usize = 6;
/// Probability by chance at which a further unknown of a fuller form is needed.
const NEEDED: f64 = 0.01;
/// Sets whose log probability is behind the best by no more may be fitted again with the calibration, and so
/// many of them at most.
const NEARLY: f64 = 15.0;
const REFITTED: usize = 5;
/// Share of single readings at edges of others from which they are a matter of these.
const AT_EDGES: f64 = 0.5;
/// Rivals that are told of a name.
const RIVALS: usize = 5;

/// A name that could stand in the place of another.
#[derive(Clone, Debug)]
pub struct Alternative {
    /// The name with its target.
    pub name: String,
    /// What would come in.
    pub additions: Vec<Addition>,
}

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
    /// Share of its energy by which it departs from its form.
    pub departure: f64,
    /// How far it may depart from its form, for each group of departures.
    pub departs: Vec<f64>,
    /// Names that explain as well.
    pub equal: Vec<Alternative>,
    /// Others, and why they lost.
    pub lost: Vec<(String, String)>,
}

/// Structure of the best set that has no name.
#[derive(Clone, Debug)]
pub struct Unnamed {
    /// What it follows.
    pub covariate: String,
    /// The sensor.
    pub axis: Axis,
    /// A threshold of what it follows, or how far back it goes, in rows, where it follows the past of
    /// something.
    pub shape: Option<f64>,
    /// What it makes of each reading, nT.
    pub values: Stacked,
    /// Share of what can be explained.
    pub share: f64,
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
    /// By how much its names lower the sum of squares where all is linear.
    pub gain: f64,
    /// The members of the best set that stand.
    pub members: Vec<Member>,
    /// Moments, lines and codes in what they leave.
    pub events: Vec<Proposal>,
    /// What other sets that are nearly as probable hold.
    pub rivals: Vec<Vec<Addition>>,
    /// Structure of the best set.
    pub unnamed: Vec<Unnamed>,
    /// The kinds of physics of the best set.
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

/// The answer of ranked sets, the empty one among them.
/// A name whose gain chance has too, at a level, is none.
pub fn answer(atoms: &Atoms<'_>, sets: &Sets<'_, '_, '_>, ranked: &[Set], level: f64) -> Answer {
    let rest = sets.rest;
    let weights = weights(ranked);
    let nothing = 1.0 / (1.0 + (ranked[0].log / TEMPERATURE).exp());
    let best = simplest(atoms, sets, ranked, &ranked[0]);
    let whole = rest.sum_of_squares;
    let all = sets.gain(&best.members);
    let beyond = rest.excess(whole - all);
    let explicable = (all + beyond).max(f64::MIN_POSITIVE);
    let coefficients = sets.coefficients(&best.members).unwrap_or_default();
    let departures = sets.departures(&best.members);
    let ranks: Vec<usize> =
        best.members.iter().enumerate().map(|(k, _)| coefficients.get(k).map_or(1, Vec::len)).collect();
    let (core, mut refused) = core(atoms, sets, (&best.members, &ranks), level);
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
        let atom = &atoms.all[member.atom];
        if let Thing::Smooth(covariate, axis) = &atom.thing {
            let shape = &atom.shapes[member.shape];
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
            equal.into_iter().map(|(atom, set)| alternative(atoms, sets, set, atom)).collect();
        undecided |= !equal.is_empty();
        kept.push(number);
        names.push(Name {
            name: atom.name.clone(),
            additions: additions(&atom.thing, &atom.shapes[member.shape], &coefficients[number]),
            local: is_local(atom),
            probability: slot.probability,
            p,
            share: gain / explicable,
            departure: departures[number],
            departs: member.departs.clone(),
            equal,
            lost: lost(atoms, best, ranked, member.atom),
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
    let rivals = rivals(atoms, sets, ranked);
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
fn simplest<'r>(atoms: &Atoms<'_>, sets: &Sets<'_, '_, '_>, ranked: &'r [Set], best: &'r Set) -> &'r Set {
    let mut chosen = best;
    loop {
        let simpler = ranked.iter().find(|set| {
            let (own, theirs) = (chosen.key(), set.key());
            let gone: Vec<usize> = own.iter().copied().filter(|atom| !theirs.contains(atom)).collect();
            let come: Vec<usize> = theirs.iter().copied().filter(|atom| !own.contains(atom)).collect();
            match (&gone[..], &come[..]) {
                ([gone], [come]) if atoms.all[*gone].is_fuller(&atoms.all[*come]) => {
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
    atoms: &Atoms<'_>,
    sets: &Sets<'_, '_, '_>,
    (members, ranks): (&[Member], &[usize]),
    level: f64,
) -> (Vec<usize>, Vec<(String, String)>) {
    let mut core: Vec<usize> = (0..members.len()).collect();
    let mut refused = Vec::new();
    // A single reading at which others jump is a matter of their timing.
    if let Some(contributions) = sets.contributions(members) {
        core.retain(|number| {
            let atom = &atoms.all[members[*number].atom];
            let mut columns = atom.shapes[members[*number].shape].columns.iter();
            if !is_local(atom) || columns.any(|column| atoms.column(*column).readings() != 1) {
                return true;
            }
            let others = contributions.iter().enumerate().filter(|(other, _)| other != number);
            let others = Stacked::sum(&others.map(|(_, column)| (column, 1.0)).collect::<Vec<_>>());
            let stands = contributions[*number].share_at_edges(&others) < AT_EDGES;
            if !stands {
                let why = "other effects change by more than it in the same readings: it may be their timing";
                refused.push((atom.name.clone(), why.to_string()));
            }
            stands
        });
    }
    let gain =
        |some: &[usize]| sets.gain(&some.iter().map(|number| members[*number].clone()).collect::<Vec<_>>());
    loop {
        let all = gain(&core);
        // Beside structure without a name, which could do what any name does, no name would add anything.
        let is_named = |number: &usize| atoms.all[members[*number].atom].is_named();
        let names: Vec<usize> = core.iter().copied().filter(is_named).collect();
        let by_names = gain(&names);
        let chance = names.iter().map(|number| {
            let others = others_of(&names, *number);
            let by_others = gain(&others);
            let rest = sets.rest.beside(by_others, others.iter().map(|other| ranks[*other]).sum());
            let atom = &atoms.all[members[*number].atom];
            (by_chance(&rest, atom, by_names - by_others, ranks[*number]), *number)
        });
        if let Some((p, number)) = chance.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(p, _)| *p > level) {
            core.retain(|other| *other != number);
            let why = format!("its improvement on the other effects is within chance ({})", p_value(p));
            refused.push((atoms.all[members[number].atom].name.clone(), why));
            continue;
        }
        let share = |own: usize| {
            let others = others_of(&core, own);
            let lasts = |other: &usize| !is_local(&atoms.all[members[*other].atom]);
            let lasting: Vec<usize> = others.iter().copied().filter(lasts).collect();
            let alone = all - gain(&others);
            alone / (alone + gain(&lasting).max(0.0))
        };
        let shares = core.iter().map(|number| (share(*number), *number));
        let least = shares.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(share, _)| *share < NEGLIGIBLE);
        let Some((share, number)) = least else { return (core, refused) };
        core.retain(|other| *other != number);
        let atom = &atoms.all[members[number].atom];
        if atom.is_named() {
            let why = format!(
                "it explains only {} % of the explained variance, within the model error of the other effects",
                significant(100.0 * share, 2)
            );
            refused.push((atom.name.clone(), why));
        }
    }
}

/// An atom as a set has it.
fn alternative(atoms: &Atoms<'_>, sets: &Sets<'_, '_, '_>, set: &Set, atom: usize) -> Alternative {
    let says = |member: &Member| member.atom == atom || atoms.all[member.atom].is_fuller(&atoms.all[atom]);
    let sizes = sets.coefficients(&set.members).unwrap_or_default();
    let own = set.members.iter().zip(&sizes).find(|(member, _)| says(member));
    let additions = own.map(|(member, sizes)| {
        let atom = &atoms.all[member.atom];
        additions(&atom.thing, &atom.shapes[member.shape], sizes)
    });
    Alternative { name: atoms.all[atom].name.clone(), additions: additions.unwrap_or_default() }
}

/// The names of sets nearly as probable as the best, sets of names alone that explain nearly as much, and names of
/// the kind of physics that structure of the best set is: they may do better at the shapes that they come to.
fn rivals(atoms: &Atoms<'_>, sets: &Sets<'_, '_, '_>, ranked: &[Set]) -> Vec<Vec<Addition>> {
    let of = |set: &Set| -> Vec<Addition> {
        let coefficients = sets.coefficients(&set.members).unwrap_or_default();
        let named =
            set.members.iter().zip(&coefficients).filter(|(member, _)| atoms.all[member.atom].is_named());
        let additions = named.flat_map(|(member, sizes)| {
            let atom = &atoms.all[member.atom];
            additions(&atom.thing, &atom.shapes[member.shape], sizes)
        });
        additions.collect()
    };
    let gain = sets.gain(&ranked[0].members);
    let explains = |set: &Set| {
        set.members.iter().all(|member| atoms.all[member.atom].is_named())
            && sets.gain(&set.members) > AS_MUCH * gain
    };
    // One set for each name whose shapes no fit has found yet.
    let mut known: Vec<usize> = ranked[0].members.iter().map(|member| member.atom).collect();
    let mut chosen = Vec::new();
    let is_fresh = |number: usize, known: &[usize]| {
        let atom = &atoms.all[number];
        let fitted = atom.shapes.iter().any(Shape::is_fitted);
        atom.is_named() && atom.shapes.len() > 1 && !fitted && !known.contains(&number)
    };
    let structures =
        ranked[0].members.iter().map(|member| &atoms.all[member.atom]).filter(|atom| !atom.is_named());
    for structure in structures {
        for (number, atom) in atoms.all.iter().enumerate() {
            let is_of = families::of(atom) == families::of(structure) && atom.sensor() == structure.sensor();
            if !is_of || !is_fresh(number, &known) {
                continue;
            }
            known.push(number);
            if let Some((shape, coefficients)) = sets.nearest(number) {
                chosen.push(additions(&atom.thing, &atom.shapes[shape], &coefficients));
            }
        }
    }
    let most = chosen.len() + REFITTED;
    for set in ranked.iter().filter(|set| ranked[0].log - set.log < NEARLY || explains(set)) {
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
    at_least_one(rest.p(gain, rank), (-member_prior(atom)).exp())
}

fn member_prior(atom: &Atom) -> f64 {
    atom.log_prior - (atom.tried as f64).ln()
}

fn is_local(atom: &Atom) -> bool {
    let one = |addition: &Addition| match addition {
        Addition::Effect(effect) => effect.kind.parameters().iter().any(physics::ParameterInfo::is_moment),
        Addition::Single(_) => true,
    };
    matches!(&atom.thing, Thing::Event(additions) if additions.iter().any(one))
}

/// What may stand in the place of a name.
struct Slot<'r> {
    probability: f64,
    /// Names that together with it have the probability asked for, each with the best set that has it; None
    /// where they have not.
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
            let mut names: Vec<usize> = left
                .iter()
                .flat_map(|(set, _)| set.members.iter().map(|member| member.atom))
                .filter(|atom| atoms.all[*atom].is_named() && !best.key().contains(atom))
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
            equal.extend(left.iter().find(|(set, _)| holds(set, next)).map(|(set, _)| (next, *set)));
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
