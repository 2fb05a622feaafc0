//! Housekeeping columns that the difference of one axis follows, each with a lag.

use common::{Followed, Quantity};
use estimate::cosine::{Errors, Projection, weighted};
use estimate::line_search;
use estimate::stats::mean;
use physics::memory::{Before, Signal};
use std::f64::consts::PI;

use crate::Error;
use crate::difference::Noise;
use crate::drift::{self, Beside, Columns, Curve};
use crate::housekeeping::Housekeeping;

/// Most columns that one axis follows.
const MOST: usize = 3;
/// Steps of the search of a lag between two of these, each of so many lags' logarithms.
const REFINEMENTS: usize = 12;
/// Half the change of ln τ over which the derivative with respect to it is taken.
const APART: f64 = 0.02;
/// Lags: none, and from so many steps to this share of the recording by factors.
const SHORTEST_STEPS: f64 = 3.0;
const LONGEST: f64 = 0.25;
const FACTOR: f64 = 1.6;

/// A housekeeping column through a lag of first order.
struct Lagged {
    lag_s: f64,
    transform: Vec<f64>,
}

/// A housekeeping column with all its lags.
pub struct Candidate {
    name: String,
    values: Vec<f64>,
    lags: Vec<Lagged>,
}

/// A column that an axis follows.
#[derive(Clone)]
pub struct Follows {
    /// Its name.
    pub name: String,
    /// s; 0 for none.
    lag_s: f64,
    /// Probability by chance.
    p: f64,
    /// The lagged column less its mean; where there is a lag, its derivative with respect to ln τ, less its
    /// own.
    pub columns: Vec<Vec<f64>>,
    /// The mean of the lagged column.
    pub at: f64,
}

impl Follows {
    fn of(name: &str, values: &[f64], step_s: f64, lag_s: f64, p: f64) -> Self {
        let mut columns = vec![lagged(values, step_s, lag_s)];
        let at = mean(&columns[0]);
        if lag_s > 0.0 {
            let [later, earlier] = [APART, -APART].map(|apart| lagged(values, step_s, lag_s * apart.exp()));
            columns.push(later.iter().zip(&earlier).map(|(a, b)| (a - b) / (2.0 * APART)).collect());
        }
        for column in &mut columns {
            let middle = mean(column);
            column.iter_mut().for_each(|value| *value -= middle);
        }
        Self { name: name.into(), lag_s, p, columns, at }
    }

    /// As a document has it, by the coefficients of its columns.
    pub fn document(&self, coefficients: &[Quantity]) -> Followed {
        let nt_per_unit = coefficients[0].clone();
        let lag_s = coefficients.get(1).map(|slope| {
            let relative = slope.std().unwrap_or(0.0) / nt_per_unit.value().abs();
            Quantity::new(self.lag_s, self.lag_s * relative)
        });
        Followed {
            column: self.name.clone(),
            lag_s,
            nt_per_unit,
            at: self.at,
            p: self.p,
            ..Followed::default()
        }
    }
}

/// A column through a lag of first order: τ dx/dt = column − x, in equilibrium at the first row.
pub fn lagged(values: &[f64], step_s: f64, lag_s: f64) -> Vec<f64> {
    if lag_s == 0.0 {
        return values.to_vec();
    }
    let time: Vec<f64> = (0..values.len()).map(|row| row as f64 * step_s).collect();
    Signal::new(&time, values.to_vec()).lagged(lag_s, Before::Equilibrium)
}

/// Those housekeeping columns that change, with their transforms.
pub fn candidates(columns: &Columns<'_>, housekeeping: &[Housekeeping]) -> Vec<Candidate> {
    let step_s = columns.pair.step_s;
    let longest = LONGEST * columns.length_s();
    let lags = || {
        let from = SHORTEST_STEPS * step_s;
        std::iter::once(0.0).chain(
            std::iter::successors(Some(from), |lag| Some(lag * FACTOR))
                .take_while(move |lag| *lag <= longest),
        )
    };
    let candidate = |column: &Housekeeping| {
        let values = column.whole()?;
        let of = |lag_s| Lagged { lag_s, transform: columns.transform(&lagged(&values, step_s, lag_s)) };
        Some(Candidate { name: column.name.clone(), lags: lags().map(of).collect(), values })
    };
    housekeeping.iter().filter_map(candidate).collect()
}

/// The columns that the readings `y` follow beside the reference's axes, a straight drift and `beside`, each
/// under the noise of what it leaves, until none is demanded any more: such a column counts by what it has
/// that time has not. Where none does, one may stand in the place of the drift if the readings are that much
/// more likely with it; one that another axis follows already, if they are more likely at all.
pub fn follows(
    columns: &Columns<'_>,
    y: &[f64],
    candidates: &[Candidate],
    established: &[String],
    beside: &Beside<'_>,
) -> Result<Vec<Follows>, Error> {
    let mut found: Vec<Follows> = Vec::new();
    let mut own = beside.own.to_vec();
    while found.len() < MOST {
        let left: Vec<&Candidate> =
            candidates.iter().filter(|one| found.iter().all(|known| known.name != one.name)).collect();
        let now = Beside { own: &own, lines_hz: beside.lines_hz };
        let best = match best(columns, y, &left, &now)? {
            None if found.is_empty() && established.is_empty() => {
                instead_of_time(columns, y, &left, drift::LEVEL, &now)?
            }
            None if found.is_empty() => {
                let known: Vec<&Candidate> =
                    left.into_iter().filter(|one| established.contains(&one.name)).collect();
                instead_of_time(columns, y, &known, 1.0, &now)?
            }
            best => best,
        };
        let Some(best) = best else { break };
        let place = own.len() - beside.own.len();
        own.splice(place..place, best.columns.iter().map(|column| columns.transform(column)));
        found.push(best);
    }
    Ok(found)
}

