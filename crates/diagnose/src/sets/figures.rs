//! What a weighed set says in figures: gains, coefficients, where its members act, what it leaves.

use super::{Member, Sets};
use crate::evidence::Given;
use crate::stacked::Stacked;

impl Sets<'_, '_, '_> {
    /// By how much the sum of squares falls with some of a set's members, their forms and sizes as in the
    /// whole set.
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
        members.iter().map(|member| self.atoms.all[member.atom].shapes[member.shape].columns.len()).sum()
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
            let columns = &self.atoms.all[member.atom].shapes[member.shape].columns;
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
        let Some(given) = Given::of(&self.screen, self.terms(members)) else {
            return vec![0.0; members.len()];
        };
        let coefficients = given.coefficients();
        let split = self.split(members, &coefficients);
        members.iter().zip(split).map(|(member, own)| self.departure(member, own)).collect()
    }
}
