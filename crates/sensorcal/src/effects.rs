//! The catalogue's effects of fields across as columns beside a fit, and how errors of directions move them.

use common::Axis;
use nalgebra::Matrix3;
use physics::{FULL_NT, Kind, frames};

use crate::Result;
use crate::departure::{Candidate, beside, used, visible_share};
use crate::fit::Fit;
use crate::readings::Run;
use crate::sides::Directions;
use faer::Mat;

/// A parameter with less than this share of its neighbours' size, or of which less is left beside them, is not seen.
const VISIBLE: f64 = 0.2;
pub const KINDS: [Kind; 2] = [Kind::CrossField, Kind::CrossFieldSensitivity];

#[derive(Clone)]
pub struct Sought {
    pub kind: Kind,
    pub number: usize,
    /// What it adds to the field that is read, nT for each nT, by run and row.
    pub column: Vec<Vec<f64>>,
}

impl Sought {
    pub fn name(&self) -> &'static str {
        self.kind.parameters()[self.number].name
    }

    /// The same parameter where the directions are others.
    fn again(&self, runs: &[Run<'_>]) -> Result<Self> {
        Ok(Self { column: Candidate::effect(self.kind, self.number, runs)?.column, ..self.clone() })
    }
}

/// The runs with the coils in these directions, and each block turned about its sensor by an angle, rad.
pub fn turned<'a>(runs: &[Run<'a>], eta: &Matrix3<f64>, angle: impl Fn(usize) -> f64) -> Vec<Run<'a>> {
    let one = |(number, run): (usize, &Run<'a>)| {
        let mut run = run.clone();
        let at = run.sensor.index();
        let before = run.basic.mu.column(at).into_owned();
        let about = frames::small_rotation(&(before.normalize() * angle(number)));
        run.context.orientation.rotation = about * run.context.orientation.rotation;
        run.basic.eta = *eta;
        let along = run.context.orientation.rotation * eta.column(run.coil.index());
        run.basic.mu.set_column(at, &(along * along.dot(&before).signum()));
        run
    };
    runs.iter().enumerate().map(one).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}

/// The parameters of the catalogue's effects that these recordings tell apart, and those that they do not.
pub fn sought(runs: &[Run<'_>], design: &Mat<f64>) -> Result<(Vec<Sought>, Vec<Sought>)> {
    let (mut seen, mut unseen) = (Vec::new(), Vec::new());
    let mut wide = design.clone();
    for kind in KINDS {
        let all = (0..kind.parameters().len())
            .map(|number| Sought { kind, number, column: Vec::new() }.again(runs))
            .collect::<Result<Vec<Sought>>>()?;
        let most = all.iter().map(|one| largest(&used(runs, &one.column))).fold(0.0, f64::max);
        for one in all {
            let values = used(runs, &one.column);
            if largest(&values) > VISIBLE * most && visible_share(&wide, &values) > VISIBLE {
                wide = beside(&wide, &values);
                seen.push(one);
            } else {
                unseen.push(one);
            }
        }
    }
    Ok((seen, unseen))
}

/// Prior standard deviation of a parameter that is not identifiable, for each of [`KINDS`], nT: by the
/// parameters from `first` on of a fit, which belong to `seen`.
///
/// From the squares of the others of its effect, each weighted by the probability that it is not zero, with the
/// odds of the Bayesian information criterion, √n exp(−z²/2) against it. Their sum is divided by one less than
/// their number, for so few say little of their common size: of two normal values the mean square is too small
/// for a third one in more than half of all cases.
pub fn likely(seen: &[Sought], fit: &Fit, first: usize) -> [f64; 2] {
    let readings = fit.linear.freedom.max(1.0);
    KINDS.map(|kind| {
        let others = seen.iter().enumerate().filter(|(_, one)| one.kind == kind);
        let square = |(at, _): (usize, &Sought)| {
            let (value, std) = (fit.values[first + at], fit.type_a(first + at));
            value * value / (1.0 + readings.sqrt() * (-0.5 * (value / std).powi(2)).exp())
        };
        let squares: Vec<f64> = others.map(square).collect();
        (squares.iter().sum::<f64>() / squares.len().saturating_sub(1).max(1) as f64).sqrt()
    })
}

/// How errors of the directions, and parameters that cannot be told, move those that were found: each error
/// of one standard deviation as the readings' departure, over the used rows of all runs.
///
/// The parameters from `first` on of the fit belong to `seen`, which were calculated for `directions`;
/// `likely` are the standard deviations of those that cannot be told.
pub fn unknown(
    runs: &[Run<'_>],
    directions: &Directions,
    (seen, unseen): (&[Sought], &[Sought]),
    (fit, first): (&Fit, usize),
    likely: [f64; 2],
) -> Result<Vec<Vec<f64>>> {
    let size = |kind: Kind| likely[usize::from(kind == KINDS[1])];
    // By themselves: what was not seen.
    let scaled = |column: Vec<f64>, size: f64| column.iter().map(|value| value * size).collect::<Vec<f64>>();
    let mut errors: Vec<Vec<f64>> =
        unseen.iter().map(|one| scaled(used(runs, &one.column), size(one.kind))).collect();
    // By an error of the directions: the sum of what was seen, and each that was not.
    let still = |_| 0.0;
    let mut others: Vec<Vec<Run<'_>>> = directions.moved.iter().map(|eta| turned(runs, eta, still)).collect();
    for number in 0..runs.len() {
        let angle = |of: usize| if of == number { directions.aligned } else { 0.0 };
        others.push(turned(runs, &directions.eta, angle));
    }
    for other in others {
        let moved = |one: &Sought, size: f64| -> Result<Vec<f64>> {
            let after = used(&other, &one.again(&other)?.column);
            let both = after.iter().zip(used(runs, &one.column));
            Ok(both.map(|(after, before)| size * (after - before)).collect())
        };
        let mut sum = vec![0.0; fit.linear.residuals.len()];
        for (one, value) in seen.iter().zip(&fit.values[first..]) {
            sum.iter_mut().zip(moved(one, *value)?).for_each(|(sum, moved)| *sum += moved);
        }
        errors.push(sum);
        for one in unseen {
            errors.push(moved(one, size(one.kind))?);
        }
    }
    Ok(errors)
}

/// The sensor's two sides in the catalogue's order and the field along it: what each parameter of the effects
/// adds to a reading, nT for each nT; `sen` is the field in SEN, `along` that along the sensor, nT.
pub fn shapes(sensor: Axis, sen: &[f64; 3], along: f64) -> [f64; 5] {
    let full = |value: f64| value / FULL_NT;
    let (u, v) = (full(sen[(sensor.index() + 1) % 3]), full(sen[(sensor.index() + 2) % 3]));
    [u * u, v * v, u * v, full(along) * u, full(along) * v]
}
