//! Whether k and O follow a temperature late.

use common::Axis;
use common::number::{bare, significant, uncertain};
use common::uncertainty::Block;
use estimate::stats;
use faer::Mat;
use physics::{EffectInstance, Kind, Parameter};

use crate::Error;
use crate::adopt;
use crate::conditions::Conditions;
use crate::departure::FOUND_BELOW;
use crate::fit::{Fit, Problem, Unknown};
use crate::heated::{Heated, Part};
use crate::readings::span;

/// Lags that are tried, s.
const TRIED_S: [f64; 13] =
    [10.0, 20.0, 40.0, 70.0, 120.0, 200.0, 350.0, 600.0, 1000.0, 1800.0, 3200.0, 5600.0, 10_000.0];
/// The way from one temperature to another was recorded when no step is a larger share of it.
const PATH: f64 = 0.1;
/// What is said where that is not so.
const UNSEEN: &str = "the transitions between temperatures were not recorded: a lag is not observable";
/// χ² by which a lag is excluded at 95 %.
const EXCLUDED: f64 = 3.84;

/// The fit's problem, with a lag where the readings show one.
pub struct Lagged<'p, 'b> {
    pub problem: Problem<'p, 'b>,
    /// What the readings say about a lag of sensor and electronics.
    pub words: [String; 2],
}

/// Tries lags for each part that moved, for sensitivity and offset.
pub fn look<'p, 'b>(
    problem: &Problem<'p, 'b>,
    heated: &Heated<'_>,
    sensor: Axis,
) -> Result<Lagged<'p, 'b>, Error> {
    let mut lagged = Lagged { problem: problem.clone(), words: Default::default() };
    let (seen, unseen): (Vec<Part>, Vec<Part>) =
        heated.parts.iter().partition(|part| path_recorded(heated, **part));
    unseen.into_iter().for_each(|part| lagged.words[part as usize] = UNSEEN.into());
    if seen.is_empty() {
        return Ok(lagged);
    }
    // Sums of squares are compared under one covariance.
    let single = problem.allowed.likeliest(&problem.solve()?.linear);
    for part in seen {
        let mut words = Vec::new();
        for (kinds, name) in part.kinds().into_iter().zip(["sensitivity", "offset"]) {
            let alone = Problem { allowed: &single, ..lagged.problem.clone() };
            let (text, with) = one(&alone, kinds, sensor, name, 2.0 * heated.parts.len() as f64)?;
            words.push(text);
            if let Some(Problem { effects, unknowns, .. }) = with {
                (lagged.problem.effects, lagged.problem.unknowns) = (effects, unknowns);
            }
        }
        lagged.words[part as usize] = words.join("; ");
    }
    Ok(lagged)
}

/// Whether times are known and the temperature is followed on its way.
fn path_recorded(heated: &Heated<'_>, part: Part) -> bool {
    heated.runs.iter().zip(&heated.warmer).all(|(run, both)| {
        let warmer = &both[part as usize];
        let step = warmer.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        run.context.times("").is_ok() && step <= PATH * span(warmer.iter().copied()).max(2.0)
    })
}

/// One quantity of one part: what is to be said, and the problem with its lag where there is one.
fn one<'p, 'b>(
    problem: &Problem<'p, 'b>,
    kinds: [Kind; 2],
    sensor: Axis,
    name: &str,
    tries: f64,
) -> Result<(String, Option<Problem<'p, 'b>>), Error> {
    let without = problem.solve()?;
    let mut best: Option<(f64, f64)> = None;
    let mut allowed = 0.0;
    let variance = without.linear.variance_factor;
    for lag_s in TRIED_S {
        let Some(trial) = with_lag(problem, kinds, sensor, lag_s, false) else { break };
        let squares = trial.solve()?.sum_of_squares();
        if best.is_none_or(|(least, _)| squares < least) {
            best = Some((squares, lag_s));
        }
        if squares - without.sum_of_squares() < EXCLUDED * variance {
            allowed = lag_s;
        }
    }
    let Some((_, lag_s)) = best else { return Ok((format!("{name}: no search for a lag"), None)) };
    if let Some(trial) = with_lag(problem, kinds, sensor, lag_s, true)
        && let Ok(fit) = trial.solve()
    {
        let gain = (without.sum_of_squares() - fit.sum_of_squares()) / fit.linear.variance_factor;
        // One more parameter, found by a search.
        if gain > 0.0 && tries * stats::chi_squared_p(gain, 2.0) < FOUND_BELOW {
            let place = trial.place(kinds[1], 1);
            let lag = place.map_or((lag_s, f64::NAN), |at| (fit.values[at], fit.type_a(at)));
            let (lag, gain) = (uncertain(lag.0, lag.1), significant(gain, 3));
            let text = format!("{name} follows {lag} s late (χ² decreases by {gain})");
            return Ok((text, Some(trial)));
        }
    }
    let text = if allowed >= TRIED_S[TRIED_S.len() - 1] {
        format!("{name}: these readings do not constrain a lag")
    } else {
        format!("{name}: no lag was detected; more than {} s is excluded", bare(allowed))
    };
    Ok((text, None))
}

/// The problem with the linear coefficient behind a lag, which may be free.
fn with_lag<'p, 'b>(
    problem: &Problem<'p, 'b>,
    kinds: [Kind; 2],
    sensor: Axis,
    lag_s: f64,
    free: bool,
) -> Option<Problem<'p, 'b>> {
    let at = problem.place(kinds[0], 0)?;
    let mut with = problem.clone();
    let runs: Vec<usize> = (0..problem.runs.len()).collect();
    let number = with.effects.len();
    with.effects.push(EffectInstance::new(kinds[1], Some(sensor), vec![0.0, lag_s]));
    with.unknowns[at] = Unknown::Chain(Parameter::Effect(number, 0), runs.clone());
    if free {
        // The derivative by the lag vanishes with the coefficient: begin with what the fixed lag gives.
        let fixed = with.solve().ok()?;
        with.effects[number].parameters[0] = fixed.values[at];
        with.unknowns.insert(at + 1, Unknown::Chain(Parameter::Effect(number, 1), runs));
    }
    Some(with)
}

/// The effects as they were fitted, and `effect.parameter` for every parameter of theirs.
pub fn conditions(problem: &Problem<'_, '_>, fit: &Fit, sensor: Axis) -> (Conditions, Vec<String>) {
    let mut effects = problem.effects.clone();
    let (mut places, mut paths, mut order) = (Vec::new(), Vec::new(), Vec::new());
    for effect in &mut effects {
        for (number, info) in effect.kind.parameters().iter().enumerate() {
            let place = problem.place(effect.kind, number);
            effect.parameters[number] = place.map_or(0.0, |place| fit.values[place]);
            places.push(place);
            paths.push(adopt::path(effect.kind, sensor, info.name));
            order.push(format!("{}.{}", effect.kind.name(), info.name));
        }
    }
    let covariance = Mat::from_fn(places.len(), places.len(), |a, b| {
        places[a].zip(places[b]).map_or(0.0, |(a, b)| fit.covariance(a, b))
    });
    let (fitted, parameters): (Vec<usize>, Vec<String>) =
        places.iter().zip(&paths).filter_map(|(place, path)| Some(((*place)?, path.clone()))).unzip();
    let block = Block {
        name: format!("sensor {sensor}: scatter of the temperature runs"),
        degrees_of_freedom: fit.noise.degrees_of_freedom,
        parameters,
        covariance: fit.scatter_of(&fitted),
        by: fit.by(&fitted),
    };
    (Conditions { effects, covariance, paths, block: Some(block) }, order)
}
