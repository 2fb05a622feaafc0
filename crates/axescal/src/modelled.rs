//! The effects of the document's model, and the known gradients of the coils at the sensors' places: what they add to the readings is
//! taken off before the directions are sought, and what is uncertain about them is in the uncertainty of the directions.

use common::number::significant;
use common::uncertainty::{self, By};
use common::{AdoptedEffect, Axis, Document, PerAxis, Quantity, procedure};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};
use physics::{EffectInstance, LeftOut, References, Role, Setting};

use crate::joint::{self, Split};
use crate::observe::observe_without;
use crate::{AxesProblem, Error, Observation, Observations, Options, Solution, ac, solve};

/// Words for what the gradients add.
const GRADIENTS: &str = "the coils' known gradients at the sensors' places";

/// Rounds in which directions and effects settle: what effects add is some 10⁻⁴ of the field, and so is what the second round
/// leaves of what the first one had wrong.
const ROUNDS: usize = 2;

/// What effects add to the readings of the recordings, nT along each sensor; a recording without any has no rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Added {
    recordings: Vec<Vec<Vector3<f64>>>,
    left_out: Vec<LeftOut>,
}

impl Added {
    /// The field along a sensor that effects add in each row, nT; None where none acts.
    pub fn along(&self, recording: usize, sensor: Axis) -> Option<Vec<f64>> {
        let rows = self.recordings.get(recording).filter(|rows| !rows.is_empty())?;
        Some(rows.iter().map(|field| field[sensor.index()]).collect())
    }

    fn largest(&self) -> f64 {
        let fields = self.recordings.iter().flatten().map(|field| field.amax());
        fields.filter(|field| field.is_finite()).fold(0.0, f64::max)
    }
}

/// Readings without what the model's effects add to them, and the directions that follow from them.
pub(crate) struct Solved {
    pub observations: Observations,
    pub solution: Solution,
    pub split: Split,
}

/// Takes the effects off and solves.
pub(crate) fn solve_without(document: &Document, options: &Options) -> Result<Solved, Error> {
    let fits = ac::Fits::default();
    let mut observations = observe_without(document, options, &Added::default(), &fits)?;
    let effects = effects(document)?;
    let places = Places::of(document);
    if effects.is_empty() && !places.act() {
        let mut solution = solve(document, &observations, options)?;
        let split = joint::restate(document, &observations, &mut solution, Vec::new())?;
        return Ok(Solved { observations, solution, split });
    }
    let mut directions = None;
    let mut rounds = 0;
    loop {
        let added = added(document, &effects, &places, directions)?;
        observations = observe_without(document, options, &added, &fits)?;
        let mut solution = solve(document, &observations, options)?;
        rounds += 1;
        if rounds == ROUNDS {
            let taken = Taken { document, options, effects: &effects, places: &places, fits: &fits };
            let by = taken.by(&observations, &solution)?;
            let split = joint::restate(document, &observations, &mut solution, by)?;
            observations.findings.extend(words(&effects, &places, &added));
            return Ok(Solved { observations, solution, split });
        }
        directions = Some((solution.fit.state.mu, solution.fit.state.eta));
    }
}

/// Gradients of the coils and places of the sensors, as the document states them.
#[derive(Clone)]
struct Places {
    gradient_nt_per_m_a: Vector3<f64>,
    positions_m: Option<[Vector3<f64>; 3]>,
    /// Whether a gradient is stated with an uncertainty.
    uncertain: bool,
}

impl Places {
    fn of(document: &Document) -> Self {
        let coils = document.facility.as_ref().and_then(|facility| facility.coils.as_ref());
        let stated = |coil: Axis| coils?.get(coil)?.gradient_nt_per_m_a.as_ref();
        let positions = document.instrument.as_ref().and_then(|instrument| instrument.positions_m.as_ref());
        let place = |positions: &PerAxis<[f64; 3]>, sensor: Axis| {
            positions.get(sensor).map_or_else(Vector3::zeros, |place| Vector3::from(*place))
        };
        Self {
            gradient_nt_per_m_a: Vector3::from(
                Axis::ALL.map(|coil| stated(coil).map_or(0.0, Quantity::value)),
            ),
            uncertain: Axis::ALL
                .into_iter()
                .any(|coil| stated(coil).and_then(Quantity::std).is_some_and(|std| std > 0.0)),
            positions_m: positions.map(|positions| Axis::ALL.map(|sensor| place(positions, sensor))),
        }
    }

