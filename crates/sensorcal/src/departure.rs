//! What a fit may leave out, looked for one by one beside what is in it.

use common::{Departure, Quantity};
use estimate::correlated::{self, Scale};
use estimate::{linear, stats};
use faer::Mat;
use physics::{EffectInstance, Kind, Parameter};

use crate::Result;
use crate::allowed::Allowed;
use crate::fit::{Fit, Problem, Unknown};
use crate::readings::Run;

/// A departure is claimed below this probability, adjusted for all that were looked for.
pub const FOUND_BELOW: f64 = 0.01;
/// The sensor's own noise explains residuals that chance makes so large with this probability.
const EXPLAINED: f64 = 0.01;
/// A departure whose χ² is within this of the best one's is as good: 99 % of one degree of freedom.
const RIVAL_WITHIN: f64 = 6.63;
/// Less than this of a departure left beside the fit, and the recordings cannot show it.
const VISIBLE: f64 = 1e-2;
/// Departures that are fitted together at most.
const MOST: usize = 2;

/// Something that a fit may leave out: one column, nT for each unit of its parameter.
#[derive(Clone)]
pub struct Candidate {
    pub name: &'static str,
    /// Its parameter; the unit stands in the key.
    pub parameter: &'static str,
    /// A series for each run, by row.
    pub column: Vec<Vec<f64>>,
}

