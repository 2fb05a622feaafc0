//! Directions of the sensors in SEN and of the coils in GEO, in arcseconds.
//!
//! The recordings give, for orientations γ of the sensor block, M = μᵀ R(γ) (η B_c + e) + o (NASA eq. 12 and
//! 30) with B_c the full field along the coils, e the field left in GEO, o the offsets left of the sensors.
//! [`run`] finds μ and η by Gauss-Newton on unit spheres, together with whatever else the recordings show or
//! the document states with an uncertainty: e, o, small corrections of each R, scales.
//!
//! [`design`] takes the derivatives of one orientation from the same problem. Informations of orientations
//! add; what theodolites leave open is eliminated from each (Schur complement), and scales, offsets and the
//! residual field stay in with their priors.

mod ac;
mod added;
mod assumptions;
mod checks;
pub mod design;
mod doubts;
mod freedom;
mod joint;
mod means;
mod model;
mod modelled;
mod observations;
mod observe;
mod options;
mod pair;
mod rank;
mod result;
mod scales;
mod scatter;
mod solve;
mod start;
mod unknowns;
mod words;

pub use common::Error;
pub use options::{Options, Start};
pub use words::summary;

use common::{AxesCalibration, Document};
use model::AxesProblem;
use modelled::Modelled;
use observations::{NoiseFactors, NoiseSource, Observation, Observations, OrientationGroup};
use solve::{Solution, solve};
use unknowns::{AxesState, Freedom};

type Result<T, E = Error> = std::result::Result<T, E>;

/// Finds the directions and writes them to `calibration.axes`, or, of one sensor or coil alone, to
/// `calibration.axes.subset`; everything else stays as it was.
pub fn run(document: Document, options: &Options) -> Result<Document> {
    directed(document, options).map_err(|error| {
        error.of_fit(|why| {
            format!(
                "the fit of the directions failed: {why}. Readings may be paired with the wrong orientations, or the start may be far off: try --robust, or --start=document with a first model"
            )
        })
    })
}

fn directed(mut document: Document, options: &Options) -> Result<Document> {
    // Observe and solve; what effects add depends on the directions, and is known better with those found.
    let modelled = Modelled::of(&document, options)?;
    let mut observations = modelled.observe(None)?;
    let mut solution = solve(&document, &observations, options)?;
    for _ in 1..modelled.rounds() {
        let state = &solution.fit.state;
        observations = modelled.observe(Some((state.mu, state.eta)))?;
        solution = solve(&document, &observations, options)?;
    }

    // What the directions owe to what was known before.
    let by_effects = modelled.by(&observations, &solution)?;
    let split = joint::restate(&document, &observations, &mut solution, by_effects)?;

    // Tell.
    let mut found = result::describe(&document, &observations, &solution, options)?;
    let axes = &mut document.calibration.get_or_insert_default().axes;
    if options.is_subset() {
        axes.get_or_insert_default().subset = Some(Box::new(found));
        return Ok(document);
    }
    if let Some(before) = axes.take() {
        keep(&mut found, before, options);
    }
    *axes = Some(found);
    joint::adopt(&mut document, &observations, &solution, &split)?;
    Ok(document)
}

/// Keys that this version does not know stay, and so does what was given as known.
fn keep(axes: &mut AxesCalibration, before: AxesCalibration, options: &Options) {
    axes.known_coils = before.known_coils;
    if options.known_coils && axes.known_coils.is_none() {
        axes.known_coils = before.coils.clone();
    }
    let pairs = [(&mut axes.sensors, before.sensors), (&mut axes.coils, before.coils)];
    for (now, before) in pairs {
        if let (Some(now), Some(before)) = (now, before) {
            now.extra = before.extra;
        }
    }
    axes.extra = before.extra;
    axes.subset = before.subset;
}
