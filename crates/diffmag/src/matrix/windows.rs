//! Whether η holds still in time: windows of equal length, each with its own level and straight drift.

mod quiet;
mod stretch;
mod words;

pub use quiet::quiet_disturbed;
pub use stretch::Noise;
pub use words::{findings, quiet_findings};

use std::ops::Range;

use common::{Axis, ElementChange, MatrixWindow, MatrixWindows, Quantity};
use estimate::stats::{self, mean};
use faer::Mat;

use crate::Error;
use crate::constancy::{self, Estimate, Fitted};
use crate::regression::AxisFit;
use joined::{DAY_S, Pair};
use paired::residual::centred;
use stretch::whole;

const WINDOWS: (usize, usize) = (4, 12);
const LEAST: usize = 120;

/// Rows of the windows, at least 4 and at most 12 of at least 120 samples each: whole days where there are
/// four, so that what comes and goes by day is in all alike; the last one longer by what is left. Windows
/// that lack more than half of their samples are left out. None of a recording that is too short.
pub fn divide(pair: &Pair) -> Option<Vec<Range<usize>>> {
    let rows = pair.whole.len();
    let days = rows as f64 * pair.step_s / DAY_S;
    let each =
        if days < WINDOWS.0 as f64 { days / WINDOWS.0 as f64 } else { (days / WINDOWS.1 as f64).ceil() };
    let samples = ((each * DAY_S / pair.step_s) as usize).max(LEAST);
    let count = rows / samples;
    let end = |i: usize| if i + 1 == count { rows } else { (i + 1) * samples };
    let windows: Vec<Range<usize>> =
        (0..count).map(|i| i * samples..end(i)).filter(|rows| 2 * whole(pair, rows) > rows.len()).collect();
    (windows.len() >= WINDOWS.0).then_some(windows)
}

/// η and offset in each window, and whether they are one.
pub fn windows(
    pair: &Pair,
    fits: &[AxisFit; 3],
    noise: &Noise<'_>,
    rows: &[Range<usize>],
) -> Result<MatrixWindows, Error> {
    let middle = 0.5 * (pair.whole.len() as f64 - 1.0);
    let days =
        |rows: &Range<usize>| (0.5 * (rows.start + rows.end - 1) as f64 - middle) * pair.step_s / DAY_S;
    let mut found = MatrixWindows::default();
    let mut columns = Vec::with_capacity(3);
    let (mut same, mut still, mut changes) = (Vec::new(), Vec::new(), Vec::new());
    for axis in Axis::ALL {
        let density = |f: f64| noise.weighing(axis.index(), f);
        let estimates = rows.iter().map(|rows| stretch::estimate(pair, fits, &density, axis, rows));
        let estimates = estimates.collect::<Result<Vec<Estimate>, Error>>()?;
        let one = constancy::fit(&estimates, 3, |_| Mat::identity(3, 3))?;
        let line = constancy::fit(&estimates, 6, |i| {
            Mat::from_fn(3, 6, |k, l| match l {
                _ if l % 3 != k => 0.0,
                0..3 => 1.0,
                _ => days(&rows[i]),
            })
        })?;
        for i in 0..3 {
            found.trend_per_day[i][axis.index()] = line.unknowns[3 + i];
            found.trend_std_per_day[i][axis.index()] = line.covariance[(3 + i, 3 + i)].sqrt();
        }
        changes.extend(largest_change(axis, &estimates, &one));
        same.push(one.chi_squared(0.0));
        still.push(line.without(3)?);
        columns.push(estimates);
    }
    found.one_matrix = constancy::together([same[0], same[1], same[2]], &noise.correlation_squared);
    found.no_trend = constancy::together([still[0], still[1], still[2]], &noise.correlation_squared);
    let offsets = fits.each_ref().map(|fit| offset_std(pair, fit, rows));
    for (number, rows) in rows.iter().enumerate() {
        let mut window = MatrixWindow {
            from_s: pair.time_s(rows.start),
            to_s: pair.time_s(rows.end - 1),
            samples: whole(pair, rows),
            estimate: stretch::documented(std::array::from_fn(|j| &columns[j][number])),
            ..MatrixWindow::default()
        };
        for axis in Axis::ALL {
            let j = axis.index();
            *window.variation_nt.entry(axis) = Some(stats::rms(&centred(&pair.reference[j][rows.clone()])));
            let value = offset_change(pair, &fits[j], j, rows);
            *window.offset_change_nt.entry(axis) = Some(Quantity::new(value, offsets[j]));
        }
        found.windows.push(window);
    }
    let tried = (9 * (rows.len() - 1)) as f64;
    let largest = changes.into_iter().max_by(|a, b| a.significance.total_cmp(&b.significance));
    if let Some(Change { element, after, change_ppm, significance }) = largest {
        let p = (tried * stats::two_sided_p(significance, f64::INFINITY)).min(1.0);
        let at_s = pair.time_s(rows[after].start);
        found.largest_change = ElementChange { element, at_s, change_ppm, p };
    }
    Ok(found)
}

/// One element before and after one of the windows' borders.
struct Change {
    element: String,
    after: usize,
    change_ppm: Quantity,
    significance: f64,
}

/// The change of an element that stands out most: weighted means after less before, what noise of the
/// reference does taken off.
fn largest_change(axis: Axis, estimates: &[Estimate], one: &Fitted) -> Option<Change> {
    let mean = |part: &[Estimate], i: usize| {
        let (mut weight, mut sum) = (0.0, 0.0);
        for estimate in part {
            let w = 1.0 / estimate.covariance[(i, i)];
            weight += w;
            sum += w * (estimate.value[i] - one.share * estimate.bias[i]);
        }
        (sum / weight, 1.0 / weight)
    };
    let all = (1..estimates.len()).flat_map(|after| Axis::ALL.into_iter().map(move |from| (after, from)));
    let changes = all.map(|(after, from)| {
        let (before, later) = estimates.split_at(after);
        let ((a, variance_a), (b, variance_b)) = (mean(before, from.index()), mean(later, from.index()));
        let std = (variance_a + variance_b).sqrt();
        Change {
            element: format!("{from}{axis}"),
            after,
            change_ppm: Quantity::new(1e6 * (b - a), 1e6 * std),
            significance: ((b - a) / std).abs(),
        }
    });
    changes.max_by(|a, b| a.significance.total_cmp(&b.significance))
}

/// Mean of T − R η in some rows less that in all.
fn offset_change(pair: &Pair, fit: &AxisFit, j: usize, rows: &Range<usize>) -> f64 {
    let change = |column: &[f64]| mean(&column[rows.clone()]) - mean(column);
    let explained: f64 = (0..3).map(|i| fit.fit.weighted[i] * change(&pair.reference[i])).sum();
    change(&pair.test[j]) - explained
}

/// Its standard uncertainty under the noise of the whole: √ Σ P(f_k)/(n Δt) sinc²(k m/n), m the samples of
/// the first window.
fn offset_std(pair: &Pair, fit: &AxisFit, rows: &[Range<usize>]) -> f64 {
    let length_s = pair.whole.len() as f64 * pair.step_s;
    let term = |k: usize| {
        let angle = std::f64::consts::PI * k as f64 * rows[0].len() as f64 / pair.whole.len() as f64;
        fit.noise.level(k as f64 / length_s) / length_s * (angle.sin() / angle).powi(2)
    };
    (1..=pair.whole.len() / 2).map(term).sum::<f64>().sqrt()
}
