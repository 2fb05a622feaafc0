//! What effects and gradients of the coils add to the readings, and where gradients and places are stated.

use common::{Axis, Document, PerAxis, Quantity, uncertainty};
use nalgebra::{Matrix3, Vector3};
use physics::LeftOut;

/// What effects add to the readings of the recordings, nT along each sensor; no rows where none do.
#[derive(Clone, Debug, Default)]
pub struct Added {
    pub recordings: Vec<Vec<Vector3<f64>>>,
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
    pub gradient_nt_per_m_a: Vector3<f64>,
    pub positions_m: Option<[Vector3<f64>; 3]>,
    /// Whether a gradient is stated with an uncertainty.
    uncertain: bool,
}

impl Places {
    pub fn of(document: &Document) -> Self {
        let coils = document.facility.as_ref().and_then(|facility| facility.coils.as_ref());
        let stated = |coil: Axis| coils?.get(coil)?.gradient_nt_per_m_a.as_ref();
        let positions = document.instrument.as_ref().and_then(|instrument| instrument.positions_m.as_ref());
        let place = |positions: &PerAxis<[f64; 3]>, sensor: Axis| {
            Vector3::from(positions.get(sensor).copied().unwrap_or_default())
        };
        let std = |coil: &Axis| stated(*coil).and_then(Quantity::std);
        Self {
            gradient_nt_per_m_a: Axis::ALL.map(|coil| stated(coil).map_or(0.0, Quantity::value)).into(),
            uncertain: Axis::ALL.iter().filter_map(std).any(|std| std > 0.0),
            positions_m: positions.map(|positions| Axis::ALL.map(|sensor| place(positions, sensor))),
        }
    }

    pub fn act(&self) -> bool {
        self.positions_m.is_some() && (self.gradient_nt_per_m_a != Vector3::zeros() || self.uncertain)
    }

    /// Moved by one standard uncertainty of each uncertain number: its path, the uncertainty, the model.
    pub fn moved(&self, document: &Document) -> Vec<(String, f64, Self)> {
        if !self.act() {
            return Vec::new();
        }
        let mut all = Vec::new();
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
