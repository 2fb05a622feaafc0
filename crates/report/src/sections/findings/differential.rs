//! Findings of diffmag.

use common::{Axis, Code, DifferenceAxis, DifferentialFit, EventInstrument, Matrix3x3, MatrixStability};

use super::largest;
use crate::Effect;

const DAY_S: f64 = 86_400.0;
const FIELD_NT: f64 = 50_000.0;

/// What findings do on the difference, on whether the matrix holds still and on noise of the reference.
pub fn difference(fit: &DifferentialFit, code: Code, about: &str) -> Effect {
    let axis = Axis::ALL.into_iter().find(|axis| axis.letter() == about).and_then(|axis| fit.axes.get(axis));
    let stability = fit.stability.as_ref();
    let element = fit.reference_noise.as_ref().and_then(|noise| noise.elements.get(about));
    match code {
        Code::ResidualIncreased => Effect::nt(axis.map(DifferenceAxis::left_nt)),
        Code::DriftOrNoise => Effect::nt(axis.and_then(|axis| undecided(fit, axis))),
        Code::EventsUnassigned => {
            let either = fit.kept_out.events.iter().filter(|one| one.instrument == EventInstrument::Either);
            Effect::nt(largest(either.map(|one| one.size_nt.value())))
        }
        Code::NotConstant => {
            let windows = stability.and_then(|stability| stability.windows.as_ref());
            Effect::nt(windows.map(|windows| windows.largest_change.change_ppm.value() * 1e-6 * FIELD_NT))
        }
        Code::SteadyChange => Effect::nt(stability.and_then(|of| steadily(of, about))),
        Code::DiffersWhenDisturbed => Effect::nt(stability.and_then(|of| disturbed(of, about))),
        Code::BiasedByReference => Effect::std(element.and_then(|one| Some(one.pull? / one.pulled_std))),
        Code::PossiblyBiasedByReference => Effect::std(element.map(|one| one.largest_pull_over_std)),
        // What adds to the difference by the rms that it adds, all axes together.
        Code::Contribution => {
            let cause = fit.contributions.iter().find(|one| one.name() == about);
            Effect::nt(cause.map(|one| one.reduction_nt2().max(0.0).sqrt()))
        }
        _ => Effect::Unstated(code.effect()),
    }
}

/// A drift that may be noise, over the recording.
fn undecided(fit: &DifferentialFit, axis: &DifferenceAxis) -> Option<f64> {
    let days = (fit.samples + fit.missing) as f64 * fit.step_s / DAY_S;
    Some(axis.drift.explanations.as_ref()?.straight_nt_per_day.value() * days)
}

/// The trend of an element, from the first window to the last.
fn steadily(stability: &MatrixStability, element: &str) -> Option<f64> {
    let windows = stability.windows.as_ref()?;
    let days = (windows.windows.last()?.to_s - windows.windows.first()?.from_s) / DAY_S;
    Some(of(element, &windows.trend_per_day)? * days * FIELD_NT)
}

/// The difference of an element between quiet and disturbed times.
fn disturbed(stability: &MatrixStability, element: &str) -> Option<f64> {
    let times = stability.quiet_disturbed.as_ref()?;
    let [quiet, disturbed] =
        [&times.quiet, &times.disturbed].map(|time| of(element, &time.as_ref()?.estimate.matrix));
    Some((disturbed? - quiet?) * FIELD_NT)
}

/// An element by its name, `xz`: z from x.
fn of(element: &str, matrix: &Matrix3x3) -> Option<f64> {
    let mut places = element.chars().map(|axis| "xyz".find(axis));
    Some(matrix[places.next()??][places.next()??])
}