impl Candidate {
    /// A parameter of an effect of the catalogue, all others zero: its derivative there.
    pub fn effect(kind: Kind, parameter: usize, runs: &[Run<'_>]) -> Result<Self> {
        let column = runs.iter().map(|run| {
            let at = run.sensor.index();
            let effect = EffectInstance::new(kind, Some(run.sensor), vec![0.0; kind.parameters().len()]);
            let asked = [Parameter::Effect(0, parameter)];
            let (_, derivatives) =
                physics::predict_with_jacobian(&run.basic, &[effect], &run.context, &asked)
                    .map_err(|error| error.at(&run.path))?;
            let k = run.basic.sensors[at].sensitivity;
            Ok(derivatives[0].readings.iter().map(|derivative| k * derivative[at]).collect())
        });
        let column = column.collect::<Result<_>>()?;
        Ok(Self { name: kind.name(), parameter: kind.parameters()[parameter].name, column })
    }
}

/// The noise that the residuals call for; the sensor's known noise alone where that explains them.
pub fn noise_called_for(problem: &Problem<'_, '_>, candidates: &[Candidate]) -> Result<Allowed> {
    let Some(own) = problem.allowed.own() else { return Ok(problem.allowed.clone()) };
    let fit = Problem { allowed: &own, ..problem.clone() }.solve()?;
    let mut wide = fit.design.clone();
    for candidate in candidates {
        let column = used(problem.runs, &candidate.column);
        if visible_share(&wide, &column) > VISIBLE {
            wide = beside(&wide, &column);
        }
    }
    let left = correlated::fit(wide.as_ref(), &fit.linear.residuals, &own.whitenings, Scale::Fitted)?;
    let squares = left.variance_factor * left.freedom;
    let explained = left.freedom < 1.0 || stats::chi_squared_p(squares, left.freedom) >= EXPLAINED;
    Ok(if explained { own } else { problem.allowed.clone() })
}

pub fn beside(design: &Mat<f64>, column: &[f64]) -> Mat<f64> {
    let (rows, columns) = (design.nrows(), design.ncols());
    Mat::from_fn(rows, columns + 1, |i, j| if j < columns { design[(i, j)] } else { column[i] })
}

pub struct Extended {
    /// The fit; the departures that were found are its last unknowns.
    pub fit: Fit,
    pub departures: Vec<Departure>,
    /// Names of those that were found, in the order of their unknowns.
    pub found: Vec<&'static str>,
    /// Those that explain the readings about as well as the first.
    pub rivals: Vec<String>,
}

/// Fits, looks for each candidate beside the fit, takes the most significant one in, and looks again.
///
/// A candidate: one more column beside the derivatives at the minimum, under the likely covariances.
pub fn extend(problem: &Problem<'_, '_>, candidates: &[Candidate]) -> Result<Extended> {
    let mut fit = problem.solve()?;
    let all = candidates.iter().map(|candidate| (candidate, used(problem.runs, &candidate.column)));
    let visible: Vec<(&Candidate, Vec<f64>)> =
        all.filter(|(_, column)| visible_share(&fit.design, column) > VISIBLE).collect();
    let count = visible.len() as f64;
    let mut extended: Vec<Unknown> = problem.unknowns.clone();
    let (mut departures, mut found, mut rivals) = (Vec::new(), Vec::<&'static str>::new(), Vec::new());
    for round in 0..=MOST {
        let mut trials: Vec<(&Candidate, f64, f64)> = Vec::new();
        let allowed = problem.allowed.weighty(&fit.linear);
        for (candidate, column) in visible.iter().filter(|(candidate, _)| !found.contains(&candidate.name)) {
            let Some((parameter, p_value)) = beside_fit(&fit, &allowed, column)? else { continue };
            // The fall of χ², in units of the variance beside it.
            let gain = (parameter.value() / parameter.std().unwrap_or(f64::NAN)).powi(2);
            if round == 0 {
                departures.push(Departure {
                    departure: candidate.name.into(),
                    parameter: [(candidate.parameter.to_string(), parameter)].into_iter().collect(),
                    p_value,
                    p_adjusted: (p_value * count).min(1.0),
                    found: false,
                });
            }
            trials.push((candidate, p_value, gain));
        }
        trials.retain(|(_, p, _)| p * count < FOUND_BELOW);
        trials.sort_by(|a, b| b.2.total_cmp(&a.2));
        if round == MOST || trials.is_empty() {
            break;
        }
        let (best, _, gain) = trials.remove(0);
        if round == 0 {
            let near = trials.iter().filter(|(.., other)| gain - other < RIVAL_WITHIN);
            rivals = near.map(|(candidate, ..)| candidate.name.to_string()).collect();
        }
        found.push(best.name);
        extended.push(Unknown::Column(best.column.clone()));
        fit = problem.with(extended.clone()).solve()?;
    }
    for departure in &mut departures {
        departure.found = found.contains(&departure.departure.as_str());
    }
    Ok(Extended { fit, departures, found, rivals })
}

/// The size of a column beside a fit, and the probability that it is zero; None where it is not seen.
fn beside_fit(fit: &Fit, allowed: &Allowed, column: &[f64]) -> Result<Option<(Quantity, f64)>> {
    let (rows, unknowns) = (fit.design.nrows(), fit.design.ncols());
    if rows <= unknowns + 1 {
        return Ok(None);
    }
    let wider = beside(&fit.design, column);
    let tried = correlated::fit(wider.as_ref(), &fit.linear.residuals, &allowed.whitenings, Scale::Fitted)?;
    if tried.freedom < 1.0 || tried.rank <= unknowns {
        return Ok(None);
    }
    let std = tried.covariance(unknowns, unknowns).sqrt();
    let size = Quantity::new(tried.coefficients[unknowns], std);
    Ok(Some((size, tried.mixture.p_value(&[unknowns])?)))
}

/// A series over the used rows of all runs.
pub fn used(runs: &[Run<'_>], series: &[Vec<f64>]) -> Vec<f64> {
    let of = runs.iter().zip(series);
    of.flat_map(|(run, series)| {
        run.rows.iter().map(|row| series.get(*row).copied().unwrap_or(0.0)).collect::<Vec<_>>()
    })
    .collect()
}

/// The share of a column that is left beside the columns of a design.
pub fn visible_share(design: &Mat<f64>, column: &[f64]) -> f64 {
    let size: f64 = column.iter().map(|c| c * c).sum();
    let left = linear::fit(design.as_ref(), column, None).map_or(0.0, |fit| fit.sum_of_squares);
    if size > 0.0 { (left / size).sqrt() } else { 0.0 }
}
