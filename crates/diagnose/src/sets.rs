//! Which sets of effects and structures have the evidence: a beam search, then members dropped and swapped.

mod figures;

use estimate::screen::Screen;
use rayon::prelude::*;
use std::collections::HashMap;

use crate::atoms::{Atom, Atoms};
use crate::candidates::Shape;
use crate::decide::{BEAM, DEPTH, FORM};
use crate::evidence::{Block, Further, Given, Term, energy};
use crate::form::{self, Followed};
use crate::level::Rest;
use crate::products::Products;
use crate::projection::Projection;
use crate::stacked::Stacked;
use crate::whitening::NoiseModel;

/// Names and structures that are tried with their forms at each step.
const NAMES: usize = 8;
const STRUCTURES: usize = 3;
/// What lowers the log evidence by more is not tried with its form.
const IDLE: f64 = 2.0;
/// What is likelier by less than this beside another adds nothing to the sum of both.
const NOTHING: f64 = 40.0;
/// A finite effect's column must have a coefficient between these: it is what the effect does at a shape, and
/// shapes are this far apart. At the ends of its grid it may be smaller: an effect of a smaller one.
const ABOUT_ONE: [f64; 2] = [0.3, 3.0];
/// A column of which the base model leaves less than this share is not looked for.
const VISIBLE: f64 = 1e-6;
/// What neighbouring shapes do may have this share of the contribution: half the way there.
const NEIGHBOUR: f64 = 0.5;

#[derive(Clone, Debug, Default)]
pub struct Member {
    pub atom: usize,
    pub shape: usize,
    deviations: Vec<f64>,
    /// ln of the probability of atom, shape and size beforehand.
    log_prior: f64,
    /// How far it may depart from its form, for each group of departures; none before its form is looked at.
    pub departs: Vec<f64>,
    /// ln of the mean evidence over the departures that were tried, over that of the best of them.
    log_forms: f64,
}

#[derive(Clone, Debug, Default)]
pub struct Set {
    pub members: Vec<Member>,
    /// ln of its probability, up to a constant.
    pub log: f64,
}

impl Set {
    /// The atoms in it, in order.
    pub fn key(&self) -> Vec<usize> {
        let mut key: Vec<usize> = self.members.iter().map(|member| member.atom).collect();
        key.sort_unstable();
        key
    }

    fn without(&self, number: usize) -> Vec<Member> {
        let mut members = self.members.clone();
        members.remove(number);
        members
    }
}

/// The columns of a shape of an atom that was looked at, behind those of all atoms, and those of its form.
#[derive(Clone, Debug, Default)]
struct Places {
    own: Vec<usize>,
    departures: Vec<Vec<usize>>,
    neighbours: Vec<usize>,
    /// Whitened energy of the contribution of which the departures are shares.
    energy: f64,
}

pub struct Sets<'s, 'm, 'a> {
    pub atoms: &'s Atoms<'s>,
    noise: &'s NoiseModel,
    products: Products,
    projection: Projection,
    followed: Followed<'m, 'a>,
    /// What the fit leaves.
    pub rest: Rest,
    screen: Screen,
    forms: HashMap<(usize, usize), Places>,
}

impl<'s, 'm, 'a> Sets<'s, 'm, 'a> {
    /// Over the atoms whose columns the products have.
    pub fn of(
        atoms: &'s Atoms<'s>,
        noise: &'s NoiseModel,
        products: Products,
        (mut projection, mut screen): (Projection, Screen),
        followed: Followed<'m, 'a>,
    ) -> Self {
        projection.extend(&mut screen, &products);
        let rest =
            Rest { sum_of_squares: screen.sum_of_squares(), freedom: screen.freedom(), known: noise.known };
        Self { atoms, noise, products, projection, followed, rest, screen, forms: HashMap::new() }
    }

