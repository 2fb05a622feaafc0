//! What the readings say beside the calibration itself: of the calibration that was stated before, of a
//! constant error of the reference, and whether the calibration holds over the time.

use common::{Document, Quantity, ReferenceOffset, ScalarCalibration, ScalarStability, ScalarWindow};
use estimate::{Svd, stats};
use faer::ColRef;

use crate::design::Rows;
use crate::fit::FittedState;
use crate::given::{Given, stated};
use crate::linear::Linear;
use crate::model::{Model, NINE, Parameter, State};
use crate::noise::Groups;
use crate::read::{Series, Source, is_stated};
use crate::result::{described, earlier};
use crate::solved::Solved;
use crate::weakest::UNDETERMINED;
use crate::{Error, Options, checks};

/// A constant error of the reference is asked for where the magnitude varies by so many times the residuals:
/// less is noise of the reference in part, and biases what follows it.
const VARIES: f64 = 10.0;
/// Parts of one recording at most, where none are asked for.
pub const PARTS: usize = 8;
/// Windows at most, where they are asked for.
const MOST_WINDOWS: f64 = 10_000.0;
/// Rows of a part for each parameter, at least.
pub const ROWS_PER_PARAMETER: usize = 20;
/// Singular values of a part below this share of the largest say nothing of its own.
const RANK_TOLERANCE: f64 = 1e-6;
/// Fewer parts than these cannot be compared.
const FEWEST_PARTS: usize = 2;

