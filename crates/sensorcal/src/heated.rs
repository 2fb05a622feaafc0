//! Runs at several temperatures: whose temperature moved in them, and whether k and O follow it late.

use common::number::{bare, significant, uncertain};
use common::uncertainty::Block;
use common::{Axis, Code, Findings};
use estimate::stats;
use faer::Mat;
use physics::{EffectInstance, Kind, Parameter, Thermometer};

use crate::adopt;
use crate::conditions::Conditions;
use crate::departure::{FOUND_BELOW, beside, visible_share};
use crate::fit::{Fit, Problem, Unknown};
use crate::readings::{Run, span};
use crate::{Error, Result};

/// A temperature that moves by less than this in a recording is held, K.
const MOVED_K: f64 = 0.5;
/// Share of a temperature's changes that the other one's must leave.
const APART: f64 = 0.1;
const TRIED_S: [f64; 13] =
    [10.0, 20.0, 40.0, 70.0, 120.0, 200.0, 350.0, 600.0, 1000.0, 1800.0, 3200.0, 5600.0, 10_000.0];
/// The way from one temperature to another was recorded when no step is a larger share of it.
const PATH: f64 = 0.1;
const UNSEEN: &str = "the transitions between temperatures were not recorded: a lag is not observable";
/// χ² by which a lag is excluded at 95 %.
const EXCLUDED: f64 = 3.84;

/// How the temperatures of sensor and electronics act on sensitivity and offset, at once and with a lag.
pub const KINDS: [[[Kind; 2]; 2]; 2] = [
    [
        [Kind::SensitivityTemperature, Kind::SensitivityTemperatureLag],
        [Kind::OffsetTemperature, Kind::OffsetTemperatureLag],
    ],
    [
        [Kind::SensitivityElectronicsTemperature, Kind::SensitivityElectronicsTemperatureLag],
        [Kind::OffsetElectronicsTemperature, Kind::OffsetElectronicsTemperatureLag],
    ],
];

/// The runs with the temperatures of each, and which moved.
pub struct Heated<'a> {
    pub runs: Vec<Run<'a>>,
    /// Temperature less reference of sensor and electronics for each run, K, by row.
    pub warmer: Vec<[Vec<f64>; 2]>,
    /// Which parts, by their places in [`KINDS`], moved and can be told apart.
    pub parts: Vec<usize>,
}

impl<'a> Heated<'a> {
    pub fn of(runs: Vec<Run<'a>>, findings: &mut Findings) -> Result<Self> {
        let warmer = |run: &Run<'_>, thermometer: Thermometer| -> Result<Vec<f64>> {
            let found = run.context.temperature(thermometer, "a `temperature_run`");
            let (column, reference) = found.map_err(|error| error.at(&format!("{}.columns", run.path)))?;
            Ok(column.iter().map(|t| t - reference).collect())
        };
        let both = |run| Ok([warmer(run, Thermometer::Sensor)?, warmer(run, Thermometer::Electronics)?]);
        let warmer = runs.iter().map(both).collect::<Result<Vec<[Vec<f64>; 2]>>>()?;
        let parts = parts(&runs, &warmer, findings)?;
        Ok(Self { runs, warmer, parts })
    }
}

