//! The calibration of what is kept of a long series.

use common::{Axis, Code, Document};

use super::memory;
use super::partial::Partial;
use super::windows::Window;
use crate::design::{Rows, Scales};
use crate::fit::{FittedState, variance};
use crate::given::Given;
use crate::kalman::WHITE;
use crate::model::{Model, Parameter, State};
use crate::noise::Groups;
use crate::read::{self, Series, Source};
use crate::seen::{self, Part};
use crate::solved::Solved;
use crate::terms::{Factor, ONE, Terms};
use crate::{Error, FitOptions, checks, result, start, words};

/// What is said where noise with memory was not looked for.
const NO_MEMORY: &str = "correlated noise was not estimated, because there are too few rows or windows, or the noise is too large: the uncertainties assume white noise";
/// Readings are those of another sensor where they differ by less than this share of their squares.
const SAME: f64 = 1e-14;

/// Calibrates the sensors by what is kept of a series, and writes them into a document, which states what is
/// known of instrument and facility. Its recordings are not read.
///
/// Errors: as [`crate::run`]; a document whose model has effects, which could be taken off rows only.
pub fn document(partial: &Partial, document: Document, options: &FitOptions) -> Result<Document, Error> {
    adopted(partial, document, options).map_err(words::failed)
}

fn adopted(partial: &Partial, mut document: Document, options: &FitOptions) -> Result<Document, Error> {
    let (mut solved, series, windows) = solve(partial, &document, options)?;
    if options.known && result::earlier(&document, &solved) {
        let found = "a calibration by scalarcal from the same series";
        let expected = "one from another source: with --known each reading would count twice";
        return Err(Error::document("calibration.scalar.recordings", found, expected));
    }
    seen(partial, &document, &mut solved, &windows, options)?;
    result::adopt(&mut document, solved, &[series])?;
    Ok(document)
}

fn solve(
    partial: &Partial,
    document: &Document,
    options: &FitOptions,
) -> Result<(Solved, Series, Vec<Window>), Error> {
    let adopted = physics::adopt(document).map_err(|error| error.at("model"))?;
    if !adopted.is_empty() {
        let found = "effects, which a stream cannot subtract from the readings";
        let expected = "none; correct the readings, or calibrate a document with rows";
        return Err(Error::document("model.effects", found, expected));
    }
    let (windows, left_out) = used(partial);
    let columns = Terms::new(ONE + 1).count();
    let raw = Factor::joined(columns, windows.iter().map(|window| &window.factor));
    if raw.rows == 0 {
        let words =
            "no row in which all three sensors and the reference were read; expected rows without a null";
        return Err(Error::Request(words.into()));
    }
    check(partial, document, &raw)?;
    let mean_nt = raw.product(columns - 2, columns - 1) / raw.product(columns - 2, columns - 2);
    let swing = (0..3).filter_map(|axis| partial.ends.range(axis)).map(|[high, low]| 0.5 * (high - low));
    let scales = start::scales_of(document, partial.unit(), Some(mean_nt), swing.fold(0.0, f64::max));
    let given = Given::of(document, options, partial.unit(), scales)?;
    let model = Model::new(ONE + 1, options.reference_offset.then_some(Parameter::ReferenceOffset));
    let by = column_scales(&model.terms, &scales);
    let scaled = |one: Window| Window { factor: one.factor.scaled(&by), ..one };
    let windows: Vec<Window> = windows.into_iter().map(scaled).collect();
    let series = sample(partial);
    let rows = Rows::new(std::slice::from_ref(&series), scales);
    let mut solved = Solved::fit(given, model, &rows, None, raw.scaled(&by))?;
    let groups = |solved: &Solved| groups(&windows, &solved.model, &solved.found);
    if !solved.finish(&rows, groups, memory::widen)? && !solved.white {
        solved.scalar.findings.push(Code::CorrelationNotEstimated.said(NO_MEMORY));
    }
    solved.scalar.left_out.extend(left_out);
    Ok((solved, series, windows))
}

/// The windows without rows at the end of a sensor's range, and how many these are by sensor.
fn used(partial: &Partial) -> (Vec<Window>, Vec<(String, u64)>) {
    let piles = partial.ends.piles();
    let mut left_out = [0; 3];
    let mut windows: Vec<Window> = Vec::new();
    for window in &partial.windows.windows {
        match (checks::sensor_at(window.at & piles), windows.last_mut()) {
            (Some(axis), _) => left_out[axis.index()] += window.factor.rows,
            (None, Some(last)) if last.place == window.place => last.join(window),
            (None, _) => windows.push(window.clone()),
        }
    }
    (windows, checks::saturated(left_out))
}