    /// Whether they make a difference, or may.
    fn act(&self) -> bool {
        self.positions_m.is_some() && (self.gradient_nt_per_m_a != Vector3::zeros() || self.uncertain)
    }

    /// The same moved by one standard uncertainty of each number that is stated with one: its path, the uncertainty, what it becomes.
    fn moved(&self, document: &Document) -> Vec<(String, f64, Self)> {
        let mut all = Vec::new();
        if !self.act() {
            return all;
        }
        let coils = document.facility.as_ref().and_then(|facility| facility.coils.as_ref());
        for coil in Axis::ALL {
            let stated = coils.and_then(|coils| coils.get(coil)?.gradient_nt_per_m_a.as_ref()?.std());
            let mut moved = self.clone();
            moved.gradient_nt_per_m_a[coil.index()] += stated.unwrap_or(0.0);
            all.extend(stated.map(|std| (uncertainty::gradient(coil), std, moved)));
        }
        let stated = document.instrument.as_ref().and_then(|instrument| instrument.positions_std_m);
        for (sensor, k) in Axis::ALL.into_iter().flat_map(|sensor| (0..3).map(move |k| (sensor, k))) {
            let mut moved = self.clone();
            if let Some(places) = &mut moved.positions_m {
                places[sensor.index()][k] += stated.unwrap_or(0.0);
            }
            all.extend(stated.map(|std| (uncertainty::place(sensor, k), std, moved)));
        }
        all.retain(|(_, std, _)| *std > 0.0);
        all
    }
}

/// The model's effects that act in a recording for axescal.
fn effects(document: &Document) -> Result<Vec<EffectInstance>, Error> {
    let all = physics::adopt(document).map_err(|error| error.at("model"))?;
    let acts = |effect: &EffectInstance| {
        let mut mine = document.recordings.iter().filter(|one| one.procedure == procedure::AXES_ORIENTATION);
        mine.any(|recording| effect.acts(recording))
    };
    Ok(all.into_iter().filter(acts).collect())
}

/// The reading with the effects and the gradients less the reading without, as field, for sensors and coils in these directions; None: as
/// the document states them.
fn added(
    document: &Document,
    effects: &[EffectInstance],
    places: &Places,
    directions: Option<(Matrix3<f64>, Matrix3<f64>)>,
) -> Result<Added, Error> {
    let references = References::of(document);
    let mut all = Added { recordings: vec![Vec::new(); document.recordings.len()], left_out: Vec::new() };
    for (index, recording) in document.recordings.iter().enumerate() {
        let acting: Vec<EffectInstance> =
            effects.iter().filter(|effect| effect.acts(recording)).cloned().collect();
        if recording.procedure != procedure::AXES_ORIENTATION || (acting.is_empty() && !places.act()) {
            continue;
        }
        let at = |error: physics::Error| error.at(&format!("recordings[{index}]"));
        let mut setting = Setting::of(document, recording, references).map_err(at)?;
        if let Some((mu, eta)) = directions {
            (setting.basic.mu, setting.basic.eta) = (mu, eta);
        }
        let Setting { basic, mut context } = setting;
        (context.gradient_nt_per_m_a, context.positions_m) = (places.gradient_nt_per_m_a, places.positions_m);
        let (with, left_out) = physics::predict_acting(&basic, &acting, &context).map_err(at)?;
        context.gradient_nt_per_m_a = Vector3::zeros();
        let without = physics::predict(&basic, &[], &context).map_err(at)?;
        let scale = Vector3::from(basic.sensors.map(|sensor| sensor.sensitivity));
        all.recordings[index] = with
            .readings
            .iter()
            .zip(&without.readings)
            .map(|(with, without)| (with - without).component_mul(&scale))
            .collect();
        all.left_out.extend(left_out);
    }
    Ok(all)
}

