//! What a weighed set says in figures: gains, coefficients, where its members act, what it leaves; and whether it is
//! possible, for what its members do at their coefficients must be what their equations say.

use super::{Member, Sets};
use crate::atoms::Atom;
use crate::decide::{CANCEL, FORM_ENERGY};
use crate::evidence::{Given, energy};
use crate::stacked::Stacked;

/// Least share of the product itself in the energy of structure that follows it and each of the two.
const PRODUCT: f64 = 0.1;

impl Sets<'_, '_, '_> {
    /// Forms, and structure along what an effect itself follows, do no more than a part of what their effects
    /// do; names of one sensor do not cancel each other.
    pub(super) fn admissible(&self, members: &[Member], coefficients: &[f64]) -> Option<()> {
        let mut own: Vec<(&Atom, Vec<(usize, f64)>)> = Vec::new();
        for (member, parts) in members.iter().zip(self.split(members, coefficients)) {
            let sizes = parts[0];
            let atom = self.atom(member);
            let columns = self.columns(member);
            // What it does is more of what its equation says, and not its opposite.
            if atom.finite && self.whole(member, parts, 1.0) <= self.whole(member, parts, -1.0) {
                return None;
            }
            // The product of two is none where only one of the two acts.
            if atom.is_product() {
                let of = |count: usize| energy(&self.screen, &columns[..count], &sizes[..count]);
                if of(1) < PRODUCT * of(columns.len()) {
                    return None;
                }
            }
            own.push((atom, columns.iter().copied().zip(sizes.iter().copied()).collect()));
            if self.departure(member, parts) > FORM_ENERGY {
                return None;
            }
        }
        self.apart(&own)
    }

    /// Share of a member's energy by which it departs from its form, its own coefficients and those of its
    /// departures and of its neighbouring shapes being these.
    pub(super) fn departure(&self, member: &Member, parts: [&[f64]; 3]) -> f64 {
        let Some(form) = self.form(member) else { return 0.0 };
        // A wave of order k is 1/k of the contribution at most, and half of that squared on the average.
        let orders = form.departures.iter().flat_map(|group| 1..=group.len());
        let departure: f64 = orders.zip(parts[1]).map(|(k, a)| 0.5 * (a / k as f64).powi(2)).sum();
        let whole = self.whole(member, parts, 0.0) / form.energy.max(f64::MIN_POSITIVE);
        if departure > 0.0 { departure / whole } else { 0.0 }
    }

    /// Energy of what a member does, with something more of its first column. A shape between two of the grid is one of
    /// them and a part of the way to the next.
    fn whole(&self, member: &Member, [sizes, _, neighbours]: [&[f64]; 3], more: f64) -> f64 {
        let own = self.columns(member);
        let beside = self.form(member).map_or(&[][..], |form| &form.neighbours);
        let mut sizes = [sizes, neighbours].concat();
        sizes[0] += more;
        energy(&self.screen, &[own, beside].concat(), &sizes)
    }

    /// See [`Self::admissible`].
    fn apart(&self, own: &[(&Atom, Vec<(usize, f64)>)]) -> Option<()> {
        let of = |terms: &[(usize, f64)]| {
            let (columns, sizes): (Vec<usize>, Vec<f64>) = terms.iter().copied().unzip();
            energy(&self.screen, &columns, &sizes)
        };
        for (number, (atom, terms)) in own.iter().enumerate().filter(|(_, (atom, _))| atom.is_named()) {
            for (other, theirs) in own.iter().skip(number + 1).chain(&own[..number]) {
                if atom.is_fuller(other) {
                    return None;
                }
                let same = atom.sensor().is_some() && atom.sensor() == other.sensor();
                if !same {
                    continue;
                }
                if !other.is_named() {
                    if atom.follows(other) && of(theirs) > FORM_ENERGY * of(terms) {
                        return None;
                    }
                    continue;
                }
                let (alone, both) = (of(terms) + of(theirs), of(&[&terms[..], &theirs[..]].concat()));
                if both < CANCEL * alone {
                    return None;
                }
            }
        }
        Some(())
    }

    /// The coefficients of all terms member by member: its own, those of its departures, and of its neighbouring shapes.
    pub(super) fn split<'c>(&self, members: &[Member], coefficients: &'c [f64]) -> Vec<[&'c [f64]; 3]> {
        let mut left = coefficients;
        let mut take = |count: usize| {
            let (taken, rest) = left.split_at(count);
            left = rest;
            taken
        };
        let of = |member: &Member| {
            let own = take(self.shape(member).columns.len());
            let form = self.form(member);
            let departs = take(form.map_or(0, |form| form.departures.iter().map(Vec::len).sum()));
            let neighbours = take(form.map_or(0, |form| form.neighbours.len()));
            [own, departs, neighbours]
        };
        members.iter().map(of).collect()
    }

    /// By how much the sum of squares falls with some of a set's members, their forms as in the whole set.
    pub fn gain(&self, members: &[Member]) -> f64 {
        match Given::of(&self.screen, self.terms(members)) {
            Some(given) => self.screen.sum_of_squares() - given.left(),
            None => 0.0,
        }
    }

    /// The same where none departs from its equation.
    pub fn gain_exact(&self, members: &[Member]) -> f64 {
        let exact = |member: &Member| Member { departs: Vec::new(), ..member.clone() };
        let members: Vec<Member> = members.iter().map(exact).collect();
        self.gain(&members)
    }

    /// How many coefficients members have, departures from their forms apart.
    pub fn unknowns(&self, members: &[Member]) -> usize {
        members.iter().map(|member| self.shape(member).columns.len()).sum()
    }

    /// What members leave of a fit's whitened residual, the calibration fitted again.
    pub fn residual(&self, members: &[Member], white: &[f64]) -> Vec<f64> {
        let terms = self.terms(members);
        let columns: Vec<usize> = terms.iter().map(|(column, _)| *column).collect();
        let Some(given) = Given::of(&self.screen, terms) else { return white.to_vec() };
        let terms: Vec<(usize, f64)> = columns.into_iter().zip(given.coefficients()).collect();
        self.projection.left(&self.products.less(white, &terms))
    }

    /// What each of a set's members contributes to the readings, nT.
    pub fn contributions(&self, members: &[Member]) -> Option<Vec<Stacked>> {
        let of = |(member, sizes): (&Member, Vec<f64>)| {
            let columns = &self.shape(member).columns;
            let terms = columns.iter().map(|column| self.atoms.column(*column)).zip(sizes);
            Stacked::sum(&terms.collect::<Vec<_>>())
        };
        Some(members.iter().zip(self.coefficients(members)?).map(of).collect())
    }

    /// What each member contributes, in the order of the columns of its shape.
    pub fn coefficients(&self, members: &[Member]) -> Option<Vec<Vec<f64>>> {
        let given = Given::of(&self.screen, self.terms(members))?;
        let all = given.coefficients();
        Some(self.split(members, &all).into_iter().map(|[own, ..]| own.to_vec()).collect())
    }

    /// Share of its energy by which each of a set's members departs from its form.
    pub fn departures(&self, members: &[Member]) -> Vec<f64> {
        let given = Given::of(&self.screen, self.terms(members));
        let Some(coefficients) = given.map(|given| given.coefficients()) else {
            return vec![0.0; members.len()];
        };
        let split = self.split(members, &coefficients);
        members.iter().zip(split).map(|(member, own)| self.departure(member, own)).collect()
    }
}
