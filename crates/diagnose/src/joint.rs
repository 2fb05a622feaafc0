//! What was fitted, with all that it has in common with what was known before: `calibration.uncertainty`.
//!
//! With J the whitened derivatives of the readings by the unknowns, N = JᵀJ with what is known beforehand,
//! and N⁺ its inverse along the directions that the recordings show, a fit moves the unknowns by N⁺Jᵀ times
//! what the document leaves. Where a parameter of the document errs by one unit, the unknowns err by a, and
//! after the fit by
//!
//! ```text
//! a − N⁺JᵀJ a
//! ```
//!
//! which is nothing of what the recordings show, and all of the rest. What is wrong with the drive is no
//! unknown, and acts like an error b of the coils' constants: the fit takes it up as −N⁺JᵀJ b. The readings'
//! own errors are N⁺JᵀJN⁺, and what forms leave comes on top.

use common::uncertainty::{self, Block, By};
use common::{AdoptedEffect, Axis, Document, Quantity, Uncertainty};
use faer::Mat;
use nalgebra::Vector3;
use physics::{EffectInstance, Kind, Parameter, Role, frames};

mod stated;

use crate::algebra::inverse;
use crate::codes;
use crate::fit::Fit;
use crate::model::{Model, Unknown, path};
use crate::{Error, Ground};
pub use stated::state;

/// An unknown shows where a fit meets all of its error but this share.
const SHOWN: f64 = 1e-3;

/// Unknowns by their number, each with a weight.
type Weights = Vec<(usize, f64)>;

/// A parameter of the document.
struct Place {
    path: String,
    /// How it moves with the unknowns of the fit; none where the fit does not move it.
    row: Weights,
    /// How unknowns err where it errs; none where it is new.
    error: Weights,
    /// What it acts like in the recordings.
    seen: Weights,
    /// Variance beside that of the fit.
    own: f64,
}

impl Place {
    fn of(path: String, row: Weights, error: Weights) -> Self {
        Self { path, row, seen: error.clone(), error, own: 0.0 }
    }
}

/// Takes the constants of a fit and its effects, which stand in `model.effects`, into the joint uncertainty:
/// `joint` is that of the document as it came. Gives that with the paths of what was fitted.
pub fn adopted(
    document: &Document,
    model: &Model<'_>,
    ground: &Ground,
    mut joint: Uncertainty,
    known: usize,
) -> Result<(Uncertainty, Vec<String>), Error> {
    let (fit, rest, rows) = (&ground.fit, &ground.look.rest, model.observed.rows);
    let readings = fit.jacobian.submatrix(0, 0, rows, fit.jacobian.ncols());
    let inverse = inverse(fit.jacobian.as_ref().as_ref())?;
    let met = &inverse * (readings.transpose() * readings);
    // Where the document states nothing, what the recordings do not show has no uncertainty that could be
    // told.
    let shown = &inverse * (fit.jacobian.transpose() * &*fit.jacobian);
    let unknown =
        |k: usize| k < model.unknowns.len() && joint.sources.is_empty() && 1.0 - shown[(k, k)] > SHOWN;
    let places = places(document, model, fit, (&joint, known), &unknown);
    // What is known beforehand counts with the readings, a theodolite's setting of the block for one, unless
    // the document states it: then its sources bring it in.
    let own = |k: usize| {
        let states = |place: &Place| place.error.iter().any(|(i, _)| *i == k) && joint.std(&place.path) > 0.0;
        !places.iter().any(states)
    };
    let beforehand = model.known(&fit.state);
    let beside: Vec<usize> = (0..beforehand.len()).filter(|row| own(beforehand[*row].0)).collect();
    let count = fit.jacobian.ncols();
    let further = Mat::from_fn(beside.len(), count, |i, j| fit.jacobian[(rows + beside[i], j)]);
    let (by_readings, by_others) = (&inverse * readings.transpose(), &inverse * further.transpose());
    let spread = &by_readings * by_readings.transpose() + &by_others * by_others.transpose();
    let at =
        |matrix: &Mat<f64>, a: usize, b: usize| if a < count && b < count { matrix[(a, b)] } else { 0.0 };
    let fitted: Vec<&Place> = places.iter().filter(|place| !place.row.is_empty()).collect();
    let covariance = |a: &Place, b: &Place| -> f64 {
        let pairs = a.row.iter().flat_map(|x| b.row.iter().map(move |y| (x, y)));
        let one = |((i, x), (j, y)): (&(usize, f64), &(usize, f64))| {
            x * y * (at(&spread, *i, *j) + at(&fit.beyond, *i, *j))
        };
        let own = if a.path == b.path { a.own } else { 0.0 };
        rest.scale() * pairs.map(one).sum::<f64>() + own
    };
    let by = |of: &Place, place: &Place| -> f64 {
        let errs = |(k, x): &(usize, f64)| {
            let direct: f64 = of.error.iter().filter(|(i, _)| i == k).map(|(_, a)| a).sum();
            let met: f64 = of.seen.iter().map(|(i, b)| at(&met, *k, *i) * b).sum();
            x * (direct - met)
        };
        place.row.iter().map(errs).sum()
    };
    let known = places.iter().filter(|of| joint.std(&of.path) > 0.0);
    let by: By =
        known.map(|of| (of.path.clone(), fitted.iter().map(|place| by(of, place)).collect())).collect();
    let parameters: Vec<String> = fitted.iter().map(|place| place.path.clone()).collect();
    let block = Block {
        name: "diagnose: readings".into(),
        degrees_of_freedom: rest.known + rest.freedom,
        covariance: Mat::from_fn(fitted.len(), fitted.len(), |a, b| covariance(fitted[a], fitted[b])),
        parameters: parameters.clone(),
        by,
    };
    joint
        .put(block)
        .map_err(|found| Error::Unanswerable(format!("the covariance of what was fitted is {found}")))?;
    Ok((joint, parameters))
}

