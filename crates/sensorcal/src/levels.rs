//! k and O at each temperature or field across that was held, and their slopes as the report takes them.

use common::{Quantity, TemperatureLevels};
use faer::Mat;
use indexmap::IndexMap;
use physics::FULL_NT;
use std::collections::HashSet;

use crate::Result;
use crate::departure::noise_called_for;
use crate::fit::{self, Fit, Problem, Unknown};
use crate::heated::Heated;
use crate::readings::{Run, along, span};
use crate::shape::{Place, Shape};

/// Temperatures within this of each other are one level, K.
const SAME_K: f64 = 0.5;
/// Different fields along the sensor from which its polynomial can be fitted.
const POLYNOMIAL_FROM: usize = 6;

/// The quadratic and cubic terms of a sensor, one for all runs; none where there are too few fields.
pub fn polynomial(runs: &[Run<'_>]) -> Vec<Unknown> {
    let fields = |run: &Run<'_>| {
        let along = along(run);
        let mut fields: Vec<f64> = run.rows.iter().map(|row| along[*row]).collect();
        fields.sort_by(f64::total_cmp);
        let least = 1e-3 * span(fields.iter().copied());
        1 + fields.windows(2).filter(|pair| pair[1] - pair[0] > least).count()
    };
    if !runs.iter().all(|run| fields(run) >= POLYNOMIAL_FROM) {
        return Vec::new();
    }
    let power =
        |n: i32| runs.iter().map(|run| along(run).iter().map(|b| (b / FULL_NT).powi(n)).collect()).collect();
    vec![Unknown::Column(power(2)), Unknown::Column(power(3))]
}

/// Temperatures that were held in one run while the field went through its steps.
pub struct Level {
    pub run: usize,
    /// Mean of sensor and electronics temperature less their references, K.
    pub warmer: [f64; 2],
}

/// +½ after warming, −½ after cooling, 0 before either, by row.
pub fn branches(warmer: &[f64]) -> Vec<f64> {
    let mut way = 0.0;
    let mut held = warmer.first().copied().unwrap_or(0.0);
    warmer
        .iter()
        .map(|t| {
            if (t - held).abs() > SAME_K {
                way = if *t > held { 0.5 } else { -0.5 };
                held = *t;
            }
            way
        })
        .collect()
}

/// The temperatures that were held, the fit of k and O at each, and both as columns.
pub fn at_temperatures(heated: &Heated<'_>, shape: &Shape) -> Result<(Vec<Level>, Fit, TemperatureLevels)> {
    let (mut levels, mut groups) = (Vec::new(), Vec::new());
    let mut columns = TemperatureLevels::default();
    for (number, (run, both)) in heated.runs.iter().zip(&heated.warmer).enumerate() {
        let spread = |values: &[f64]| span(run.rows.iter().map(|row| values[*row]));
        let moving = usize::from(spread(&both[1]) > spread(&both[0]));
        let branch = branches(&both[moving]);
        let mut held: Vec<Vec<usize>> = Vec::new();
        for row in &run.rows {
            match held.last_mut() {
                Some(rows) if (0..2).all(|at| (both[at][*row] - both[at][rows[0]]).abs() <= SAME_K) => {
                    rows.push(*row);
                }
                _ => held.push(vec![*row]),
            }
        }
        let field = along(run);
        let largest = run.rows.iter().map(|row| field[*row].abs()).fold(0.0, f64::max);
        let references = run.context.references;
        for rows in held {
            // A level has the field on both sides; readings while it settles have none.
            if rows.len() < 3 || span(rows.iter().map(|row| field[*row])) < largest {
                continue;
            }
            let mean = |at: usize| rows.iter().map(|row| both[at][*row]).sum::<f64>() / rows.len() as f64;
            let warmer = [mean(0), mean(1)];
            columns.recording.push(number);
            columns.sensor_temperature_c.push(references.sensor_c.unwrap_or(0.0) + warmer[0]);
            columns.electronics_temperature_c.push(references.electronics_c.unwrap_or(0.0) + warmer[1]);
            columns.branch.push((2.0 * branch[rows[0]]) as i8);
            levels.push(Level { run: number, warmer });
            groups.push((number, rows));
        }
    }
    let (constants, fit) = constants(&heated.runs, &groups, shape)?;
    for (k, offset) in constants {
        columns.sensitivity.push(k.0);
        columns.sensitivity_std.push(k.1);
        columns.offset_nt.push(offset.0);
        columns.offset_std_nt.push(offset.1);
    }
    Ok((levels, fit, columns))
}

/// k and O, each with its standard uncertainty.
type Constants = ((f64, f64), (f64, f64));

