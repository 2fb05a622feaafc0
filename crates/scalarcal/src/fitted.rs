//! From the factor of the products to the calibration, of rows at hand and of streams alike.

use common::{Noise, ScalarCalibration};
use physics::EffectInstance;

use crate::declared::{Given, declared_form};
use crate::design::Rows;
use crate::determined::{determined, short};
use crate::directions::frame;
use crate::factor::Factor;
use crate::fit::{FittedState, Sums, fit};
use crate::kalman::{Form, WHITE};
use crate::known::{Beforehand, beforehand};
use crate::linear::{Linear, unit};
use crate::model::{Model, NINE, Parameter, State};
use crate::read::Series;
use crate::solved::{Detail, Solved};
use crate::{Error, start};

/// Relative standard uncertainty with which a scale that nothing shows is held.
const HELD: f64 = 1e-9;

/// A fit with what it was made of.
pub struct Fitted {
    pub model: Model,
    /// What is known of the parameters beforehand.
    pub beforehand: Beforehand,
    /// Rows for what no reading shows and is held.
    pub held: Linear,
    /// Rows for what is known beforehand and used.
    pub known: Linear,
    pub found: FittedState,
    pub plain: Factor,
}

impl Fitted {
    /// Fits the factor of rows, from the sensors of a fit before or from those that the document states.
    ///
    /// # Errors
    ///
    /// As [`fit`], in the words of [`determined`] where rotations are missing.
    pub fn of(
        given: &Given<'_>,
        model: Model,
        rows: &Rows<'_>,
        before: Option<&Self>,
        plain: Factor,
    ) -> Result<Self, Error> {
        let beforehand = beforehand(given.document, given.unit, &given.scales, &model)?;
        let held = held(given, &model, &beforehand);
        let none = Linear::none(model.parameters.len());
        let known = if given.options.known { beforehand.rows.clone() } else { none };
        let starts = match before {
            Some(before) => {
                let mut neutral = model.nominal();
                neutral[..NINE].copy_from_slice(&before.found.state[..NINE]);
                vec![neutral]
            }
            None => start::starts(given, &model, &plain)?,
        };
        let sums = sums(given, &plain, &held);
        let found = fit(&model, &sums, &known, &starts).map_err(|error| {
            short(given, &model, &sums, rows, &starts, beforehand.rows.is_empty()).unwrap_or(error)
        })?;
        Ok(Self { model, beforehand, held, known, found, plain })
    }

    /// Fits again from a state.
    ///
    /// # Errors
    ///
    /// As [`fit`].
    pub fn again(&self, given: &Given<'_>, plain: &Factor, from: &State) -> Result<FittedState, Error> {
        let sums = sums(given, plain, &self.held);
        fit(&self.model, &sums, &self.known, std::slice::from_ref(from))
    }

    /// The calibration, with the noise that `noise` finds by a form that is declared and the unit of a
    /// residual, nT, where it is not declared white.
    ///
    /// # Errors
    ///
    /// As `noise`; rotations that do not determine the calibration.
    pub fn solved(
        mut self,
        given: &Given<'_>,
        (series, follows): (Vec<Series>, Vec<Vec<Vec<f64>>>),
        (effects, units): (Vec<EffectInstance>, Vec<f64>),
        noise: impl FnOnce(&mut Self, &Rows<'_>, Option<Form>, f64) -> Result<Option<(Form, Noise)>, Error>,
    ) -> Result<(Solved, Detail), Error> {
        let scales = given.scales;
        let unit_nt = scales.magnitude_nt * self.model.scale(&self.found.state);
        let alone = Noise { white_rms_nt: Some(self.found.variance.sqrt() * unit_nt), ..Noise::default() };
        let variance = given.sensor.map(|sensor| sensor + given.reference);
        let declared = declared_form(given.document, variance, &scales);
        let white = declared == Some(WHITE);
        let by_rotations = self.found.clone();
        let rows = Rows::new(&series, scales, &follows);
        let averaged = if white { None } else { noise(&mut self, &rows, declared, unit_nt)? };
        let (form, noise) = averaged.unwrap_or((WHITE, alone));
        let residuals = rows.residuals(&self.model, &self.found.state);
        let mut sources: Vec<_> = series.iter().map(|one| one.source).collect();
        sources.sort_unstable();
        sources.dedup();
        let Self { model, beforehand, held, known, found, plain } = self;
        let solved = Solved {
            unit: given.unit,
            scales,
            units,
            effects,
            form,
            white,
            known: held.and(&known),
            beforehand,
            held,
            mu: frame(&found.state, &given.mu),
            sources,
            scalar: ScalarCalibration {
                recordings: series.iter().map(|one| one.id.clone()).collect(),
                rows: plain.rows,
                missing: series.iter().map(|one| one.missing as u64).sum(),
                noise,
                includes_body: true,
                ..ScalarCalibration::default()
            },
            model,
            found,
        };
        let detail = Detail { series, residuals, follows, plain };
        determined(given, &solved, &by_rotations, &detail)?;
        Ok((solved, detail))
    }
}

fn sums<'a>(given: &Given<'_>, plain: &'a Factor, held: &'a Linear) -> Sums<'a> {
    Sums { plain, sensor: given.sensor, reference: given.reference, held }
}

/// The rows for scales that nothing shows.
fn held(given: &Given<'_>, model: &Model, beforehand: &Beforehand) -> Linear {
    let count = model.parameters.len();
    match (model.place(&Parameter::Magnitude), given.stated) {
        (Some(place), Some(std)) => {
            let weights: Vec<f64> = unit(place, count).iter().map(|one| one / std).collect();
            Linear::one(&weights, 1.0 / std)
        }
        // Only the ratio of magnitude and sensitivities is seen: the mean sensitivity is held at what is known
        // of it.
        (Some(_), None) if given.constant && !given.options.known => {
            let weights: Vec<f64> = (0..count).map(|j| if j < 3 { 1.0 / HELD } else { 0.0 }).collect();
            Linear::one(&weights, beforehand.nine[..3].iter().sum::<f64>() / HELD)
        }
        _ => Linear::none(count),
    }
}
