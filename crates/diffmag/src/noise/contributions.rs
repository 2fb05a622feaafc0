//! What each thing adds to the difference: its rms with the thing and without, by least squares of all the
//! others.

use common::{
    Axis, ClockDifference, Contribution, ContributionCause, DifferentialFit, DriftForm, EventKind, PerAxis,
};
use estimate::Svd;
use estimate::cosine::Cosine;
use estimate::resample::PASSBAND;
use estimate::stats::mean;
use faer::Mat;

use crate::drift::exponential;
use crate::{Error, words};
use joined::{DAY_S, Pair};
use paired::followed::Follows;
use paired::look::{Moved, Shift, aligned};
use paired::prepare::Prepared;
use paired::residual::{of_levels, scatter};
use paired::{TOLD_BELOW, p_of};

/// Columns that others make up to this share of the largest singular value say nothing of their own.
const DEPENDENT: f64 = 1e-12;

/// Writes the contributions, the largest first, and the rms that is known without any fit.
pub fn add(
    (recorded, raw): (&Pair, &Pair),
    prepared: &Prepared,
    followed: &[Follows],
    fit: &mut DifferentialFit,
) -> Result<(), Error> {
    for (axis, test) in Axis::ALL.into_iter().zip(&recorded.test) {
        if let Some(of) = fit.axes.entry(axis) {
            of.rms_of_readings_nt = Some(scatter(test, &raw.whole));
            of.rms_of_levels_nt = Some(of_levels(recorded, axis.index()));
        }
    }
    let cosine = Cosine::new(raw.whole.len(), raw.step_s);
    let whole = Design { drift: true, followed };
    let final_rms = rms(&prepared.pair, fit, whole)?;
    let mut all: Vec<Contribution> = clock(raw, prepared, fit, &cosine, whole)?.into_iter().collect();
    let mut beside = |cause, what: Option<String>, with: PerAxis<f64>, column: Option<String>| {
        all.extend(what.map(|what| Contribution {
            cause,
            what,
            column,
            taken_off: true,
            rms_with_nt: with,
            rms_without_nt: final_rms.clone(),
            ..Contribution::default()
        }));
    };
    let drift = Design { drift: false, ..whole };
    if let Some(what) = words::drifts(fit) {
        let with = rms(&prepared.pair, fit, drift)?;
        let of = |axis: Axis| {
            let taken_off = if demanded(fit, axis) { &with } else { &final_rms };
            Some((axis, *taken_off.get(axis)?))
        };
        let with = Axis::ALL.into_iter().filter_map(of).collect();
        beside(ContributionCause::Drift, Some(what), with, None);
    }
    for (name, what) in words::followed(fit) {
        let others: Vec<Follows> = followed.iter().filter(|one| one.name != name).cloned().collect();
        let own = followed.iter().filter(|one| one.name == name);
        let pair = own.fold(prepared.pair.clone(), |pair, one| one.added(&pair, 1.0));
        let with = rms(&pair, fit, Design { followed: &others, ..whole })?;
        beside(ContributionCause::Column, Some(what), with, Some(name));
    }
    if fit.kept_out.events.iter().any(|event| event.kind == EventKind::Step) {
        let with = rms(&without(raw, prepared, |kind| kind != EventKind::Step), fit, whole)?;
        beside(ContributionCause::Steps, words::steps(&fit.kept_out), with, None);
    }
    if fit.kept_out.events.iter().any(|event| event.kind != EventKind::Step) {
        let with = rms(&without(raw, prepared, |kind| kind == EventKind::Step), fit, whole)?;
        beside(ContributionCause::Disturbances, words::disturbances(&fit.kept_out), with, None);
    }
    if let Some(what) = words::short_periods(fit) {
        let long = per_axis(|axis| {
            let highest = fit.axes.get(axis).and_then(|of| of.weighted_up_to_hz);
            let left = left(&prepared.pair, axis, &prepared.pair.whole, fit, whole)?;
            let squares = squares_below(&cosine, &left, highest.unwrap_or(f64::INFINITY));
            Ok((squares / prepared.pair.samples() as f64).sqrt())
        })?;
        all.push(Contribution {
            cause: ContributionCause::ShortPeriods,
            what,
            rms_with_nt: final_rms.clone(),
            rms_without_nt: long,
            ..Contribution::default()
        });
    }
    all.sort_by(|a, b| b.reduction_nt2().total_cmp(&a.reduction_nt2()));
    fit.contributions = all;
    Ok(())
}

/// The clocks' difference, where it is one. Moving readings in time filters them; above the filter's band
/// what is left is taken as alike.
fn clock(
    raw: &Pair,
    prepared: &Prepared,
    fit: &DifferentialFit,
    cosine: &Cosine,
    design: Design<'_>,
) -> Result<Option<Contribution>, Error> {
    let Some((clock, shift)) = fit.clock.as_ref().and_then(|clock| Some((clock, shift(prepared, clock)?)))
    else {
        return Ok(None);
    };
    let late = prepared.events.taken_out(raw, shift);
    let right = aligned(late.clone(), shift, Moved::Test);
    let rows: Vec<bool> = late.whole.iter().zip(&right.whole).map(|(a, b)| *a && *b).collect();
    let count = rows.iter().filter(|row| **row).count() as f64;
    let band = PASSBAND * 0.5 / raw.step_s;
    let (mut with, mut without) = (PerAxis::default(), PerAxis::default());
    for axis in Axis::ALL {
        let late = left(&late, axis, &rows, fit, design)?;
        let right = left(&right, axis, &rows, fit, design)?;
        let all: f64 = late.iter().map(|d| d * d).sum();
        let above = (all - squares_below(cosine, &late, band)).max(0.0);
        *with.entry(axis) = Some((all / count).sqrt());
        *without.entry(axis) = Some(((above + squares_below(cosine, &right, band)) / count).sqrt());
    }
    Ok(Some(Contribution {
        cause: ContributionCause::Clock,
        what: words::clock(clock),
        taken_off: clock.corrected,
        rms_with_nt: with,
        rms_without_nt: without,
        ..Contribution::default()
    }))
}

