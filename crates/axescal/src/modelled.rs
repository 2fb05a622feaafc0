//! The effects of the document's model, and the known gradients of the coils at the sensors' places: taken
//! off the readings beforehand, with their uncertainty in that of the directions.

use common::number::significant;
use common::uncertainty::{self, By};
use common::{AdoptedEffect, Code, Document, Finding, Quantity, procedure};
use faer::Mat;
use indexmap::IndexSet;
use nalgebra::Vector3;
use physics::{EffectInstance, LeftOut, References, Role, Setting};
use rayon::prelude::*;

use crate::added::{Added, Directions, Places};
use crate::observe::observe;
use crate::{AxesProblem, Observation, Observations, Options, Result, Solution, ac};

const GRADIENTS: &str = "the coils' known gradients at the sensors' places";

/// Rounds in which directions and effects settle: what effects add is some 10⁻⁴ of the field, and so is what
/// the second round leaves of what the first one had wrong.
const ROUNDS: usize = 2;

/// The readings of a document, less what the model's effects and the gradients add to them.
pub struct Modelled<'a> {
    document: &'a Document,
    references: References,
    options: &'a Options,
    effects: Vec<EffectInstance>,
    places: Places,
    fits: ac::Fits,
}

impl<'a> Modelled<'a> {
    pub fn of(document: &'a Document, options: &'a Options) -> Result<Self> {
        let mut effects = physics::adopt(document).map_err(|error| error.at("model"))?;
        let mine = || document.recordings.iter().filter(|one| one.procedure == procedure::AXES_ORIENTATION);
        effects.retain(|effect| mine().any(|recording| effect.acts(recording)));
        let (places, references) = (Places::of(document), References::of(document));
        Ok(Self { document, references, options, effects, places, fits: ac::Fits::default() })
    }

    fn acts(&self) -> bool {
        !self.effects.is_empty() || self.places.act()
    }

    /// In how many rounds directions and effects settle, each with the directions of the one before.
    pub fn rounds(&self) -> usize {
        if self.acts() { ROUNDS } else { 1 }
    }

    /// The readings, with sensors and coils in these directions; None: as the document states them.
    pub fn observe(&self, directions: Option<Directions>) -> Result<Observations> {
        if !self.acts() || directions.is_none() {
            // Of recordings that cannot be read, no effect says why.
            let as_read = self.observe_without(&Added::default())?;
            if !self.acts() {
                return Ok(as_read);
            }
        }
        let added = self.added(&self.effects, &self.places, directions)?;
        let mut observations = self.observe_without(&added)?;
        observations.findings.extend(words(&self.effects, &self.places, &added));
        Ok(observations)
    }

    fn observe_without(&self, added: &Added) -> Result<Observations> {
        observe((self.document, self.references), self.options, added, &self.fits)
    }

    /// The reading with effects and gradients less the reading without, as field, for sensors and coils in
    /// these directions; None: as the document states them.
    fn added(
        &self,
        effects: &[EffectInstance],
        places: &Places,
        directions: Option<Directions>,
    ) -> Result<Added> {
        let recordings = &self.document.recordings;
        let mut all = Added { recordings: vec![Vec::new(); recordings.len()], left_out: Vec::new() };
        for (index, recording) in recordings.iter().enumerate() {
            let acting: Vec<EffectInstance> =
                effects.iter().filter(|effect| effect.acts(recording)).cloned().collect();
            if recording.procedure != procedure::AXES_ORIENTATION || (acting.is_empty() && !places.act()) {
                continue;
            }
            let at = |error: physics::Error| error.at(&format!("recordings[{index}]"));
            let Setting { mut basic, mut context } =
                Setting::of(self.document, recording, self.references).map_err(at)?;
            (basic.mu, basic.eta) = directions.unwrap_or((basic.mu, basic.eta));
            context.gradient_nt_per_m_a = places.gradient_nt_per_m_a;
            context.positions_m = places.positions_m;
            let (with, left_out) = physics::predict_acting(&basic, &acting, &context).map_err(at)?;
            context.gradient_nt_per_m_a = Vector3::zeros();
            let without = physics::predict(&basic, &[], &context).map_err(at)?;
            let scale = Vector3::from(basic.sensors.map(|sensor| sensor.sensitivity));
            let both = with.readings.iter().zip(&without.readings);
            all.recordings[index] =
                both.map(|(with, without)| (with - without).component_mul(&scale)).collect();
            all.left_out.extend(left_out);
        }
        Ok(all)
    }

