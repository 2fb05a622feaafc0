//! The report's correction in two passes, held against readings that were left out of the fit.
//!
//! "Zero field constants" give the field along each of the three sensors; with these the fields across are
//! calculated and taken off: the first pass. The second starts from the fields so corrected.

use common::{Axis, CrossFieldFit, Document, HeldOut, Quantity};
use nalgebra::{Matrix3, Vector3};
use physics::{Basic, Kind, Unit};

use crate::Result;
use crate::departure::used;
use crate::effects::{KINDS, Sought, shapes};
use crate::fit::{self, Problem};
use crate::readings::{Run, output};
use crate::sensitivity::Constants;
use crate::shape::{Place, Shape};

/// Parts into which readings are dealt out to be left out one after the other.
const FOLDS: usize = 3;

pub struct LeftOut {
    pub run: usize,
    pub row: usize,
    /// What the fit misses it by without effects of fields across, constants and leans found beside them, nT.
    pub missed_nt: f64,
    /// The effects' parameters as the other readings give them, in the order of [`shapes`], nT.
    pub parameters: [f64; 5],
}

fn place(kind: Kind, number: usize) -> usize {
    if kind == Kind::CrossField { number } else { 3 + number }
}

/// Rms of readings that were left out, with the constants and the lean alone and corrected for the field
/// across as it was applied, and the readings; None where the others do not suffice.
pub fn left_out(
    problem: &Problem<'_, '_>,
    (sought, first): (&[Sought], usize),
    (shape, place_of): (&Shape, Place),
) -> Result<Option<(HeldOut, Vec<LeftOut>)>> {
    let mut sums = [0.0; 2];
    let mut all = Vec::new();
    for fold in 0..FOLDS {
        let part = |taken: bool| -> Vec<Run<'_>> {
            let mut part = problem.runs.to_vec();
            for run in &mut part {
                let rows = run.rows.iter().enumerate().filter(|(i, _)| (i % FOLDS == fold) == taken);
                run.rows = rows.map(|(_, row)| *row).collect();
            }
            part
        };
        let (kept, asked) = (part(false), part(true));
        let allowed = fit::noise(&kept, shape, place_of)?;
        let reduced = Problem { runs: &kept, known: Vec::new(), allowed: &allowed, ..problem.clone() };
        for (which, unknowns) in [&problem.unknowns[..first], &problem.unknowns[..]].into_iter().enumerate() {
            let reduced = reduced.with(unknowns.to_vec());
            let Ok(fit) = reduced.solve() else { return Ok(None) };
            if fit.linear.rank < unknowns.len() {
                return Ok(None);
            }
            let missed = reduced.missed(&fit, &asked)?;
            sums[which] += missed.iter().map(|r| r * r).sum::<f64>();
            if which == 0 {
                continue;
            }
            let mut parameters = [0.0; 5];
            let mut taken = vec![0.0; missed.len()];
            for (one, value) in sought.iter().zip(&fit.values[first..]) {
                parameters[place(one.kind, one.number)] = *value;
                let column = used(&asked, &one.column);
                taken.iter_mut().zip(column).for_each(|(taken, unit)| *taken += value * unit);
            }
            let rows =
                asked.iter().enumerate().flat_map(|(run, of)| of.rows.iter().map(move |row| (run, *row)));
            all.extend(rows.zip(missed.iter().zip(&taken)).map(|((run, row), (missed, taken))| LeftOut {
                run,
                row,
                missed_nt: missed + taken,
                parameters,
            }));
        }
    }
    let [before_nt, after_nt] = sums.map(|sum| (sum / all.len() as f64).sqrt());
    let held_out = HeldOut { before_nt, after_nt, readings: all.len(), ..HeldOut::default() };
    Ok((!all.is_empty()).then_some((held_out, all)))
}

/// A sensor's constants without a field across, and its parameters in the order of [`shapes`].
#[derive(Clone, Copy)]
pub struct Corrected {
    pub sensitivity: f64,
    pub offset_nt: f64,
    /// Parameters of the effects of fields across, nT.
    pub parameters: [f64; 5],
}

/// Rms of the readings that were left out after the first and the second pass; None where a recording does
/// not have the readings of all three sensors. `mu` holds the sensors' directions in SEN.
pub fn score(
    runs: &[Run<'_>],
    sensor: Axis,
    left_out: &[LeftOut],
    (sensors, mu): (&[Corrected; 3], &Matrix3<f64>),
) -> Option<[f64; 2]> {
    let to_sen = mu.transpose().try_inverse()?;
    let mut sums = [0.0; 2];
    for left in left_out {
        let run = &runs[left.run];
        let mut along = Vector3::zeros();
        for axis in Axis::ALL {
            let (readings, unit) = output(run.context.recording, &run.path, axis).ok()?;
            if unit != run.context.unit || !readings[left.row].is_finite() {
                return None;
            }
            let of = &sensors[axis.index()];
            along[axis.index()] = of.sensitivity * readings[left.row] + of.offset_nt;
        }
        let mut corrected = along;
        for sum in &mut sums {
            let sen: [f64; 3] = (to_sen * corrected).into();
            let taken = |axis: Axis| {
                let parameters =
                    if axis == sensor { &left.parameters } else { &sensors[axis.index()].parameters };
                let shapes = shapes(axis, &sen, corrected[axis.index()]);
                parameters.iter().zip(shapes).map(|(parameter, shape)| parameter * shape).sum::<f64>()
            };
            let all = Axis::ALL.map(taken);
            *sum += (left.missed_nt - all[sensor.index()]).powi(2);
            corrected = along - Vector3::from(all);
        }
    }
    (!left_out.is_empty()).then(|| sums.map(|sum| (sum / left_out.len() as f64).sqrt()))
}

/// What the corrections need of a sensor: its constants as they were found, else as the document states them.
pub fn corrected(
    document: &Document,
    (sensor, unit): (Axis, Unit),
    constants: Option<&Constants>,
    across: Option<&CrossFieldFit>,
) -> Corrected {
    let stated = Basic::of(document, unit).sensors[sensor.index()];
    let (sensitivity, offset_nt) = constants
        .filter(|found| found.unit == unit)
        .map_or((stated.sensitivity, stated.offset_nt), |found| (found.sensitivity, found.offset_nt));
    let value = |kind: Kind, number: usize| {
        let of = across.map(|fit| if kind == Kind::CrossField { &fit.offset } else { &fit.sensitivity });
        of.and_then(|of| of.get(kind.parameters()[number].name)).map_or(0.0, Quantity::value)
    };
    let mut parameters = [0.0; 5];
    for kind in KINDS {
        (0..kind.parameters().len()).for_each(|number| parameters[place(kind, number)] = value(kind, number));
    }
    Corrected { sensitivity, offset_nt, parameters }
}
