//! How an effect may depart from its equation: its contribution times smooth functions of what it follows and
//! of time, and what it does at neighbouring shapes.

use common::Axis;
use physics::EffectInstance;

use crate::Error;
use crate::atoms::{Atom, Atoms, of_one_sensor};
use crate::candidates::Shape;
use crate::channel::Channel;
use crate::covariates::{self, ALONG};
use crate::decide::FORM;
use crate::model::{self, Model};
use crate::proposal::What;
use crate::stacked::Stacked;
use crate::waves::{half_waves, place, range};

/// Highest power of a covariate, and half waves over the span of time.
const ORDERS: usize = 8;

/// The departures of an effect at a shape.
#[derive(Clone, Debug, Default)]
pub struct Form {
    /// Departures from the equation, group by group, each as large as the contribution over its order.
    pub departures: Vec<Vec<Stacked>>,
    /// What neighbouring shapes do more or less, and what is left of the time before each recording.
    pub neighbours: Vec<Stacked>,
}

/// The time constant, at one of its shapes, of an effect that remembers fields.
fn time_constant_s(effect: &EffectInstance, shape: &Shape) -> Option<f64> {
    let place = model::time_constant(effect.kind)?;
    let tau = shape.value.or(shape.form.as_ref().map(|fitted| fitted.parameters[place]));
    tau.filter(|tau| *tau > 0.0)
}

/// The highest order that could show: where departures of the largest share of a contribution, less with each
/// order, have half a unit of the noise's variance. `energy` is the contribution's, whitened.
pub fn orders(energy: f64) -> usize {
    let largest = FORM[FORM.len() - 1];
    ((largest * (2.0 * energy).sqrt()) as usize).min(ORDERS)
}

/// Fields in SEN, run by run, and the span of time: what forms are functions of.
pub struct Followed<'m, 'a> {
    model: &'m Model<'a>,
    fields: Vec<Vec<nalgebra::Vector3<f64>>>,
    span: Option<(f64, f64)>,
}

impl<'m, 'a> Followed<'m, 'a> {
    pub fn of(model: &'m Model<'a>, state: &crate::model::State) -> Result<Self, Error> {
        Ok(Self { model, fields: covariates::fields(model, state)?, span: model.observed.span() })
    }

    /// The form of an atom at one of its shapes, its coefficients being these.
    pub fn form(
        &self,
        atoms: &Atoms<'_>,
        atom: &Atom,
        shape: usize,
        coefficients: &[f64],
        orders: usize,
    ) -> Form {
        let What::Physics(effect) = &atom.what else { return Form::default() };
        let of = |shape: usize| {
            let columns = atom.shapes[shape].columns.iter().map(|column| atoms.column(*column));
            Stacked::sum(&columns.zip(coefficients.iter().copied()).collect::<Vec<_>>())
        };
        let (own, fitted) = (of(shape), &atom.shapes[shape]);
        let mut form = Form {
            departures: self.departures(effect, &own, orders),
            neighbours: self.before(&own, time_constant_s(effect, fitted)),
        };
        if fitted.is_fitted() {
            form.neighbours.extend(fitted.by_shape.iter().map(|column| atoms.column(*column).clone()));
            return form;
        }
        let beside = [
            shape.checked_sub(1),
            Some(shape + 1).filter(|next| *next < atom.shapes.len() && !atom.shapes[*next].is_fitted()),
        ];
        for other in beside.into_iter().flatten() {
            let alike = atom.shapes[other].form == fitted.form;
            if alike && atom.shapes[other].columns.len() == coefficients.len() {
                let other = of(other);
                form.neighbours.push(Stacked::sum(&[(&other, 1.0), (&own, -1.0)]));
            }
        }
        form.neighbours.retain(|column| !column.is_zero());
        form
    }

    /// What an effect that remembers may have kept of the time before each recording: it dies with the effect's time
    /// constant, and is as large as its contribution.
    fn before(&self, own: &Stacked, time_constant_s: Option<f64>) -> Vec<Stacked> {
        let Some(tau) = time_constant_s else { return Vec::new() };
        let of = |(channel, at): (usize, &Channel)| {
            let (part, time_s) = (own.part(channel)?, self.model.observed.runs[at.run].time_s?);
            let rms = (part.iter().map(|value| value * value).sum::<f64>() / part.len() as f64).sqrt();
            let left = |row: &usize| rms * ((time_s[0] - time_s[*row]) / tau).exp();
            let mut parts = vec![None; self.model.observed.channels.len()];
            parts[channel] = Some(at.rows.iter().map(left).collect());
            Some(Stacked::new(parts))
        };
        self.channels().enumerate().filter_map(of).collect()
    }

    /// A contribution times waves of what its effect follows and of time, group by group.
    pub fn departures(&self, effect: &EffectInstance, own: &Stacked, orders: usize) -> Vec<Vec<Stacked>> {
        let mut groups: Vec<Vec<Stacked>> = Vec::new();
        let mut add = |columns: Vec<Stacked>| {
            let group: Vec<Stacked> = columns.into_iter().filter(|column| !column.is_zero()).collect();
            if !group.is_empty() {
                groups.push(group);
            }
        };
        let mut names = covariates::of(effect);
        if of_one_sensor(effect).is_some() && !names.iter().any(|name| name == ALONG) {
            names.push(ALONG.into());
        }
        for name in &names {
            let values: Vec<Option<Vec<f64>>> =
                self.channels().map(|c| self.along(c, effect.axis, name)).collect();
            let Some(range) = range(values.iter().flatten().flatten()) else { continue };
            // Where there is no value, nothing departs.
            let there = own.times(|channel| {
                let known = |value: &f64| f64::from(u8::from(place(*value, range).is_some()));
                values[channel].as_ref().map(|values| values.iter().map(known).collect())
            });
            add(there.times_polynomials(orders, |channel| {
                let place = |value: &f64| place(*value, range).unwrap_or(0.0);
                values[channel].as_ref().map(|values| values.iter().map(place).collect())
            }));
        }
        if let Some(span) = self.span {
            add(own.times_polynomials(orders, |channel| {
                let channel = &self.model.observed.channels[channel];
                let run = &self.model.observed.runs[channel.run];
                channel.rows.iter().map(|row| half_waves(1, run, *row, span)).collect()
            }));
        }
        groups
    }

    fn channels(&self) -> impl Iterator<Item = &Channel> {
        self.model.observed.channels.iter()
    }

    /// A covariate at the rows of a channel.
    fn along(&self, channel: &Channel, axis: Option<Axis>, name: &str) -> Option<Vec<f64>> {
        let axis = axis.or(channel.axis());
        let values = covariates::values(self.model, &self.fields, channel.run, axis, name)?;
        Some(channel.rows.iter().map(|row| values[*row]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_could_not_show_is_left_out() {
        // A fifth of 3 standard deviations in a whole contribution shows nothing, of a thousand all orders
        // do.
        assert_eq!([9.0, 25.0, 1e6].map(orders), [0, 1, ORDERS]);
    }
}
