//! Whether k and O follow a temperature late.

use common::Axis;
use common::number::{bare, significant, uncertain};
use common::uncertainty::{self, Block};
use estimate::stats;
use faer::Mat;
use physics::{EffectInstance, Kind, Parameter};

use crate::Error;
use crate::adopt;
use crate::conditions::Conditions;
use crate::departure::FOUND_BELOW;
use crate::fit::{Fit, Problem, Unknown};
use crate::heated::{Heated, Part};

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
    /// It.
    pub problem: Problem<'p, 'b>,
    words: Vec<(Part, String)>,
}

/// Tries lags for each part that moved, for sensitivity and offset.
pub fn look<'p, 'b>(
    problem: &Problem<'p, 'b>,
    heated: &Heated<'_>,
    sensor: Axis,
) -> Result<Lagged<'p, 'b>, Error> {
    let mut lagged = Lagged { problem: problem.with(problem.unknowns.clone()), words: Vec::new() };
    if !heated.parts.iter().any(|part| path_recorded(heated, *part)) {
        lagged.words = heated.parts.iter().map(|part| (*part, UNSEEN.into())).collect();
        return Ok(lagged);
    }
    // Sums of squares are compared under one covariance.
    let single = problem.allowed.likeliest(&problem.solve()?.linear);
    for part in &heated.parts {
        if !path_recorded(heated, *part) {
            lagged.words.push((*part, UNSEEN.into()));
            continue;
        }
        let mut words = Vec::new();
        for (kinds, name) in part.kinds().into_iter().zip(["sensitivity", "offset"]) {
            let alone = Problem { allowed: &single, ..lagged.problem.with(lagged.problem.unknowns.clone()) };
            let (text, with) = one(&alone, kinds, sensor, name, 2.0 * heated.parts.len() as f64)?;
            words.push(text);
            if let Some(Problem { effects, unknowns, .. }) = with {
                (lagged.problem.effects, lagged.problem.unknowns) = (effects, unknowns);
            }
        }
        lagged.words.push((*part, words.join("; ")));
    }
    Ok(lagged)
}

/// Whether times are known and the temperature is followed on its way.
fn path_recorded(heated: &Heated<'_>, part: Part) -> bool {
    let at = usize::from(part == Part::Electronics);
    heated.runs.iter().zip(&heated.warmer).all(|(run, both)| {
        let largest = both[at].iter().fold(f64::NEG_INFINITY, |m, t| m.max(*t));
        let range = largest - both[at].iter().fold(f64::INFINITY, |m, t| m.min(*t));
        let step = both[at].windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        run.context.times("").is_ok() && step <= PATH * range.max(2.0)
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
            let place = unknown(&trial, kinds[1], 1);
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
    let at = unknown(problem, kinds[0], 0)?;
    let mut with = problem.with(problem.unknowns.clone());
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

/// Which unknown a parameter of an effect is.
fn unknown(problem: &Problem<'_, '_>, kind: Kind, parameter: usize) -> Option<usize> {
    problem.unknowns.iter().position(|unknown| match unknown {
        Unknown::Chain(Parameter::Effect(effect, number), _) => {
            problem.effects[*effect].kind == kind && *number == parameter
        }
        _ => false,
    })
}

impl Lagged<'_, '_> {
    /// Which unknown a parameter of an effect is.
    pub fn index(&self, kind: Kind, parameter: usize) -> Option<usize> {
        unknown(&self.problem, kind, parameter)
    }

    /// Which unknown the linear coefficient is, of the effect at once or of the one with a lag.
    pub fn linear(&self, kinds: [Kind; 2]) -> Option<usize> {
        self.index(kinds[0], 0).or_else(|| self.index(kinds[1], 0))
    }

    /// What the readings say about a lag of a part.
    pub fn words(&self, part: Part) -> String {
        self.words.iter().filter(|(of, _)| *of == part).map(|(_, text)| text.as_str()).collect()
    }

    /// `effect.parameter` for every parameter of every effect.
    pub fn names(&self) -> Vec<String> {
        let effects = self.problem.effects.iter();
        effects
            .flat_map(|effect| {
                let infos = effect.kind.parameters().iter();
                infos.map(move |info| format!("{}.{}", effect.kind.name(), info.name))
            })
            .collect()
    }

    /// The effects as they were fitted.
    pub fn conditions(&self, fit: &Fit, sensor: Axis) -> Conditions {
        let places: Vec<Option<usize>> = self
            .problem
            .effects
            .iter()
            .enumerate()
            .flat_map(|(effect, instance)| {
                (0..instance.parameters.len()).map(move |number| Parameter::Effect(effect, number))
            })
            .map(|asked| {
                self.problem.unknowns.iter().position(
                    |unknown| matches!(unknown, Unknown::Chain(parameter, _) if *parameter == asked),
                )
            })
            .collect();
        let covariance = Mat::from_fn(places.len(), places.len(), |a, b| {
            places[a].zip(places[b]).map_or(0.0, |(a, b)| fit.covariance(a, b))
        });
        let mut values = places.iter();
        let effects = self.problem.effects.iter().map(|instance| {
            let mut effect = instance.clone();
            for value in &mut effect.parameters {
                let place = values.next().copied().flatten();
                *value = place.map_or(0.0, |place| fit.values[place]);
            }
            effect
        });
        let paths: Vec<String> = (self.problem.effects.iter())
            .flat_map(|instance| {
                let effect = adopt::one(instance.kind, sensor, Default::default());
                let infos = instance.kind.parameters().iter();
                infos.map(|info| uncertainty::effect(&effect, info.name)).collect::<Vec<_>>()
            })
            .collect();
        let fitted: Vec<usize> = places.iter().copied().flatten().collect();
        let block = Block {
            name: format!("sensor {sensor}: scatter of the temperature runs"),
            degrees_of_freedom: fit.noise.degrees_of_freedom,
            parameters: paths
                .iter()
                .zip(&places)
                .filter(|(_, place)| place.is_some())
                .map(|(path, _)| path.clone())
                .collect(),
            covariance: fit.scatter_of(&fitted),
            by: fit.by(&fitted),
        };
        Conditions { effects: effects.collect(), covariance, paths, block: Some(block) }
    }
}