/// What was taken off the readings of a document.
struct Taken<'a> {
    document: &'a Document,
    options: &'a Options,
    effects: &'a [EffectInstance],
    places: &'a Places,
    fits: &'a ac::Fits,
}

impl Taken<'_> {
    /// How the unknowns err with the parameters of the effects, with gradients and places: C Jᵀ Δ for each unit, Δ the change of the
    /// readings.
    fn by(&self, observations: &Observations, solution: &Solution) -> Result<By, Error> {
        let adopted: Vec<&AdoptedEffect> =
            self.document.model.iter().flat_map(|model| &model.effects).collect();
        let mut by = Vec::new();
        for (number, effect) in self.effects.iter().enumerate() {
            let Some(stated) = adopted.iter().find(|one| stands_for(one, effect)) else { continue };
            for (place, info) in effect.kind.parameters().iter().enumerate() {
                let std = stated.parameters.get(info.name).and_then(Quantity::std).unwrap_or(0.0);
                if std <= 0.0 || info.role == Role::Epoch {
                    continue;
                }
                let mut moved = self.effects.to_vec();
                moved[number].parameters[place] += std;
                let shift = self.shift((&moved, self.places), std, observations, solution)?;
                by.push((uncertainty::effect(stated, info.name), shift));
            }
        }
        for (path, std, moved) in self.places.moved(self.document) {
            by.push((path, self.shift((self.effects, &moved), std, observations, solution)?));
        }
        Ok(by)
    }

    /// By how much the unknowns move for each unit of what was moved by `std`.
    fn shift(
        &self,
        (effects, places): (&[EffectInstance], &Places),
        std: f64,
        observations: &Observations,
        solution: &Solution,
    ) -> Result<Vec<f64>, Error> {
        let directions = Some((solution.fit.state.mu, solution.fit.state.eta));
        let moved = added(self.document, effects, places, directions)?;
        let moved = observe_without(self.document, self.options, &moved, self.fits)?;
        let change = |(before, after): (&Observation, &Observation)| {
            (after.value_nt - before.value_nt) / (before.std_nt * solution.noise.of(before) * std)
        };
        let mut change: Vec<f64> = observations.readings.iter().zip(&moved.readings).map(change).collect();
        AxesProblem::new(observations, &solution.freedom, solution.noise).whiten(&mut change);
        let unknowns = solution.meaning.len();
        let gradient = Mat::from_fn(unknowns, 1, |k, _| {
            change
                .iter()
                .enumerate()
                .map(|(row, change)| solution.fit.jacobian[(row, k)] * change)
                .sum::<f64>()
        });
        let shift = &solution.covariance * &gradient;
        Ok((0..unknowns).map(|k| shift[(k, 0)]).collect())
    }
}

/// Whether an entry of the model is this effect.
fn stands_for(adopted: &AdoptedEffect, effect: &EffectInstance) -> bool {
    adopted.effect == effect.kind.name()
        && adopted.sensor.or(adopted.coil) == effect.axis
        && adopted.column == effect.column
        && adopted.recording == effect.recording
}

/// What is to be said of it.
fn words(effects: &[EffectInstance], places: &Places, added: &Added) -> Vec<String> {
    let mut names: Vec<&str> = Vec::new();
    for name in effects.iter().map(|effect| effect.kind.name()) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let largest = added.largest();
    let model = (!names.is_empty()).then(|| format!("{} of the model", names.join(", ")));
    let taken: Vec<String> = places.act().then(|| GRADIENTS.to_string()).into_iter().chain(model).collect();
    let mut words =
        vec![format!("taken off the readings, at most {} nT: {}", significant(largest, 3), taken.join(", "))];
    let mut told: Vec<(&str, &str)> = Vec::new();
    for LeftOut { recording, who, what } in &added.left_out {
        if !told.contains(&(who, what)) {
            told.push((who, what));
            words.push(format!("{who} is left out in \"{recording}\", for want of {what}"));
        }
    }
    words
}