/// Adds what rows that are at hand say.
///
/// Errors: [`Error::Fit`] where a decomposition fails; windows that cannot be.
pub fn of_rows(
    document: &Document,
    solved: &mut Solved,
    series: &[Series],
    options: &Options,
) -> Result<(), Error> {
    let magnitudes = || series.iter().flat_map(|one| &one.magnitude_nt);
    let count = magnitudes().count() as f64;
    let mean = magnitudes().sum::<f64>() / count;
    let varies_nt = (magnitudes().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt();
    let rows = Rows::new(series, solved.given.scales);
    let groups = |model: &Model, found: &FittedState| solved.groups(&rows, Some(&solved.plain), model, found);
    let parts = parts(solved, &rows, options)?;
    let rms_before = |state: &State| rms(&rows.residuals(&solved.model, state));
    solved.scalar =
        beside(document, solved, (rms(&solved.residuals), rms_before), (varies_nt, groups), parts)?;
    if !options.robust {
        solved.scalar.findings.extend(checks::disturbed(series, &solved.residuals));
    }
    Ok(())
}

/// What is said of a calibration with that which the readings say beside it: their rms now and by a state,
/// what the reference reads too much, and χ² of the parts. `varies_nt` is how far the magnitude varies, and
/// `groups` makes the rows about a fit of a model.
pub fn beside(
    document: &Document,
    solved: &Solved,
    (rms_nt, rms_by): (f64, impl Fn(&State) -> f64),
    (varies_nt, groups): (f64, impl Fn(&Model, &FittedState) -> Option<Groups>),
    parts: Vec<Part>,
) -> Result<ScalarCalibration, Error> {
    // The calibration that the document stated before, where there is one from elsewhere.
    let Given { unit, scales, .. } = &solved.given;
    let before =
        is_stated(document, *unit) && !earlier(document, solved) && solved.sources != [Source::Constant];
    let before = before.then(|| solved.model.with(&stated(document, *unit, scales)));
    Ok(ScalarCalibration {
        rms_nt,
        rms_before_nt: before.map(|state| rms_by(&state)),
        reference_offset: reference_offset(solved, varies_nt, groups)?,
        stability: stability(solved, parts)?,
        ..solved.scalar.clone()
    })
}

fn rms(residuals: &[Vec<f64>]) -> f64 {
    let all = || residuals.iter().flatten().map(|value| value * value);
    (all().sum::<f64>() / all().count() as f64).sqrt()
}

/// What the reference reads too much, as one more unknown beside all others.
fn reference_offset(
    solved: &Solved,
    varies_nt: f64,
    groups: impl FnOnce(&Model, &FittedState) -> Option<Groups>,
) -> Result<Option<ReferenceOffset>, Error> {
    let (Solved { model, found, known, .. }, size_nt) = (solved, solved.given.scales.magnitude_nt);
    let read = solved.sources.iter().any(|source| matches!(source, Source::Scalar | Source::Ambient));
    if !read || model.place(&Parameter::Magnitude).is_some() || solved.scalar.vector.is_some() {
        return Ok(None);
    }
    // In a field that hardly varies a constant error of the reference is one of all sensitivities.
    let fitted = model.place(&Parameter::ReferenceOffset).is_some();
    if !fitted && varies_nt < VARIES * found.variance.sqrt() * size_nt {
        return Ok(None);
    }
    let of = |value: f64, variance: f64, fitted: bool| {
        let std = variance.max(0.0).sqrt();
        let p_value = stats::two_sided_p(value / std, found.freedom);
        ReferenceOffset { offset_nt: Quantity::new(value * size_nt, std * size_nt), p_value, fitted }
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

pub struct Part {
    pub span_s: [f64; 2],
    pub rows: u64,
    /// Rms of the residual about the calibration of all, nT.
    pub rms_nt: f64,
    /// Its rows about that; None where they are too few.
    pub groups: Option<Groups>,
}

/// χ² of the parts: with r the residuals of all and J their derivatives, Σ |P_J r|² over the parts, P_J on
/// the range of a part's derivatives, is what the parts gain by parameters of their own. None for one.
fn stability(solved: &Solved, parts: Vec<Part>) -> Result<Option<ScalarStability>, Error> {
    // By the magnitude, which does not show the turn of the sensors; what is held is then of the turn too.
    let turned = solved.scalar.vector.is_some();
    let count = solved.model.by_magnitude().parameters.len();
    if parts.len() < FEWEST_PARTS {
        return Ok(None);
    }
    let (mut chi_squared, mut rank, mut rows) = (0.0, 0, 0.0);
    let mut windows = Vec::new();
    let variance = solved.white_variance();
    // What is held stays where it is.
    let fixed = if turned { Linear::none(count) } else { solved.held.fixed() };
    for part in parts {
        let [from_s, to_s] = part.span_s;
        let mut window =
            ScalarWindow { from_s, to_s, rows: part.rows, rms_nt: part.rms_nt, ..ScalarWindow::default() };
        let linear = part.groups.and_then(|groups| groups.linear(solved.form, variance, false));
        if let Some(linear) = linear {
            let Linear { jacobian, right } = linear.and(&fixed);
            let svd = Svd::of(jacobian.as_ref(), RANK_TOLERANCE)?;
            let step = svd.solve(&right);
            chi_squared += (&jacobian * ColRef::from_slice(&step)).squared_norm_l2();
            rank += svd.rank();
            rows += part.rows as f64;
            let covariance = svd.covariance();
            let std: Vec<f64> = (0..count).map(|place| covariance[(place, place)].max(0.0).sqrt()).collect();
            // Effects and what else is fitted have units of their own.
            let sure = std.iter().take(NINE).all(|std| *std < UNDETERMINED);
            if svd.rank() == count && sure {
                let of = |place: usize| described(solved, place);
                window.values = (0..count).map(|place| of(place).2 + step[place] * of(place).3).collect();
                window.std = (0..count).map(|place| std[place] * of(place).3.abs()).collect();
            }
        }
        windows.push(window);
    }
    let degrees_of_freedom = rank.saturating_sub(count) as f64;
    if degrees_of_freedom < 1.0 {
        return Ok(None);
    }
    // Against the scatter about parameters of the parts' own, which a change does not raise.
    let freedom = (rows - rank as f64).max(1.0);
    let left = (rows - chi_squared - rank as f64).max(1.0);
    let f = (chi_squared / degrees_of_freedom) / (left / freedom);
    let p_value = stats::f_p(f, degrees_of_freedom, freedom);
    // The same scatter is that of the windows.
    let scatter = (left / freedom).sqrt();
    windows.iter_mut().flat_map(|window| &mut window.std).for_each(|std| *std *= scatter);
    Ok(Some(ScalarStability { windows, chi_squared, degrees_of_freedom, p_value }))
}

/// The parts of recordings whose rows are at hand: windows where they are asked for.
///
/// Errors: windows without times to cut by, or so short that there are too many.
fn parts(solved: &Solved, all: &Rows<'_>, options: &Options) -> Result<Vec<Part>, Error> {
    let model = solved.model.by_magnitude();
    let pieces = match options.fit.windows_s {
        Some(length) => by_time(all.series, length)?,
        None => pieces(all.series, model.parameters.len()),
    };
    if pieces.len() < FEWEST_PARTS {
        return Ok(Vec::new());
    }
    let of = |(number, from, to): (usize, usize, usize)| {
        let rows = all.part(number, from..to);
        let plain = solved.white.then(|| rows.factor(&solved.model.terms));
        let groups = solved.groups(&rows, plain.as_ref(), &model, &solved.found);
        let time = all.series[number].time_s.as_ref();
        let [from_s, to_s] = [from, to - 1].map(|row| time.map_or(row as f64, |time| time[row]));
        let squares: f64 = solved.residuals[number][from..to].iter().map(|value| value * value).sum();
        let rms_nt = (squares / (to - from) as f64).sqrt();
        Part { span_s: [from_s, to_s], rows: (to - from) as u64, rms_nt, groups }
    };
    let parts: Vec<Part> = pieces.into_iter().map(of).collect();
    // Of parts that nobody asked for all are compared, or none.
    let whole = options.fit.windows_s.is_some() || parts.iter().all(|part| part.groups.is_some());
    Ok(if whole { parts } else { Vec::new() })
}

/// Parts of the recordings: recording, first row, and the row after the last.
fn pieces(series: &[Series], parameters: usize) -> Vec<(usize, usize, usize)> {
    let of = |(number, one): (usize, &Series)| {
        let rows = one.len();
        let parts = (rows / (ROWS_PER_PARAMETER * parameters)).clamp(1, PARTS);
        (0..parts).map(move |part| (number, rows * part / parts, rows * (part + 1) / parts))
    };
    series.iter().enumerate().flat_map(of).filter(|(_, from, to)| to > from).collect()
}

/// The same by windows of one length from the beginning of each recording, s.
fn by_time(series: &[Series], length_s: f64) -> Result<Vec<(usize, usize, usize)>, Error> {
    let mut all = Vec::new();
    for (number, one) in series.iter().enumerate() {
        let times = one.time_s.as_deref().filter(|times| times.windows(2).all(|pair| pair[1] >= pair[0]));
        let Some(times) = times else {
            let found = format!("no increasing times of the rows of \"{}\"", one.id);
            let expected = "`time_s`, which --windows needs";
            return Err(Error::document(format!("{}.columns.time_s", one.path()), found, expected));
        };
        let Some((first, last)) = times.first().zip(times.last()) else { continue };
        let window = |time: f64| ((time - first) / length_s).floor();
        if window(*last) >= MOST_WINDOWS {
            return Err(Error::Request(format!(
                "--windows {length_s}: found {} windows in \"{}\"; expected at most {MOST_WINDOWS}: use longer ones",
                window(*last) + 1.0,
                one.id
            )));
        }
        let mut from = 0;
        for to in 1..=times.len() {
            if to == times.len() || window(times[to]) > window(times[from]) {
                all.push((number, from, to));
                from = to;
            }
        }
    }
    Ok(all)
}