/// Which temperatures moved, and whether they can be told apart.
fn parts(runs: &[Run<'_>], warmer: &[[Vec<f64>; 2]], findings: &mut Findings) -> Result<Vec<usize>> {
    let moved = |at: &usize| {
        runs.iter().zip(warmer).any(|(run, both)| span(run.rows.iter().map(|row| both[*at][*row])) > MOVED_K)
    };
    let parts: Vec<usize> = (0..2).filter(moved).collect();
    if parts.is_empty() {
        return Err(Error::Unanswerable(format!(
            "sensor {}: neither temperature varies by more than {MOVED_K} K in any `temperature_run`; a coefficient needs at least two temperatures, a curvature three",
            runs[0].sensor
        )));
    }
    if parts.len() == 2 {
        // Each temperature against the other, both about their mean in each run.
        let rows: usize = runs.iter().map(|run| run.rows.len()).sum();
        let column = |at: usize| -> Vec<f64> {
            let each = runs.iter().zip(warmer);
            each.flat_map(|(run, both)| run.rows.iter().map(|row| both[at][*row]).collect::<Vec<_>>())
                .collect()
        };
        let columns = [column(0), column(1)];
        let number: Vec<usize> =
            runs.iter().enumerate().flat_map(|(number, run)| vec![number; run.rows.len()]).collect();
        let share = |of: usize, other: usize| {
            let means = Mat::from_fn(rows, runs.len(), |i, j| f64::from(u8::from(number[i] == j)));
            let with = beside(&means, &columns[other]);
            visible_share(&with, &columns[of]) / visible_share(&means, &columns[of])
        };
        let apart = share(0, 1).min(share(1, 0));
        if apart < APART {
            findings.push(Code::TemperaturesInseparable.said(format!(
                "the temperatures of sensor and electronics varied together (only {} % of the variance is independent), so no slope is assigned to either; heat one and hold the other constant",
                significant(100.0 * apart, 2)
            )));
            return Ok(Vec::new());
        }
    }
    Ok(parts)
}

/// Number of temperatures, a kelvin apart: in all readings, or in those with at least half the largest drive.
pub fn distinct(heated: &Heated<'_>, part: usize, driven: bool) -> usize {
    let of_run = |(run, both): (&Run<'_>, &[Vec<f64>; 2])| {
        let drive = |row: usize| run.context.current_a[row][run.coil.index()].abs();
        let largest = run.rows.iter().map(|row| drive(*row)).fold(0.0, f64::max);
        let rows = run.rows.iter().filter(|row| !driven || drive(**row) >= 0.5 * largest);
        rows.map(|row| both[part][*row]).collect::<Vec<_>>()
    };
    let mut all: Vec<f64> = heated.runs.iter().zip(&heated.warmer).flat_map(of_run).collect();
    all.sort_by(f64::total_cmp);
    let (mut levels, mut begin) = (1, all.first().copied().unwrap_or(0.0));
    for temperature in all {
        if temperature - begin > 1.0 {
            (levels, begin) = (levels + 1, temperature);
        }
    }
    levels
}

/// The fit's problem, with a lag where the readings show one.
pub struct Lagged<'p, 'b> {
    pub problem: Problem<'p, 'b>,
    /// What the readings say about a lag of sensor and electronics.
    pub words: [String; 2],
}

/// Tries lags for each part that moved, for sensitivity and offset.
pub fn look<'p, 'b>(problem: &Problem<'p, 'b>, heated: &Heated<'_>, sensor: Axis) -> Result<Lagged<'p, 'b>> {
    let mut lagged = Lagged { problem: problem.clone(), words: Default::default() };
    let (seen, unseen): (Vec<usize>, Vec<usize>) =
        heated.parts.iter().partition(|part| path_recorded(heated, **part));
    unseen.into_iter().for_each(|part| lagged.words[part] = UNSEEN.into());
    if seen.is_empty() {
        return Ok(lagged);
    }
    // Sums of squares are compared under one covariance.
    let single = problem.allowed.likeliest(&problem.solve()?.linear);
    for part in seen {
        let mut words = Vec::new();
        for (kinds, name) in KINDS[part].into_iter().zip(["sensitivity", "offset"]) {
            let alone = Problem { allowed: &single, ..lagged.problem.clone() };
            let (text, with) = one(&alone, kinds, sensor, name, 2.0 * heated.parts.len() as f64)?;
            words.push(text);
            if let Some(Problem { effects, unknowns, .. }) = with {
                (lagged.problem.effects, lagged.problem.unknowns) = (effects, unknowns);
            }
        }
        lagged.words[part] = words.join("; ");
    }
    Ok(lagged)
}

/// Whether times are known and the temperature is followed on its way.
fn path_recorded(heated: &Heated<'_>, part: usize) -> bool {
    heated.runs.iter().zip(&heated.warmer).all(|(run, both)| {
        let warmer = &both[part];
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
) -> Result<(String, Option<Problem<'p, 'b>>)> {
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