/// What the test instrument's times are moved by; None where chance says as much.
fn shift(prepared: &Prepared, clock: &ClockDifference) -> Option<Shift> {
    let differs = p_of(&clock.offset_s).min(p_of(&clock.rate_ppm)) < TOLD_BELOW;
    (differs || !clock.segments.is_empty()).then_some(prepared.shift)
}

/// The pair on the clock on which it is fitted, without the events of these kinds, and with the others.
fn without(raw: &Pair, prepared: &Prepared, kinds: impl Fn(EventKind) -> bool) -> Pair {
    let (clock, shift) = (prepared.clock.as_ref(), prepared.shift);
    let kept: Vec<bool> = prepared.events.found.iter().map(|event| kinds(event.kind)).collect();
    let pair = prepared.events.confirmed(&kept).taken_out(raw, shift);
    if clock.is_some_and(|clock| clock.corrected) { aligned(pair, shift, Moved::Test) } else { pair }
}

/// What is fitted besides the reference's axes, a level and the pair's steps.
#[derive(Clone, Copy)]
struct Design<'a> {
    drift: bool,
    followed: &'a [Follows],
}

fn demanded(fit: &DifferentialFit, axis: Axis) -> bool {
    fit.axes.get(axis).is_some_and(|of| of.drift.demanded != DriftForm::None)
}

fn rms(pair: &Pair, fit: &DifferentialFit, design: Design<'_>) -> Result<PerAxis<f64>, Error> {
    per_axis(|axis| {
        let squares: f64 = left(pair, axis, &pair.whole, fit, design)?.iter().map(|d| d * d).sum();
        Ok((squares / pair.samples() as f64).sqrt())
    })
}

fn per_axis<T>(of: impl Fn(Axis) -> Result<T, Error>) -> Result<PerAxis<T>, Error> {
    Axis::ALL.into_iter().map(|axis| Ok((axis, of(axis)?))).collect()
}

/// What least squares leave of an axis in these rows, zero in the others. Normal equations of columns about
/// their means: no column is made.
fn left(
    pair: &Pair,
    axis: Axis,
    rows: &[bool],
    fit: &DifferentialFit,
    design: Design<'_>,
) -> Result<Vec<f64>, Error> {
    let test = &pair.test[axis.index()];
    let means = pair.reference.each_ref().map(|column| mean(column));
    let level = mean(test);
    let steps = &pair.steps[axis.index()];
    let decay = fit.axes.get(axis).and_then(|of| exponential(&of.drift)).filter(|_| design.drift);
    let decay_s = decay.map(|decay| decay.time_constant_s.value());
    let followed = design.followed;
    // Beside a column that it follows an axis has a straight drift only where one is demanded.
    let days = design.drift && (demanded(fit, axis) || followed.is_empty());
    let fill = |row: usize, values: &mut Vec<f64>| {
        values.clear();
        values.push(1.0);
        values.extend((0..3).map(|i| pair.reference[i][row] - means[i]));
        values.extend(days.then(|| pair.since_middle_s(row) / DAY_S));
        values.extend(decay_s.map(|decay_s| (-(row as f64) * pair.step_s / decay_s).exp()));
        values.extend(followed.iter().flat_map(|follows| &follows.columns).map(|column| column[row]));
        values.extend(steps.iter().map(|(step, _)| if row < *step { 0.0 } else { 1.0 }));
    };
    let used = || (0..test.len()).filter(|row| rows[*row]);
    let mut values = Vec::new();
    fill(0, &mut values);
    let width = values.len();
    let mut gram = Mat::<f64>::zeros(width, width);
    let mut right = vec![0.0; width];
    for row in used() {
        fill(row, &mut values);
        for j in 0..width {
            right[j] += values[j] * (test[row] - level);
            for i in 0..=j {
                gram[(i, j)] += values[i] * values[j];
            }
        }
    }
    // Columns of length one: what is dependent then does not hang on units.
    let scale: Vec<f64> =
        (0..width).map(|j| if gram[(j, j)] > 0.0 { gram[(j, j)].sqrt() } else { 1.0 }).collect();
    let even = Mat::from_fn(width, width, |i, j| gram[(i.min(j), i.max(j))] / (scale[i] * scale[j]));
    let right: Vec<f64> = right.iter().zip(&scale).map(|(value, scale)| value / scale).collect();
    let solved = Svd::of(even.as_ref(), DEPENDENT)?.solve(&right);
    let mut residual = vec![0.0; test.len()];
    for row in used() {
        fill(row, &mut values);
        let explained: f64 = (0..width).map(|j| solved[j] / scale[j] * values[j]).sum();
        residual[row] = test[row] - level - explained;
    }
    Ok(residual)
}

/// Sum of the squares of a series about its mean, of its frequencies up to one (Hz).
fn squares_below(cosine: &Cosine, values: &[f64], highest_hz: f64) -> f64 {
    let below = |k: usize| cosine.frequency(k + 1) <= highest_hz;
    cosine.transform(values).iter().enumerate().take_while(|(k, _)| below(*k)).map(|(_, c)| c * c).sum()
}
