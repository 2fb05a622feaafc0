//! The difference along what it may follow, as a few points for plots.

use common::{Axis, DifferenceAxis, DifferentialFit, ResidualSeries};
use estimate::grouped::{Grouped, grouped};

use crate::drift::exponential;
use crate::regression::AxisFit;
use explain::Covariate;
use joined::{DAY_S, Pair};
use paired::prepare::Prepared;
use paired::residual::beside;

const POINTS: usize = 120;

/// Along time, the field's rate of change, and each housekeeping column.
pub fn series(
    covariates: &[Covariate],
    raw: &Pair,
    prepared: &Prepared,
    fits: &[AxisFit; 3],
    fit: &DifferentialFit,
) -> Vec<ResidualSeries> {
    let rows = raw.whole.len();
    let time = raw.times_s();
    let mut all = Vec::new();
    for (axis, found) in Axis::ALL.into_iter().zip(fits) {
        let (j, left) = (axis.index(), &found.difference);
        let whole = |values: &[f64]| -> Vec<f64> {
            let whole = raw.whole.iter().zip(&prepared.pair.whole).map(|(a, b)| *a && *b);
            values.iter().zip(whole).map(|(value, whole)| if whole { *value } else { f64::NAN }).collect()
        };
        let mut add = |along: &str, x: &[f64], before: &[f64], after: &[f64], fitted: Option<&[f64]>| {
            let columns = [Some(before), Some(after), fitted];
            let columns: Vec<&[f64]> = columns.into_iter().flatten().collect();
            let Some(Grouped { x, columns, points }) = grouped(&whole(x), &columns, POINTS) else { return };
            let mut columns = columns.into_iter();
            let [before_nt, after_nt, fitted_nt] = [(); 3].map(|()| columns.next().unwrap_or_default());
            all.push(ResidualSeries {
                recording: None,
                column: format!("test_{axis}_nt"),
                along: along.into(),
                x,
                before_nt,
                after_nt,
                fitted_nt,
                readings: points,
                ..ResidualSeries::default()
            });
        };
        add("time_s", &time, &levels(raw, j), left, None);
        if let Some(clock) = &fit.clock {
            let rate = field_rate(raw, found);
            let late_s =
                |row: usize| clock.offset_s.value() + 1e-6 * clock.rate_ppm.value() * raw.since_middle_s(row);
            let of_clock: Vec<f64> = (0..rows).map(|row| -late_s(row) * rate[row]).collect();
            let and = |sign: f64| -> Vec<f64> {
                left.iter().zip(&of_clock).map(|(left, clock)| left + sign * clock).collect()
            };
            if clock.corrected {
                add("field_rate_nt_per_s", &rate, &and(1.0), left, Some(&of_clock));
            } else {
                add("field_rate_nt_per_s", &rate, left, &and(-1.0), Some(&of_clock));
            }
        }
        for one in covariates {
            match found.followed().into_iter().find(|(follows, _)| follows.name == one.name) {
                Some((follows, sizes)) => {
                    let own = &follows.columns[0];
                    let x: Vec<f64> = own.iter().map(|value| value + follows.at).collect();
                    let fitted: Vec<f64> =
                        own.iter().map(|value| follows.size(j, &sizes[0]).value() * value).collect();
                    let before: Vec<f64> = left.iter().zip(&fitted).map(|(left, own)| left + own).collect();
                    add(&one.name, &x, &before, left, Some(&fitted));
                }
                None => {
                    let values = explain::sampled(&one.time_s, &one.values, &time, one.holds());
                    add(&one.name, &values, &with_drift(raw, left, fit.axes.get(axis)), left, None);
                }
            }
        }
    }
    all
}

/// T − R of the axes of one name, less its mean.
fn levels(raw: &Pair, axis: usize) -> Vec<f64> {
    let d = beside(raw, axis);
    let sum: f64 = d.iter().zip(&raw.whole).filter(|(_, whole)| **whole).map(|(d, _)| d).sum();
    d.iter().map(|d| d - sum / raw.samples() as f64).collect()
}

/// Rate of change of the field along a test axis by the reference, nT/s: central differences.
fn field_rate(raw: &Pair, found: &AxisFit) -> Vec<f64> {
    let field = |row: usize| -> f64 { (0..3).map(|i| found.fit.weighted[i] * raw.reference[i][row]).sum() };
    let last = raw.whole.len() - 1;
    let rate = |row: usize| {
        let (from, to) = (row.saturating_sub(1), (row + 1).min(last));
        (field(to) - field(from)) / ((to - from) as f64 * raw.step_s)
    };
    (0..=last).map(rate).collect()
}

/// What is left, with the drift that was taken off.
fn with_drift(raw: &Pair, left: &[f64], found: Option<&DifferenceAxis>) -> Vec<f64> {
    let Some(drift) = found.map(|found| &found.drift) else { return left.to_vec() };
    let joint = exponential(drift);
    let at = |row: usize| {
        let straight = drift.straight_nt_per_day.value() * raw.since_middle_s(row) / DAY_S;
        let decay = joint.map_or(0.0, |joint| {
            joint.amplitude_nt.value() * (-(row as f64) * raw.step_s / joint.time_constant_s.value()).exp()
        });
        straight + decay
    };
    left.iter().enumerate().map(|(row, left)| left + at(row)).collect()
}
