//! Findings of diffmag.

use common::{Axis, DifferentialFit, EventInstrument, MatrixEstimate, MatrixStability, ReferenceNoise};

use super::{LEFT_OUT, NOT_SHOWN, NOT_SIGNIFICANT, Rule, UNCERTAINTY, effect, largest};
use crate::{Effect, Finding};

const DAY_S: f64 = 86_400.0;
const FIELD_NT: f64 = 50_000.0;

/// What findings on the difference do, but for those on what adds to it.
pub const FIT: [Rule<DifferentialFit>; 8] = [
    ("do not use this matrix", |fit, words| Effect::nt(left(fit, words))),
    ("the errors are correlated in time", |_, _| UNCERTAINTY),
    ("the difference is not of the form A/f^α plus white noise", |_, _| UNCERTAINTY),
    (": a drift of ", |fit, words| Effect::nt(undecided(fit, words))),
    ("some events cannot be assigned to one instrument", |fit, _| {
        let either = fit.kept_out.events.iter().filter(|one| one.instrument == EventInstrument::Either);
        Effect::nt(largest(either.map(|one| one.size_nt.value())))
    }),
    ("replaced by its most likely value under the fitted noise", |_, _| LEFT_OUT),
    ("that the final fit does not confirm", |_, _| NOT_SIGNIFICANT),
    ("the readings of the third instrument enter no regression of", |_, _| UNCERTAINTY),
];

/// What findings on whether the matrix holds still do.
pub const STABILITY: [Rule<MatrixStability>; 6] = [
    ("the matrix is not constant", |stability, _| {
        let windows = stability.windows.as_ref();
        Effect::nt(windows.map(|windows| windows.largest_change.change_ppm.value() * 1e-6 * FIELD_NT))
    }),
    ("the matrix changes steadily", |stability, _| Effect::nt(steadily(stability))),
    ("have a different matrix from quiet ones", |stability, _| Effect::nt(disturbed(stability))),
    ("too few degrees of freedom to be tested", |_, _| NOT_SHOWN),
    (" cannot be determined: ", |_, _| NOT_SHOWN),
    ("this recording cannot show whether the matrix differs", |_, _| NOT_SHOWN),
];

/// What findings on noise of the reference do.
pub const REFERENCE: [Rule<ReferenceNoise>; 3] = [
    ("noise of the reference had biased the matrix", |noise, _| {
        let pulled = noise.elements.values();
        Effect::std(largest(pulled.filter_map(|one| Some(one.pull? / one.pulled_std))))
    }),
    ("noise of the reference may have biased the matrix", |noise, _| {
        Effect::std(largest(noise.elements.values().map(|one| one.largest_pull_over_std)))
    }),
    ("and their separation is unreliable", |_, _| UNCERTAINTY),
];

/// Findings on the difference: what adds to it by how much it adds.
pub fn of_fit(fit: &DifferentialFit) -> Vec<Finding> {
    let effect =
        |words: &String| contribution(fit, words).map_or_else(|| effect(words, &FIT, fit), Effect::nt);
    fit.findings.iter().map(|words| Finding::of(words, effect(words))).collect()
}

/// The rms that a thing adds to the difference, all axes together; None where the finding is about no such
/// thing.
fn contribution(fit: &DifferentialFit, words: &str) -> Option<f64> {
    let cause = fit.contributions.iter().find(|one| !one.what.is_empty() && words.contains(&one.what))?;
    Some(cause.reduction_nt2().max(0.0).sqrt())
}

/// What is left of an axis that a finding names, nT.
fn left(fit: &DifferentialFit, words: &str) -> Option<f64> {
    let named = |axis: &Axis| words.starts_with(&format!("test {axis}: "));
    Some(fit.axes.get(Axis::ALL.into_iter().find(named)?)?.left_nt())
}

/// A drift that may be noise, over the recording.
fn undecided(fit: &DifferentialFit, words: &str) -> Option<f64> {
    let named = |axis: &Axis| words.starts_with(&format!("test {axis}: "));
    let axis = fit.axes.get(Axis::ALL.into_iter().find(named)?)?;
    let days = (fit.samples + fit.missing) as f64 * fit.step_s / DAY_S;
    Some(axis.drift.explanations.as_ref()?.straight_nt_per_day.value() * days)
}

/// The trend that stands out most, from the first window to the last.
fn steadily(stability: &MatrixStability) -> Option<f64> {
    let windows = stability.windows.as_ref()?;
    let days = (windows.windows.last()?.to_s - windows.windows.first()?.from_s) / DAY_S;
    let trend = elements().map(|(i, j)| (windows.trend_per_day[i][j], windows.trend_std_per_day[i][j]));
    Some(most(trend)? * days * FIELD_NT)
}

/// The element that differs most, for its uncertainty, between quiet and disturbed times.
fn disturbed(stability: &MatrixStability) -> Option<f64> {
    let times = stability.quiet_disturbed.as_ref()?;
    let (quiet, disturbed): (&MatrixEstimate, &MatrixEstimate) =
        (&times.quiet.as_ref()?.estimate, &times.disturbed.as_ref()?.estimate);
    let each = elements().map(|(i, j)| {
        (disturbed.matrix[i][j] - quiet.matrix[i][j], disturbed.std[i][j].hypot(quiet.std[i][j]))
    });
    Some(most(each)? * FIELD_NT)
}

fn elements() -> impl Iterator<Item = (usize, usize)> {
    (0..3).flat_map(|i| (0..3).map(move |j| (i, j)))
}

/// The value that is largest for its uncertainty.
fn most(all: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let known = all.filter(|(value, std)| (value / std).is_finite());
    known.max_by(|a, b| (a.0 / a.1).abs().total_cmp(&(b.0 / b.1).abs())).map(|(value, _)| value)
}
