//! Findings of diffmag.

use common::{Axis, Code, DifferentialFit, EventInstrument, Matrix3x3};

use super::largest;
use crate::Effect;

const DAY_S: f64 = 86_400.0;
const FIELD_NT: f64 = 50_000.0;

/// What findings do on the difference, on whether the matrix holds still and on noise of the reference.
pub fn difference(fit: &DifferentialFit, code: Code, about: &str) -> Option<Effect> {
    let axis = Axis::ALL.into_iter().find(|axis| axis.letter() == about).and_then(|axis| fit.axes.get(axis));
    let element = fit.reference_noise.as_ref().and_then(|noise| noise.elements.get(about));
    let windows = || fit.stability.as_ref()?.windows.as_ref();
    Some(match code {
        Code::ResidualIncreased => Effect::nt(axis?.left_nt()),
        // A drift that may be noise, over the recording.
        Code::DriftOrNoise => {
            let days = (fit.samples + fit.missing) as f64 * fit.step_s / DAY_S;
            Effect::nt(axis?.drift.explanations.as_ref()?.straight_nt_per_day.value() * days)
        }
        Code::EventsUnassigned => {
            let either = fit.kept_out.events.iter().filter(|one| one.instrument == EventInstrument::Either);
            Effect::nt(largest(either.map(|one| one.size_nt.value())))
        }
        Code::NotConstant => Effect::nt(windows()?.largest_change.change_ppm.value() * 1e-6 * FIELD_NT),
        // The trend of an element, from the first window to the last.
        Code::SteadyChange => {
            let all = &windows()?.windows;
            let days = (all.last()?.to_s - all.first()?.from_s) / DAY_S;
            Effect::nt(of(about, &windows()?.trend_per_day)? * days * FIELD_NT)
        }
        // The difference of an element between quiet and disturbed times.
        Code::DiffersWhenDisturbed => {
            let times = fit.stability.as_ref()?.quiet_disturbed.as_ref()?;
            let [quiet, disturbed] =
                [&times.quiet, &times.disturbed].map(|time| of(about, &time.as_ref()?.estimate.matrix));
            Effect::nt((disturbed? - quiet?) * FIELD_NT)
        }
        Code::BiasedByReference => Effect::std(element?.pull? / element?.pulled_std),
        Code::PossiblyBiasedByReference => Effect::std(element?.largest_pull_over_std),
        // What adds to the difference by the rms that it adds, all axes together.
        Code::Contribution => {
            let cause = fit.contributions.iter().find(|one| one.name() == about)?;
            Effect::nt(cause.reduction_nt2().max(0.0).sqrt())
        }
        _ => Effect::Unstated(code.effect()),
    })
}

/// An element by its name, `xz`: z from x.
fn of(element: &str, matrix: &Matrix3x3) -> Option<f64> {
    let mut places = element.chars().map(|axis| "xyz".find(axis));
    Some(matrix[places.next()??][places.next()??])
}