/// The candidate, with its lag, that explains most; None where chance over all of them explains as much.
fn best(
    columns: &Columns<'_>,
    y: &[f64],
    candidates: &[&Candidate],
    beside: &Beside<'_>,
) -> Result<Option<Follows>, Error> {
    if candidates.is_empty() {
        return Ok(None);
    }
    let (_, mut noise) = columns.straight(y, beside)?;
    let mut chosen = None;
    for _ in 0..drift::ROUNDS {
        let errors = noise.errors(&columns.cosine)?;
        let projection = Projection::of(&columns.with(&[], beside), y, &errors)?;
        let Some((one, curve)) = largest(candidates, &projection, &errors, y.len()) else { return Ok(None) };
        let lag_s = refined(columns, &errors, &projection, one, curve.place);
        let transform = columns.transform(&lagged(&one.values, columns.pair.step_s, lag_s));
        let regression = weighted(&columns.with(&[&transform], beside), y, &errors)?;
        let freedom = noise.freedom(&columns.cosine, &regression.influence[4]);
        let p = candidates.len() as f64 * drift::chance(curve.score, curve.length, freedom);
        noise = columns.noise(&regression, &errors, beside.lines_hz)?;
        chosen = Some((one, lag_s, p.min(1.0)));
    }
    let demanded = chosen.filter(|(_, _, p)| *p < drift::LEVEL);
    Ok(demanded.map(|(one, lag_s, p)| Follows::of(&one.name, &one.values, columns.pair.step_s, lag_s, p)))
}

/// The candidate that explains most in the place of a straight drift; None where the readings are not more
/// likely with it by one over `level`, over all candidates and lags.
fn instead_of_time(
    columns: &Columns<'_>,
    y: &[f64],
    candidates: &[&Candidate],
    level: f64,
    beside: &Beside<'_>,
) -> Result<Option<Follows>, Error> {
    if candidates.is_empty() {
        return Ok(None);
    }
    let axes: Vec<&[f64]> =
        columns.base().into_iter().take(3).chain(beside.own.iter().map(Vec::as_slice)).collect();
    let settled = |further: &[f64]| -> Result<Noise, Error> {
        let all: Vec<&[f64]> = axes.iter().copied().chain([further]).collect();
        let mut errors = Errors::independent(&columns.cosine);
        for _ in 0..drift::ROUNDS {
            let noise = columns.noise(&weighted(&all, y, &errors)?, &errors, beside.lines_hz)?;
            errors = noise.errors(&columns.cosine)?;
        }
        columns.noise(&weighted(&all, y, &errors)?, &errors, beside.lines_hz)
    };
    let with_time = settled(columns.base()[3])?;
    let errors = with_time.errors(&columns.cosine)?;
    let projection = Projection::of(&axes, y, &errors)?;
    let Some((one, curve)) = largest(candidates, &projection, &errors, y.len()) else { return Ok(None) };
    let lag_s = refined(columns, &errors, &projection, one, curve.place);
    let with_column = settled(&columns.transform(&lagged(&one.values, columns.pair.step_s, lag_s)))?;
    let tried = candidates.len() as f64 * (1.0 + curve.length / PI);
    let p = tried * (with_time.log_likelihood() - with_column.log_likelihood()).exp();
    Ok((p < level).then(|| Follows::of(&one.name, &one.values, columns.pair.step_s, lag_s, p)))
}

/// The candidate of the greatest score; None where no column says anything beside the others.
fn largest<'a>(
    candidates: &[&'a Candidate],
    projection: &Projection,
    errors: &Errors,
    kept: usize,
) -> Option<(&'a Candidate, Curve)> {
    let curve = |one: &&'a Candidate| {
        (*one, Curve::of(projection, errors, one.lags.iter().map(|lag| &lag.transform[..kept])))
    };
    let all = candidates.iter().map(curve).filter(|(_, curve)| curve.score > 0.0);
    all.max_by(|(_, a), (_, b)| a.score.total_cmp(&b.score))
}

/// The lag of the greatest score between the neighbours of one of the lags of a candidate, by golden sections
/// of its logarithm; without a lag none.
fn refined(
    columns: &Columns<'_>,
    errors: &Errors,
    projection: &Projection,
    one: &Candidate,
    place: usize,
) -> f64 {
    let score = |lag_s: f64| {
        let transform = columns.transform(&lagged(&one.values, columns.pair.step_s, lag_s));
        projection.direction(&transform, errors).map_or(0.0, |direction| projection.score(&direction).abs())
    };
    let best = one.lags[place].lag_s;
    if best == 0.0 {
        return 0.0;
    }
    let between = ((best / FACTOR).ln(), (best * FACTOR).ln());
    line_search::largest(between, REFINEMENTS, |ln| score(ln.exp())).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lag_is_of_first_order() {
        let mut step = vec![0.0; 400];
        step[100..].fill(1.0);
        let behind = lagged(&step, 2.0, 50.0);
        assert_eq!(lagged(&step, 2.0, 0.0), step);
        // 150 s after the step, three lags.
        assert!((behind[175] - (1.0 - (-3.0_f64).exp())).abs() < 0.01, "{}", behind[175]);
    }
}