/// A line for each group of rows: the field along the sensor, and one.
pub fn lines(runs: &[Run<'_>], groups: &[(usize, Vec<usize>)]) -> Vec<Unknown> {
    let fields: Vec<Vec<f64>> = runs.iter().map(along).collect();
    let series = |(number, rows): &(usize, Vec<usize>), value: &dyn Fn(usize) -> f64| -> Unknown {
        let one = |at: usize| {
            let mut column = vec![0.0; runs[at].context.rows];
            if at == *number {
                rows.iter().for_each(|row| column[*row] = value(*row));
            }
            column
        };
        Unknown::Column((0..runs.len()).map(one).collect())
    };
    let both =
        |group: &(usize, Vec<usize>)| [series(group, &|row| fields[group.0][row]), series(group, &|_| 1.0)];
    groups.iter().flat_map(both).collect()
}

/// k and O of groups of rows, each with its own line, one polynomial and one noise for all.
pub fn constants(
    runs: &[Run<'_>],
    groups: &[(usize, Vec<usize>)],
    shape: &Shape,
) -> Result<(Vec<Constants>, Fit)> {
    let mut reduced: Vec<Run<'_>> = runs.to_vec();
    for (number, run) in reduced.iter_mut().enumerate() {
        let own = groups.iter().filter(|(of, _)| *of == number);
        let grouped: HashSet<usize> = own.flat_map(|(_, rows)| rows.iter().copied()).collect();
        run.rows.retain(|row| grouped.contains(row));
    }
    let mut unknowns = lines(runs, groups);
    unknowns.extend(polynomial(runs));
    let allowed = fit::noise(&reduced, shape, Place::Coils)?;
    let problem =
        Problem { runs: &reduced, effects: Vec::new(), unknowns, known: Vec::new(), allowed: &allowed };
    let allowed = noise_called_for(&problem, &[])?;
    let fit = Problem { allowed: &allowed, ..problem }.solve()?;
    let each =
        groups.iter().enumerate().map(|(at, (number, _))| constant(&fit, at, &runs[*number])).collect();
    Ok((each, fit))
}

/// From the column's coefficients, V = (B (1 + b) + a − O₀)/k₀: k = k₀/(1 + b), O = (O₀ − a)/(1 + b).
fn constant(fit: &Fit, at: usize, run: &Run<'_>) -> Constants {
    let first = &run.basic.sensors[run.sensor.index()];
    let (b, a) = (fit.values[2 * at], fit.values[2 * at + 1]);
    let (b_std, a_std) = (fit.type_a(2 * at), fit.type_a(2 * at + 1));
    let k = first.sensitivity / (1.0 + b);
    ((k, k * b_std / (1.0 + b)), ((first.offset_nt - a) / (1.0 + b), a_std))
}

/// The report's slopes: straight lines through the levels at the reference and at the nearest temperature on
/// either side of it, in the runs in which the part moved; ppm/K and nT/K of the field that is read.
pub fn three_point(levels: &[Level], fit: &Fit, at: usize) -> IndexMap<String, Quantity> {
    let moved = |run: usize| {
        let own = levels.iter().filter(|level| level.run == run);
        span(own.map(|level| level.warmer[at])) > SAME_K
    };
    let members: Vec<usize> = (0..levels.len()).filter(|number| moved(levels[*number].run)).collect();
    let nearest = |sign: f64| {
        let side = members.iter().map(|number| sign * levels[*number].warmer[at]).filter(|t| *t > SAME_K);
        side.fold(f64::INFINITY, f64::min)
    };
    let (below, above) = (-nearest(-1.0), nearest(1.0));
    if !below.is_finite() || !above.is_finite() {
        return IndexMap::new();
    }
    let near = |number: &usize| (below - SAME_K..=above + SAME_K).contains(&levels[*number].warmer[at]);
    let central: Vec<usize> = members.into_iter().filter(near).collect();
    let mut runs: Vec<usize> = central.iter().map(|number| levels[*number].run).collect();
    runs.dedup();
    // Each run has its own mean.
    let design = Mat::from_fn(central.len(), 1 + runs.len(), |i, j| match j {
        0 => levels[central[i]].warmer[at],
        j => f64::from(u8::from(runs[j - 1] == levels[central[i]].run)),
    });
    // The slope is a sum over the levels, whose errors go together.
    let weight = |i: usize| -> Option<f64> {
        let unit: Vec<f64> = (0..central.len()).map(|j| f64::from(u8::from(i == j))).collect();
        Some(estimate::linear::fit(design.as_ref(), &unit, None).ok()?.coefficients[0])
    };
    let Some(weights) = (0..central.len()).map(weight).collect::<Option<Vec<f64>>>() else {
        return IndexMap::new();
    };
    let slope = |which: usize, unit: f64| {
        let place = |i: usize| 2 * central[i] + which;
        let value: f64 = (0..central.len()).map(|i| weights[i] * fit.values[place(i)]).sum();
        let row = |i: usize| -> f64 {
            (0..central.len()).map(|j| weights[i] * weights[j] * fit.scatter(place(i), place(j))).sum()
        };
        let variance: f64 = (0..central.len()).map(row).sum();
        Quantity::new(unit * value, unit * variance.sqrt())
    };
    [("sensitivity_ppm_per_k".to_string(), slope(0, 1e6)), ("offset_nt_per_k".to_string(), slope(1, 1.0))]
        .into_iter()
        .collect()
}
