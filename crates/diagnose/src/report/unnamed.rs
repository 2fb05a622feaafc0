//! Structure that has no name: what it follows, and how, as points to plot.

use common::UnnamedStructure;
use nalgebra::Vector3;

use crate::Outcome;
use crate::covariates;
use crate::model::Model;
use crate::verdict::Unnamed;
use crate::waves::mean_step_s;

/// Points of a curve.
const POINTS: usize = 32;
/// Share of the energy that one of the two parts has where the other is said to be none.
const NEARLY_ALL: f64 = 0.9;

pub(super) fn unnamed(
    model: &Model<'_>,
    outcome: &Outcome,
    fields: &[Vec<Vector3<f64>>],
) -> Vec<UnnamedStructure> {
    let mut all: Vec<UnnamedStructure> =
        outcome.unnamed.iter().map(|structure| one(model, structure, fields)).collect();
    all.sort_by(|a, b| b.share.total_cmp(&a.share));
    all
}

fn one(model: &Model<'_>, structure: &Unnamed, fields: &[Vec<Vector3<f64>>]) -> UnnamedStructure {
    let Unnamed { covariate, axis, shape, values, share } = structure;
    let own = points(model, structure, |run| covariates::values(model, fields, run, Some(*axis), covariate));
    let (along, points) = match own {
        points if points.is_empty() => {
            let clock = |run: usize| model.observed.runs[run].on_clock();
            ("time_s".to_string(), self::points(model, structure, clock))
        }
        points => (covariate.clone(), points),
    };
    let step_s = model.observed.channels.iter().enumerate().find_map(|(number, channel)| {
        let time = model.observed.runs[channel.run].time_s.filter(|_| values.part(number).is_some())?;
        Some(mean_step_s(time))
    });
    // Of a column the shape is a threshold, of the past of one a number of rows.
    let is_column = along == *covariate;
    let (x, contribution_nt) = curve(&points).into_iter().unzip();
    UnnamedStructure {
        sensor: Some(*axis),
        follows: covariate.clone(),
        parity: parity(&points).filter(|_| covariates::is_field(covariate)).map(str::to_string),
        lag_s: shape.filter(|_| !is_column).zip(step_s).map(|(rows, step_s)| rows * step_s),
        threshold: shape.filter(|_| is_column),
        share: share.clamp(0.0, 1.0),
        along,
        x,
        contribution_nt,
    }
}

/// What the structure makes of each reading, by the value of something there, in its order.
fn points(model: &Model<'_>, structure: &Unnamed, of: impl Fn(usize) -> Option<Vec<f64>>) -> Vec<(f64, f64)> {
    let mut all: Vec<(f64, f64)> = Vec::new();
    for (number, channel) in model.observed.channels.iter().enumerate() {
        let Some((part, x)) = structure.values.part(number).zip(of(channel.run)) else { continue };
        all.extend(channel.rows.iter().map(|row| x[*row]).zip(part.iter().copied()));
    }
    all.retain(|(x, _)| x.is_finite());
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

/// Means of as many points each.
fn curve(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let size = points.len().div_ceil(POINTS).max(1);
    let mean = |some: &[(f64, f64)]| {
        let (x, y) = some.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
        (x / some.len() as f64, y / some.len() as f64)
    };
    points.chunks(size).map(mean).collect()
}

/// Whether a function is even or odd: by its means at like distances from zero, its level apart.
fn parity(points: &[(f64, f64)]) -> Option<&'static str> {
    let farthest = points.iter().fold(0.0, |most: f64, (x, _)| most.max(x.abs()));
    let mut sums = [[(0.0, 0usize); 2]; POINTS / 2];
    for (x, y) in points {
        let at = ((x.abs() / farthest * sums.len() as f64) as usize).min(sums.len() - 1);
        let (sum, count) = &mut sums[at][usize::from(*x < 0.0)];
        (*sum, *count) = (*sum + y, *count + 1);
    }
    let both = sums.iter().filter(|[right, left]| right.1 > 0 && left.1 > 0);
    let both: Vec<[f64; 2]> = both.map(|sides| sides.map(|(sum, count)| sum / count as f64)).collect();
    if both.len() < 3 {
        return None;
    }
    let even: Vec<f64> = both.iter().map(|[right, left]| 0.5 * (right + left)).collect();
    let level = even.iter().sum::<f64>() / even.len() as f64;
    let even: f64 = even.iter().map(|value| (value - level).powi(2)).sum();
    let odd: f64 = both.iter().map(|[right, left]| (0.5 * (right - left)).powi(2)).sum();
    match even / (even + odd) {
        share if share > NEARLY_ALL => Some("even"),
        share if share < 1.0 - NEARLY_ALL => Some("odd"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_are_even_and_cubes_odd() {
        let of = |f: fn(f64) -> f64| -> Vec<(f64, f64)> {
            (-200..=200).map(|k| f64::from(k) * 100.0).map(|x| (x, f(x / 2e4))).collect()
        };
        assert_eq!(parity(&of(|x| 3.0 + x * x)), Some("even"));
        assert_eq!(parity(&of(|x| 3.0 + x.powi(3))), Some("odd"));
        assert_eq!(parity(&of(|x| x.max(0.0))), None);
        assert_eq!(parity(&of(|x| x).into_iter().filter(|(x, _)| *x > 0.0).collect::<Vec<_>>()), None);
        let curve = curve(&of(|x| x));
        assert!(curve.len() <= POINTS && curve.iter().all(|(x, y)| (x / 2e4 - y).abs() < 1e-12));
    }
}