/// All parameters that have to do with a fit.
fn places(
    document: &Document,
    model: &Model<'_>,
    fit: &Fit,
    (joint, known): (&Uncertainty, usize),
    unknown: &dyn Fn(usize) -> bool,
) -> Vec<Place> {
    let stated = Stated { document, model, joint };
    let mut places = stated.constants();
    // What stays where the document has it has the uncertainty that it had.
    let stays = |place: &Place| {
        let of = |k: usize| fit.state.base.get(k) == Some(&0.0) || unknown(k);
        place.row.iter().any(|(k, _)| of(*k))
    };
    places.iter_mut().filter(|place| stays(place)).for_each(|place| place.row.clear());
    for mut directions in [false, true].map(|coils| stated.directions(fit, coils)) {
        if directions.iter().any(stays) {
            directions.iter_mut().for_each(|place| place.row.clear());
        }
        places.extend(directions);
    }
    let free = model.free(&fit.state);
    let effects: &[AdoptedEffect] = document.model.as_ref().map_or(&[], |model| &model.effects);
    for (k, (number, parameter)) in free.into_iter().enumerate() {
        let (Some(adopted), effect) = (effects.get(number), &fit.state.effects[number]) else { continue };
        let info = &effect.kind.parameters()[parameter];
        let factor = if info.role == Role::Shape { effect.parameters[parameter] } else { 1.0 };
        let k = model.unknowns.len() + k;
        let error = if number < known { vec![(k, 1.0 / factor)] } else { Vec::new() };
        places.push(Place::of(uncertainty::effect(adopted, info.name), vec![(k, factor)], error));
    }
    for (number, effect) in fit.state.effects.iter().enumerate().skip(known) {
        let (Kind::Quantisation, Some(adopted)) = (effect.kind, effects.get(number)) else { continue };
        places.extend(stated.codes(fit, effect, adopted));
    }
    places.extend(stated.drives());
    places
}

/// A document with the unknowns of its model.
struct Stated<'m, 'a> {
    document: &'m Document,
    model: &'m Model<'a>,
    joint: &'m Uncertainty,
}

impl Stated<'_, '_> {
    fn unknown(&self, unknown: Unknown) -> Option<usize> {
        self.model.unknowns.iter().position(|own| *own == unknown)
    }

    /// An unknown of the chain of the readings, by its unit.
    fn chain(&self, parameter: Parameter) -> Option<usize> {
        let of = |own: &Unknown| matches!(own, Unknown::Chain(own, _) if *own == parameter);
        self.model.unknowns.iter().position(of)
    }

