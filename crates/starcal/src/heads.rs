//! Sensors and the first camera, and the other heads against the first: d = D d₁, the field in the frame of one by that
//! in the frame of the other. The field of the model cancels; what is left are the errors of two attitudes.

use faer::Mat;
use nalgebra::{Matrix3, Rotation3, Vector3};
use physics::frames::{ARCSEC, polar};

use crate::Error;
use crate::axes::{Axes, no_axes};
use crate::choose::{Chosen, choose};
use crate::fit::{Fit, Flight, Kinds};
use crate::layout::Layout;
use crate::partial::{DIRECTIONS, PLACES};
use crate::terms::{Direction, Follows, Space, Term, turned, twelve};

/// Rounds in which the turn of a head settles.
const ROUNDS: usize = 2;
/// A matrix that is further than this from a rotation is not one.
const NOT_TURNED: f64 = 0.01;
const EQUAL: Kinds = [[1.0; DIRECTIONS]; PLACES];

pub struct First {
    pub terms: Vec<(Term, f64)>,
    /// Terms that may be in place of one.
    pub rivals: Vec<(Term, Term, f64)>,
    pub fit: Fit,
    pub without: Fit,
    pub axes: Axes,
}

pub struct Head {
    /// Its place among the cameras.
    pub camera: usize,
    /// From the first to this one.
    pub turn: Rotation3<f64>,
    /// Of turns about its axes, arcsec².
    pub covariance: Mat<f64>,
    pub terms: Vec<(Follows, f64)>,
    pub fit: Fit,
}

/// Fits sensors and the first camera. Errors: what the rows do not determine.
pub fn first(flight: &Flight, layout: &Layout, stated: &Matrix3<f64>) -> Result<First, Error> {
    let axes_of = |fit: &Fit| Axes::of(&fit.values[..12], stated).ok_or_else(no_axes);
    let base = twelve(flight.count);
    let without = flight.settled(&base, &EQUAL)?;
    let axes = axes_of(&without)?;
    let candidates: Vec<(Term, Vec<Direction>)> =
        Term::all(layout).into_iter().map(|term| (term, term.directions(layout, &axes))).collect();
    let may = |term: Term, taken: &[(Term, f64)]| {
        term.after().is_none_or(|first| taken.iter().any(|(one, _)| *one == first))
    };
    let Chosen { terms, rivals, fit } = choose(flight, (base, without.clone()), &candidates, may)?;
    let axes = axes_of(&fit)?;
    Ok(First { terms, rivals, fit, without, axes })
}

/// Fits another head. Errors: as [`first`].
pub fn head(flight: &Flight, layout: &Layout, camera: usize) -> Result<Head, Error> {
    if flight.rows().iter().flatten().sum::<f64>() == 0.0 {
        let why = "it has no attitude at a time at which the first camera has one";
        return Err(Error::Unanswerable(why.into()));
    }
    let space = Space { signals: layout.signals(camera) };
    let zero = Vector3::zeros();
    // All nine elements, then turns about the nearest rotation.
    let nine: Vec<Direction> = (0..9)
        .map(|k| {
            let mut unit = Matrix3::zeros();
            unit[(k % 3, k / 3)] = 1.0;
            space.still(&unit, &zero)
        })
        .collect();
    let found = flight.settled(&nine, &EQUAL)?;
    let free = Matrix3::from_column_slice(&found.values);
    let nearest = polar(&free).filter(|turn| turn.determinant() > 0.0 && (free - turn).norm() < NOT_TURNED);
    let Some(nearest) = nearest else {
        return Err(Error::Unanswerable("its attitudes are not those of the first camera with one turn; check the order of its quaternions, their signs and their times".into()));
    };
    let mut turn = Rotation3::from_matrix_unchecked(nearest);
    let about = |turn: &Rotation3<f64>| -> Vec<Direction> {
        let turns = (0..3).map(|k| space.still(&(turned(k) * turn.matrix()), &zero));
        [space.still(turn.matrix(), &zero)].into_iter().chain(turns).collect()
    };
    for _ in 0..ROUNDS {
        let fit = flight.settled(&about(&turn), &found.variances)?;
        let by = Vector3::from_column_slice(&fit.values[1..4]) * -ARCSEC;
        turn = Rotation3::from_scaled_axis(by) * turn;
    }
    let base = about(&turn);
    let without = flight.settled(&base, &found.variances)?;
    let of = |follows: Follows| -> (Follows, Vec<Direction>) {
        (follows, (0..3).map(|k| space.followed(follows, &(turned(k) * turn.matrix()), &zero)).collect())
    };
    let candidates: Vec<_> = Follows::all(layout).into_iter().map(of).collect();
    let Chosen { terms, fit, .. } = choose(flight, (base, without), &candidates, |_, _| true)?;
    let by = Vector3::from_column_slice(&fit.values[1..4]) * -ARCSEC;
    let covariance = fit.covariance.submatrix(1, 1, 3, 3).to_owned();
    Ok(Head { camera, turn: Rotation3::from_scaled_axis(by) * turn, covariance, terms, fit })
}
