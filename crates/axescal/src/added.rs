//! What the effects of the document's model and the known gradients of the coils add to the readings.

use common::uncertainty;
use common::{Axis, Document, PerAxis, Quantity, procedure};
use nalgebra::{Matrix3, Vector3};
use physics::{EffectInstance, LeftOut, References, Setting};

use crate::Result;

/// What effects add to the readings of the recordings, nT along each sensor; a recording without any has no
/// rows.
#[derive(Clone, Debug, Default)]
pub struct Added {
    recordings: Vec<Vec<Vector3<f64>>>,
    /// Effects that could not act.
    pub left_out: Vec<LeftOut>,
}

impl Added {
    /// The field along a sensor that effects add in each row, nT; None where none acts.
    pub fn along(&self, recording: usize, sensor: Axis) -> Option<Vec<f64>> {
        let rows = self.recordings.get(recording).filter(|rows| !rows.is_empty())?;
        Some(rows.iter().map(|field| field[sensor.index()]).collect())
    }

    /// The largest of them, nT.
    pub fn largest(&self) -> f64 {
        let fields = self.recordings.iter().flatten().map(|field| field.amax());
        fields.filter(|field| field.is_finite()).fold(0.0, f64::max)
    }
}

/// Gradients of the coils and places of the sensors, as the document states them.
#[derive(Clone)]
pub struct Places {
    gradient_nt_per_m_a: Vector3<f64>,
    positions_m: Option<[Vector3<f64>; 3]>,
    /// Whether a gradient is stated with an uncertainty.
    uncertain: bool,
}

impl Places {
    pub fn of(document: &Document) -> Self {
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
    pub fn act(&self) -> bool {
        self.positions_m.is_some() && (self.gradient_nt_per_m_a != Vector3::zeros() || self.uncertain)
    }

    /// The same moved by one standard uncertainty of each number that is stated with one: its path, the
    /// uncertainty, what it becomes.
    pub fn moved(&self, document: &Document) -> Vec<(String, f64, Self)> {
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

/// Those of the sensors, μ, and of the coils, η.
pub type Directions = (Matrix3<f64>, Matrix3<f64>);

/// The model's effects that act in a recording for axescal.
pub fn effects(document: &Document) -> Result<Vec<EffectInstance>> {
    let all = physics::adopt(document).map_err(|error| error.at("model"))?;
    let acts = |effect: &EffectInstance| {
        let mut mine = document.recordings.iter().filter(|one| one.procedure == procedure::AXES_ORIENTATION);
        mine.any(|recording| effect.acts(recording))
    };
    Ok(all.into_iter().filter(acts).collect())
}

/// The reading with the effects and the gradients less the reading without, as field, for sensors and coils
/// in these directions; None: as the document states them.
pub fn added(
    (document, references): (&Document, References),
    effects: &[EffectInstance],
    places: &Places,
    directions: Option<Directions>,
) -> Result<Added> {
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
        let both = with.readings.iter().zip(&without.readings);
        all.recordings[index] = both.map(|(with, without)| (with - without).component_mul(&scale)).collect();
        all.left_out.extend(left_out);
    }
    Ok(all)
}