    /// Sensitivities, offsets, coils' constants and the field without drive. The uncertainty of what was
    /// found to be added to an offset is that of the sum; that of a component of the field without drive, of
    /// the sum with the coils' offsets.
    fn constants(&self) -> Vec<Place> {
        let fields = Axis::ALL.map(|axis| self.unknown(Unknown::Field(axis)));
        let is_sum = |axis: Axis| self.joint.std(&uncertainty::residual_field(axis)) > 0.0;
        let run = self.model.observed.runs.first();
        let along = |component: Axis, coil: Axis| {
            run.map_or(0.0, |run| run.setting.basic.eta[(component.index(), coil.index())])
        };
        let mut places = Vec::new();
        for (k, unknown) in self.model.unknowns.iter().enumerate() {
            let Some(path) = path(self.document.calibration.as_ref(), unknown) else { continue };
            let mut place = Place::of(path, vec![(k, 1.0)], vec![(k, 1.0)]);
            match unknown {
                Unknown::Chain(Parameter::CoilOffset(axis), _) => {
                    for component in Axis::ALL.into_iter().filter(|component| is_sum(*component)) {
                        let field = fields[component.index()];
                        place.error.extend(field.map(|field| (field, -along(component, *axis))));
                    }
                    place.seen = place.error.clone();
                }
                Unknown::Field(axis) => {
                    for coil in Axis::ALL {
                        let own = self.chain(Parameter::CoilOffset(coil));
                        place.row.extend(own.map(|own| (own, along(*axis, coil))));
                    }
                }
                _ => {}
            }
            places.push(place);
        }
        places
    }

    /// The nine cosines of the sensors, or of the coils, by their turns. A turn that the fit leaves out is an
    /// unknown behind all others, which nothing moves.
    fn directions(&self, fit: &Fit, coils: bool) -> Vec<Place> {
        let run = self.model.observed.runs.first();
        let Some(basic) = run.map(|run| &run.setting.basic) else { return Vec::new() };
        let (matrix, paths) = match coils {
            true => (&basic.eta, uncertainty::directions("coils")),
            false => (&basic.mu, uncertainty::directions("sensors")),
        };
        let turn = |axis: Axis, which: usize| match coils {
            true => Parameter::CoilTurn(axis, which),
            false => Parameter::SensorTurn(axis, which),
        };
        let mut places = Vec::new();
        for axis in Axis::ALL {
            let turns = [0, 1].map(|which| self.chain(turn(axis, which)));
            if turns == [None, None] {
                continue;
            }
            let shift = turns.map(|turn| turn.map_or(0.0, |k| fit.state.base[k]));
            let direction = matrix.column(axis.index()).normalize();
            let (along, moved) =
                (frames::tangents(&direction), frames::turned_derivatives(&direction, shift));
            let behind =
                |which: usize| fit.jacobian.ncols() + 6 * usize::from(coils) + 2 * axis.index() + which;
            let place = |which: usize| turns[which].unwrap_or_else(|| behind(which));
            for component in 0..3 {
                let weights = |of: &[Vector3<f64>; 2]| [0, 1].map(|k| (place(k), of[k][component])).to_vec();
                let path = paths[3 * axis.index() + component].clone();
                places.push(Place::of(path, weights(&moved), weights(&along)));
            }
        }
        places
    }

    /// The width of a sensor's codes, known in units of its readings: in nT it goes with the sensitivity.
    fn codes(&self, fit: &Fit, codes: &EffectInstance, adopted: &AdoptedEffect) -> Option<Place> {
        let (axis, width) = (codes.axis?, *codes.parameters.first()?);
        let (basic, _) = self.model.setting(&fit.state, 0);
        let sensitivity = basic.sensors[axis.index()].sensitivity;
        let unknown = self.chain(Parameter::Sensitivity(axis));
        let path = uncertainty::effect(adopted, codes.kind.parameters()[0].name);
        let row = unknown.map(|k| (k, width / sensitivity)).into_iter().collect();
        let own = codes::width_std(self.model, &fit.state, codes).powi(2);
        Some(Place { own, ..Place::of(path, row, Vec::new()) })
    }

    /// Resistors and the voltmeter, where no current was read as such.
    fn drives(&self) -> Vec<Place> {
        let mut places: Vec<Place> = Vec::new();
        for coil in Axis::ALL {
            let mut recordings = self.model.observed.runs.iter().map(|run| run.recording);
            let Some(k) = self.chain(Parameter::CoilConstant(coil)) else { continue };
            if recordings.any(|recording| recording.axis_column("coil", coil, "a").is_some()) {
                continue;
            }
            let constant = self.document.calibration.as_ref().and_then(|calibration| calibration.coil(coil));
            let constant =
                constant.and_then(|coil| coil.constant_nt_per_a.as_ref()).map_or(1.0, Quantity::value);
            let offset = self.chain(Parameter::CoilOffset(coil));
            for (path, like) in uncertainty::of_current(self.document, coil, constant) {
                let seen = std::iter::once((k, like[0])).chain(offset.map(|offset| (offset, like[1])));
                match places.iter_mut().find(|place| place.path == path) {
                    Some(place) => place.seen.extend(seen),
                    None => {
                        places.push(Place { seen: seen.collect(), ..Place::of(path, Vec::new(), Vec::new()) })
                    }
                }
            }
        }
        places
    }
}