    /// How the unknowns err with effects, gradients and places: C Jᵀ Δ, Δ the change of the readings.
    pub fn by(&self, observations: &Observations, solution: &Solution) -> Result<By> {
        let adopted = || self.document.model.iter().flat_map(|model| &model.effects);
        let mut moves: Vec<(String, f64, Vec<EffectInstance>, Places)> = Vec::new();
        for (number, effect) in self.effects.iter().enumerate() {
            let Some(stated) = adopted().find(|one| stands_for(one, effect)) else { continue };
            for (place, info) in effect.kind.parameters().iter().enumerate() {
                let std = stated.parameters.get(info.name).and_then(Quantity::std).unwrap_or(0.0);
                if std <= 0.0 || info.role == Role::Epoch {
                    continue;
                }
                let mut moved = self.effects.clone();
                moved[number].parameters[place] += std;
                moves.push((uncertainty::effect(stated, info.name), std, moved, self.places.clone()));
            }
        }
        let places = self.places.moved(self.document).into_iter();
        moves.extend(places.map(|(path, std, moved)| (path, std, self.effects.clone(), moved)));
        let shift = |(path, std, effects, places): (String, f64, Vec<EffectInstance>, Places)| {
            Ok((path, self.shift((&effects, &places), std, observations, solution)?))
        };
        moves.into_par_iter().map(shift).collect()
    }

    /// By how much the unknowns move for each unit of what was moved by `std`.
    fn shift(
        &self,
        (effects, places): (&[EffectInstance], &Places),
        std: f64,
        observations: &Observations,
        solution: &Solution,
    ) -> Result<Vec<f64>> {
        let directions = Some((solution.fit.state.mu, solution.fit.state.eta));
        let moved = self.observe_without(&self.added(effects, places, directions)?)?;
        let change = |(before, after): (&Observation, &Observation)| {
            (after.value_nt - before.value_nt) / (before.std_nt * solution.noise.of(before) * std)
        };
        let mut change: Vec<f64> = observations.readings.iter().zip(&moved.readings).map(change).collect();
        AxesProblem::new(observations, &solution.freedom, solution.noise).whiten(&mut change);
        let jacobian = &solution.fit.jacobian;
        let gradient = Mat::from_fn(solution.meaning.len(), 1, |k, _| {
            change.iter().enumerate().map(|(row, change)| jacobian[(row, k)] * change).sum::<f64>()
        });
        let shift = &solution.covariance * &gradient;
        Ok(shift.col_as_slice(0).to_vec())
    }
}

fn stands_for(adopted: &AdoptedEffect, effect: &EffectInstance) -> bool {
    adopted.effect == effect.kind.name()
        && adopted.sensor.or(adopted.coil) == effect.axis
        && adopted.column == effect.column
        && adopted.recording == effect.recording
}

fn words(effects: &[EffectInstance], places: &Places, added: &Added) -> Vec<Finding> {
    let names: IndexSet<&str> = effects.iter().map(|effect| effect.kind.name()).collect();
    let names: Vec<&str> = names.into_iter().collect();
    let model = (!names.is_empty()).then(|| format!("{} of the model", names.join(", ")));
    let taken: Vec<String> = places.act().then(|| GRADIENTS.to_string()).into_iter().chain(model).collect();
    let mut words = vec![Code::ModelSubtracted.about(significant(added.largest(), 3)).said(format!(
        "subtracted from the readings, at most {} nT: {}",
        significant(added.largest(), 3),
        taken.join(", ")
    ))];
    let mut told: IndexSet<(&str, &str)> = IndexSet::new();
    for LeftOut { recording, who, what } in &added.left_out {
        if told.insert((who, what)) {
            let said = format!("{who} is not applied in \"{recording}\": {what} is missing");
            words.push(Code::EffectNotApplied.said(said));
        }
    }
    words
}