/// A reference in another unit, and sensors that read one value, or one the same as another.
fn check(partial: &Partial, document: &Document, raw: &Factor) -> Result<(), Error> {
    let (unit, terms) = (partial.unit(), Terms::new(ONE + 1));
    let name = |axis: Axis| format!("sensor_{axis}_{}", unit.suffix());
    let refused = |axis: Axis, found: String, expected: &str| {
        Err(Error::Request(format!("{}: found {found}; expected {expected}", name(axis))))
    };
    let last = terms.count() - 1;
    // Σ V_a V_b/4F², and Σ V_a²/4.
    let one = |axis: Axis| terms.product(axis.index(), ONE);
    let product = |a: Axis, b: Axis| raw.product(one(a), one(b));
    let square = |axis: Axis| raw.product(terms.product(axis.index(), axis.index()), last);
    for axis in Axis::ALL {
        if let Some([high, low]) = partial.ends.range(axis.index()).filter(|_| partial.rows > 1)
            && high <= low
        {
            let found = format!("the reading {high} in all rows");
            let expected = "a rotated sensor; is it connected, or did the logger freeze?";
            return refused(axis, found, expected);
        }
    }
    for (a, b) in [(Axis::X, Axis::Y), (Axis::Y, Axis::Z), (Axis::X, Axis::Z)] {
        let apart = product(a, a) + product(b, b) - 2.0 * product(a, b);
        if raw.rows > 1 && apart <= SAME * product(a, a) {
            let found = format!("the readings of {}", name(a));
            return refused(b, found, "readings of its own; was a column copied?");
        }
    }
    let mean_square = |sum: f64| (4.0 * sum / raw.rows as f64).sqrt();
    let magnitude_nt = mean_square(raw.product(last, last));
    let length = mean_square(Axis::ALL.into_iter().map(square).sum::<f64>());
    let column = if partial.source() == Source::Ambient { "ambient_x_nt" } else { "reference_nt" };
    let read = read::nominal(document, unit).map(|scale| scale * length);
    read::in_units(column.into(), magnitude_nt, read)
}

/// What the products over 2F are times in the units of a fit.
fn column_scales(terms: &Terms, scales: &Scales) -> Vec<f64> {
    let one = |f: usize| match f {
        0..=2 => scales.sensitivity[f] / scales.magnitude_nt,
        ONE => 1.0,
        _ => 1.0 / scales.magnitude_nt,
    };
    terms.pairs.iter().map(|[f, g]| one(*f) * one(*g) * scales.magnitude_nt).collect()
}

/// The sample as a recording, without rows that are left out.
fn sample(partial: &Partial) -> Series {
    let piles = partial.ends.piles();
    let all = partial.sample.rows();
    let kept: Vec<[f64; 5]> =
        all.into_iter().filter(|row| partial.ends.at([row[1], row[2], row[3]], piles) == 0).collect();
    let column = |place: usize| kept.iter().map(|row| row[place]).collect::<Vec<f64>>();
    let [from, to] = partial.span_s().unwrap_or_default();
    Series {
        index: 0,
        id: format!("stream from {from} s to {to} s"),
        time_s: Some(column(0)),
        rows: (0..kept.len()).collect(),
        readings: [column(1), column(2), column(3)],
        magnitude_nt: column(4),
        follows: Vec::new(),
        source: partial.source(),
        missing: partial.missing as usize,
    }
}

fn groups(windows: &[Window], model: &Model, found: &FittedState) -> Option<Groups> {
    let factors: Vec<([f64; 2], &Factor)> =
        windows.iter().map(|window| (window.span_s, &window.factor)).collect();
    Groups::of_factors(&factors, model, found)
}

/// Adds what the windows say beside the calibration.
fn seen(
    partial: &Partial,
    document: &Document,
    solved: &mut Solved,
    windows: &[Window],
    options: &FitOptions,
) -> Result<(), Error> {
    let Solved { model, found, plain, .. } = &*solved;
    let (upper, rows) = (plain.upper(), plain.rows as f64);
    let size_nt = solved.given.scales.magnitude_nt;
    let rms_nt = |state: &State| variance(model, &upper, state, rows).sqrt() * size_nt;
    // Columns ½ and F/2.
    let (half, whole) = (model.terms.count() - 2, model.terms.count() - 1);
    let product = |a: usize, b: usize| plain.product(a, b);
    let varies = product(whole, whole) - product(half, whole).powi(2) / product(half, half);
    let varies_nt = (4.0 * varies.max(0.0) / rows).sqrt() * size_nt;
    let about = |model: &Model, found: &FittedState| {
        if solved.form == WHITE {
            Groups::of_factors(&[([0.0; 2], plain)], model, found)
        } else {
            groups(windows, model, found)
        }
    };
    let parts = parts(partial, solved, windows, options);
    let mut scalar =
        seen::beside(document, solved, (rms_nt(&found.state), rms_nt), (varies_nt, about), parts)?;
    scalar.findings.extend(checks::repeats(partial.repeated, partial.rows));
    let width_s = f64::from(partial.windows.level).exp2();
    if let Some(length) = options.windows_s.filter(|length| width_s > 2.0 * length) {
        scalar.findings.push(Code::ShortWindows.said(format!(
            "windows of {width_s} s are the shortest kept for a series of this length; {length} s were requested"
        )));
    }
    solved.scalar = scalar;
    Ok(())
}

/// Windows as long as those that are asked for, or the eight at most into which they go.
fn parts(partial: &Partial, solved: &Solved, windows: &[Window], options: &FitOptions) -> Vec<Part> {
    let Solved { given, model, found, .. } = solved;
    let joined = |shift: u32| windows.chunk_by(move |one, next| one.place >> shift == next.place >> shift);
    let shift = match options.windows_s {
        Some(length) => (length.log2().ceil() - f64::from(partial.windows.level)).clamp(0.0, 62.0) as u32,
        None => {
            let rows = (seen::ROWS_PER_PARAMETER * model.parameters.len()) as u64;
            let most = (solved.scalar.rows / rows).clamp(1, seen::PARTS as u64) as usize;
            (0..62).find(|shift| joined(*shift).count() <= most).unwrap_or(62)
        }
    };
    let of = |part: &[Window]| {
        let mut all = part[0].clone();
        part[1..].iter().for_each(|window| all.join(window));
        let rows = all.factor.rows;
        let squares = variance(model, &all.factor.upper(), &found.state, rows as f64);
        let rms_nt = squares.sqrt() * given.scales.magnitude_nt;
        Part { span_s: all.span_s, rows, rms_nt, groups: groups(part, model, found) }
    };
    joined(shift).map(of).collect()
}