    pub fn atom(&self, member: &Member) -> &'s Atom {
        &self.atoms.all[member.atom]
    }

    pub fn shape(&self, member: &Member) -> &'s Shape {
        &self.atom(member).shapes[member.shape]
    }

    /// The sets that were weighed, the empty one and that of some names among them, the most probable first.
    pub fn search(&mut self, names: &[String]) -> Vec<Set> {
        let empty = Set::default();
        let mut seen: HashMap<Vec<usize>, Set> = HashMap::from([(empty.key(), empty.clone())]);
        let mut beam = vec![empty.clone()];
        for _ in 0..DEPTH {
            let mut next = self.grown(&beam, &mut seen);
            next.truncate(BEAM);
            let before = beam.iter().map(|set| set.log).fold(f64::NEG_INFINITY, f64::max);
            let goes_on = next.first().is_some_and(|set| set.log > before);
            if !next.is_empty() {
                beam = next;
            }
            if !goes_on {
                break;
            }
        }
        if let Some(known) = self.of_names(empty, names).filter(|set| !set.members.is_empty()) {
            keep(&mut seen, known.clone());
            self.grown(&[known], &mut seen);
        }
        for _ in 0..DEPTH {
            let Some(best) = sorted(seen.clone()).into_iter().next() else { break };
            let fewer: Vec<Set> =
                (0..best.members.len()).filter_map(|k| self.weighed(best.without(k), true)).collect();
            fewer.iter().for_each(|set| keep(&mut seen, set.clone()));
            self.grown(&fewer, &mut seen);
            if seen.values().all(|set| set.log <= best.log + 1e-6) {
                break;
            }
        }
        sorted(seen)
    }

    /// A set with names one after the other, as far as they are atoms.
    fn of_names(&mut self, mut set: Set, names: &[String]) -> Option<Set> {
        for name in names {
            let Some(number) = self.atoms.all.iter().position(|atom| atom.name == *name) else { continue };
            self.complete(std::slice::from_ref(&set));
            let given = Given::of(&self.screen, self.terms(&set.members))?;
            let (_, member, coefficients) = self.alone(&given, number, f64::NEG_INFINITY)?;
            self.add_forms([&(member.clone(), coefficients)].into_iter());
            set.members.push(member);
            set = self.weighed(set.members, false)?;
        }
        Some(set)
    }

    /// Has all products of the columns of sets.
    fn complete(&mut self, sets: &[Set]) {
        let terms = sets.iter().flat_map(|set| self.terms(&set.members));
        let mut columns: Vec<usize> = terms.map(|(column, _)| column).collect();
        columns.sort_unstable();
        columns.dedup();
        columns.retain(|column| !self.products.is_complete(*column));
        self.projection.complete(&mut self.screen, &mut self.products, &columns);
    }

    /// Sets with one member more, the most promising of each.
    fn grown(&mut self, sets: &[Set], seen: &mut HashMap<Vec<usize>, Set>) -> Vec<Set> {
        self.complete(sets);
        let found: Vec<Vec<(Member, Vec<f64>)>> = sets.iter().map(|set| self.promising(set)).collect();
        self.add_forms(found.iter().flatten());
        let larger = |set: &Set, member: &Member| [&set.members[..], std::slice::from_ref(member)].concat();
        let tried = sets.iter().zip(&found);
        let tried: Vec<Vec<Member>> =
            tried.flat_map(|(set, more)| more.iter().map(|(member, _)| larger(set, member))).collect();
        let weighed: Vec<Set> =
            tried.into_par_iter().filter_map(|members| self.weighed(members, false)).collect();
        let mut all: HashMap<Vec<usize>, Set> = HashMap::new();
        for set in weighed {
            keep(seen, set.clone());
            keep(&mut all, set);
        }
        sorted(all)
    }

    /// What would come in next, forms apart, with its coefficients.
    fn promising(&self, set: &Set) -> Vec<(Member, Vec<f64>)> {
        let Some(given) = Given::of(&self.screen, self.terms(&set.members)) else { return Vec::new() };
        let held = |number: usize, atom: &Atom| {
            let same = |member: &Member| member.atom == number || self.atom(member).name == atom.name;
            set.members.iter().any(same)
        };
        // What does nothing here is not carried on.
        let least = given.log_evidence(&self.rest, None) - IDLE;
        let others = (0..self.atoms.all.len()).into_par_iter();
        let others = others.filter(|number| !held(*number, &self.atoms.all[*number]));
        let mut found: Vec<(f64, Member, Vec<f64>)> =
            others.filter_map(|number| self.alone(&given, number, least)).collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.atom.cmp(&b.1.atom)));
        found.retain(|(log, ..)| *log > least);
        let (names, structures): (Vec<_>, Vec<_>) =
            found.into_iter().partition(|(_, member, _)| self.atom(member).is_named());
        let some = names.into_iter().take(NAMES).chain(structures.into_iter().take(STRUCTURES));
        some.map(|(_, member, coefficients)| (member, coefficients)).collect()
    }

    /// Whether the coefficient of a finite effect's column is possible at a shape.
    fn possible(atom: &Atom, shape: usize, coefficient: f64) -> bool {
        let [low, high] = ABOUT_ONE;
        let grid = atom.shapes.iter().filter(|shape| !shape.is_fitted()).count();
        let least = if shape == 0 || shape + 1 == grid { 0.0 } else { low };
        !atom.finite || (coefficient > least && coefficient <= high)
    }

    /// An atom beside what is given: ln of its evidence over all shapes and sizes, and the best of them. None where that
    /// cannot be more than `least`: the widest sizes gain most.
    fn alone(&self, given: &Given<'_>, number: usize, least: f64) -> Option<(f64, Member, Vec<f64>)> {
        let atom = &self.atoms.all[number];
        let (_, widest) = atom.sizes.last()?;
        let mut shapes: Vec<(usize, f64, Block)> = Vec::new();
        let mut most = f64::NEG_INFINITY;
        for (shape, of) in atom.shapes.iter().enumerate() {
            let visible = |column: &usize| self.screen.visible(*column) >= VISIBLE;
            if of.columns.len() > widest.len() || !of.columns.iter().any(visible) {
                continue;
            }
            let block = given.block(&of.columns);
            let Some(further) = block.further(&widest[..of.columns.len()]) else { continue };
            let bound = given.log_evidence(&self.rest, Some(Further { log_determinant: 0.0, ..further }));
            most = most.max(bound);
            shapes.push((shape, bound, block));
        }
        let whole: f64 = atom.sizes.iter().map(|(log_size, _)| log_size.exp()).sum();
        if most + atom.log_prior + whole.ln() <= least {
            return None;
        }
        let mut best: Option<(f64, Member, Vec<f64>)> = None;
        let mut logs = Vec::new();
        shapes.sort_by(|a, b| b.1.total_cmp(&a.1));
        for (shape, bound, block) in shapes {
            // What cannot add to the sum is not weighed at all sizes.
            if best.as_ref().is_some_and(|(most, ..)| bound + atom.log_prior < most - NOTHING) {
                continue;
            }
            for (log_size, deviations) in &atom.sizes {
                let deviations = &deviations[..atom.shapes[shape].columns.len()];
                let Some(further) = block.further(deviations) else { continue };
                let log_prior = atom.log_prior + log_size - (atom.tried as f64).ln();
                let log = given.log_evidence(&self.rest, Some(further)) + log_prior;
                if atom.finite && !Self::possible(atom, shape, block.coefficients(deviations)?[0]) {
                    continue;
                }
                logs.push(log);
                if log.is_finite() && best.as_ref().is_none_or(|(most, ..)| log > *most) {
                    let (coefficients, deviations) = (block.coefficients(deviations)?, deviations.to_vec());
                    let member = Member { atom: number, shape, deviations, log_prior, ..Member::default() };
                    best = Some((log, member, coefficients));
                }
            }
        }
        let (most, mut member, coefficients) = best?;
        let all = most + logs.iter().map(|log| (log - most).exp()).sum::<f64>().ln();
        // The member stands for all shapes and sizes.
        member.log_prior += all - most;
        Some((all, member, coefficients))
    }

    /// The shape of an atom that gains most by itself, however likely it is, and its coefficients.
    pub fn nearest(&self, number: usize) -> Option<(usize, Vec<f64>)> {
        let atom = &self.atoms.all[number];
        let gains = atom.shapes.iter().enumerate().filter_map(|(shape, of)| {
            let gain = self.screen.gain(&of.columns).ok()?;
            (!atom.finite || gain.coefficients.first().is_some_and(|c| *c > 0.0)).then_some((shape, gain))
        });
        let most = gains.max_by(|a, b| a.1.gain.total_cmp(&b.1.gain));
        most.map(|(shape, gain)| (shape, gain.coefficients))
    }

    /// Brings in the forms of members that have none yet.
    fn add_forms<'f>(&mut self, members: impl Iterator<Item = &'f (Member, Vec<f64>)>) {
        let mut fresh: Vec<(&Member, &[f64])> = Vec::new();
        for (member, coefficients) in members {
            let key = (member.atom, member.shape);
            if !self.forms.contains_key(&key)
                && !fresh.iter().any(|(other, _)| (other.atom, other.shape) == key)
            {
                fresh.push((member, coefficients));
            }
        }
        let of = |(member, coefficients): &(&Member, &[f64])| {
            let energy = energy(&self.screen, &self.shape(member).columns, coefficients);
            let (atom, orders) = (self.atom(member), form::orders(energy));
            (energy, self.followed.form(self.atoms, atom, member.shape, coefficients, orders))
        };
        let made: Vec<(f64, form::Form)> = fresh.par_iter().map(of).collect();
        let mut raw = Vec::new();
        let again: Vec<Vec<usize>> =
            fresh.iter().map(|(member, _)| self.shape(member).columns.clone()).collect();
        let mut own = self.products.len();
        let mut begins = own + again.iter().map(Vec::len).sum::<usize>();
        for (((member, _), (energy, form)), columns) in fresh.iter().zip(made).zip(&again) {
            let mut places = |columns: Vec<Stacked>| {
                let from = begins;
                begins += columns.len();
                raw.extend(columns);
                (from..begins).collect()
            };
            let departures = form.departures.into_iter().map(&mut places).collect();
            let neighbours = places(form.neighbours);
            let places = Places { own: (own..own + columns.len()).collect(), departures, neighbours, energy };
            own += columns.len();
            self.forms.insert((member.atom, member.shape), places);
        }
        if !fresh.is_empty() {
            self.products.push_again(&again.concat(), self.atoms.columns());
            self.products.push(self.noise, &raw, self.atoms.columns());
            self.projection.extend(&mut self.screen, &self.products);
        }
    }

    fn columns(&self, member: &Member) -> &[usize] {
        let looked = self.forms.get(&(member.atom, member.shape));
        looked.map_or(&self.shape(member).columns, |places| &places.own)
    }

    /// The form of a member, where it was looked at.
    fn form(&self, member: &Member) -> Option<&Places> {
        let form = self.forms.get(&(member.atom, member.shape))?;
        (form.departures.len() == member.departs.len()).then_some(form)
    }

    /// The columns of members with the variances of their coefficients beforehand.
    fn terms(&self, members: &[Member]) -> Vec<Term> {
        let mut terms = Vec::new();
        for member in members {
            let columns = self.columns(member);
            terms.extend(columns.iter().zip(&member.deviations).map(|(column, std)| (*column, std * std)));
            if let Some(form) = self.form(member) {
                for (group, departs) in form.departures.iter().zip(&member.departs) {
                    terms.extend(group.iter().map(|column| (*column, departs * departs)));
                }
                terms.extend(form.neighbours.iter().map(|column| (*column, NEIGHBOUR * NEIGHBOUR)));
            }
        }
        terms
    }

    /// A set with the best departures of its last member, or of all; None where none is admissible.
    fn weighed(&self, members: Vec<Member>, all: bool) -> Option<Set> {
        let mut set = Set { members, log: f64::NEG_INFINITY };
        let last = set.members.len();
        let order = if all { 0..last } else { last.saturating_sub(1)..last };
        if last == 0 {
            set.log = 0.0;
            return Some(set);
        }
        for number in order {
            if !self.atoms.all[set.members[number].atom].is_named() {
                set.log = set.log.max(self.log_of(&set.members).unwrap_or(f64::NEG_INFINITY));
                continue;
            }
            let member = &set.members[number];
            let groups = self.forms.get(&(member.atom, member.shape)).map_or(0, |form| form.departures.len());
            if member.departs.len() != groups {
                set.members[number].departs = vec![FORM[0]; groups];
            }
            set.members[number].log_forms = 0.0;
            set.log = self.log_of(&set.members).unwrap_or(f64::NEG_INFINITY);
            let mut log_forms = 0.0;
            for group in 0..groups {
                let mut logs = Vec::new();
                let mut best = (f64::NEG_INFINITY, FORM[0]);
                for departs in FORM {
                    set.members[number].departs[group] = departs;
                    if let Some(log) = self.log_of(&set.members) {
                        logs.push(log);
                        if log > best.0 {
                            best = (log, departs);
                        }
                    }
                }
                (set.log, set.members[number].departs[group]) = best;
                let sum: f64 = logs.iter().map(|log| (log - best.0).exp()).sum();
                log_forms += (sum / FORM.len() as f64).ln();
            }
            set.members[number].log_forms = log_forms;
            set.log += log_forms;
        }
        set.log.is_finite().then_some(set)
    }

    /// ln of the probability of a set as it stands, up to a constant.
    fn log_of(&self, members: &[Member]) -> Option<f64> {
        let given = Given::of(&self.screen, self.terms(members))?;
        self.admissible(members, &given.coefficients())?;
        let prior: f64 = members.iter().map(|member| member.log_prior + member.log_forms).sum();
        let orders: f64 = (1..=members.len()).map(|k| (k as f64).ln()).sum();
        Some(given.log_evidence(&self.rest, None) + prior - orders)
    }
}

fn keep(seen: &mut HashMap<Vec<usize>, Set>, set: Set) {
    let place = seen.entry(set.key()).or_insert_with(|| set.clone());
    if set.log > place.log {
        *place = set;
    }
}

/// The most probable first.
fn sorted(sets: HashMap<Vec<usize>, Set>) -> Vec<Set> {
    let mut all: Vec<(Vec<usize>, Set)> = sets.into_iter().collect();
    all.sort_by(|(key, a), (other, b)| b.log.total_cmp(&a.log).then_with(|| key.cmp(other)));
    all.into_iter().map(|(_, set)| set).collect()
}
