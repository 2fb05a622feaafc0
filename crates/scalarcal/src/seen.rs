//! What the readings say beside the calibration itself.

use common::{Document, Quantity, ReferenceOffset};
use estimate::stats;

use crate::fit::FittedState;
use crate::model::{Model, NINE, Parameter, State};
use crate::noise::Groups;
use crate::read::Source;
use crate::result::earlier;
use crate::solved::{Detail, Solved};
use crate::{Error, Options, checks, stability, start};

/// A constant error of the reference is asked for where the magnitude varies by so many times the residuals:
/// less is noise of the reference in part, and biases what follows it.
const VARIES: f64 = 10.0;

/// Adds what rows that are at hand say.
///
/// # Errors
///
/// [`Error::Fit`] where a decomposition fails; windows that cannot be.
pub fn of_rows(
    document: &Document,
    solved: &mut Solved,
    detail: &Detail,
    options: &Options,
) -> Result<(), Error> {
    let magnitudes = || detail.series.iter().flat_map(|one| &one.magnitude_nt);
    let count = magnitudes().count() as f64;
    let mean = magnitudes().sum::<f64>() / count;
    let varies_nt = (magnitudes().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt();
    let rows = detail.rows(solved.scales);
    let plain = Some(&detail.plain);
    let groups = |model: &Model, found: &FittedState| solved.groups(&rows, plain, model, found);
    let before = before(document, solved).map(|state| rms(&rows.residuals(&solved.model, &state)));
    let reference_offset = reference_offset(solved, varies_nt, groups)?;
    let stability = stability::of(solved, stability::parts(solved, detail, options)?)?;
    let scalar = &mut solved.scalar;
    if !options.robust {
        scalar.findings.extend(checks::disturbed(&detail.series, &detail.residuals));
    }
    (scalar.rms_nt, scalar.rms_before_nt) = (rms(&detail.residuals), before);
    (scalar.reference_offset, scalar.stability) = (reference_offset, stability);
    Ok(())
}

fn rms(residuals: &[Vec<f64>]) -> f64 {
    let all = || residuals.iter().flatten().map(|value| value * value);
    (all().sum::<f64>() / all().count() as f64).sqrt()
}

/// The calibration that the document stated before, where there is one from elsewhere.
pub fn before(document: &Document, solved: &Solved) -> Option<State> {
    let there = crate::read::is_stated(document, solved.unit)
        && !earlier(document, solved)
        && solved.sources != [Source::Constant];
    there.then(|| {
        let mut state = solved.model.nominal();
        state[..NINE].copy_from_slice(&start::stated(document, solved.unit, &solved.scales));
        state
    })
}

/// What the reference reads too much, as one more unknown beside all others. `varies_nt` is how far the
/// magnitude varies, and `groups` makes the rows about a fit of a model.
pub fn reference_offset(
    solved: &Solved,
    varies_nt: f64,
    groups: impl FnOnce(&Model, &FittedState) -> Option<Groups>,
) -> Result<Option<ReferenceOffset>, Error> {
    let Solved { model, found, scales, known, .. } = solved;
    let read = solved.sources.iter().any(|source| matches!(source, Source::Scalar | Source::Ambient));
    if !read || model.place(&Parameter::Magnitude).is_some() || solved.scalar.vector.is_some() {
        return Ok(None);
    }
    // In a field that hardly varies a constant error of the reference is one of all sensitivities.
    let fitted = model.place(&Parameter::ReferenceOffset).is_some();
    if !fitted && varies_nt < VARIES * found.variance.sqrt() * scales.magnitude_nt {
        return Ok(None);
    }
    let of = |value: f64, variance: f64, fitted: bool| {
        let std = variance.max(0.0).sqrt();
        let p_value = stats::two_sided_p(value / std, found.freedom);
        ReferenceOffset {
            offset_nt: Quantity::new(value * scales.magnitude_nt, std * scales.magnitude_nt),
            p_value,
            fitted,
        }
    };
    if let Some(place) = model.place(&Parameter::ReferenceOffset) {
        return Ok(Some(of(found.state[place], found.covariance[(place, place)], true)));
    }
    let mut parameters = model.parameters.clone();
    parameters.push(Parameter::ReferenceOffset);
    let model = Model { terms: model.terms.clone(), parameters };
    let last = found.state.len();
    let mut beside = found.clone();
    beside.state.push(0.0);
    let variance = solved.white_variance();
    let linear = groups(&model, &beside).and_then(|groups| groups.linear(solved.form, variance, true));
    let Some(linear) = linear else { return Ok(None) };
    let linear = linear.and(&known.padded(last + 1).about(&beside.state));
    let svd = linear.svd()?;
    if svd.rank() <= last {
        return Ok(None);
    }
    let (step, covariance) = (svd.solve(&linear.right), svd.covariance());
    Ok(Some(of(step[last], covariance[(last, last)], false))
        .filter(|found| found.offset_nt.value().is_finite()))
}
