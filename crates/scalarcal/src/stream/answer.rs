//! The calibration of what is kept of a long series.

use common::{Axis, Document, Noise};
use physics::Basic;
use std::collections::BTreeMap;

use super::memory;
use super::partial::Partial;
use super::windows::Window;
use crate::design::{Rows, Scales};
use crate::ends::{self, At};
use crate::factor::Factor;
use crate::fit::{FittedState, PriorRows, Sums, fit, variance};
use crate::kalman::WHITE;
use crate::known::beforehand;
use crate::model::{Model, Parameter, State};
use crate::noise::Groups;
use crate::read::{self, Series};
use crate::result::{self, Seen};
use crate::seen::{before, reference_offset};
use crate::solve;
use crate::solved::{Detail, Solved};
use crate::stability::{self, Part};
use crate::terms::{ONE, Terms};
use crate::weakest::frame;
use crate::{Error, Options, checks, declared, determined, start, words};

/// Calibrates the sensors by what is kept of a series, and writes them into a document, which states what is
/// known of instrument and facility. Its recordings are not read.
///
/// # Errors
///
/// As [`crate::run`]; a document whose model has effects, which could be taken off rows only; options that
/// need rows.
pub fn document(partial: &Partial, document: Document, options: &Options) -> Result<Document, Error> {
    adopted(partial, document, options).map_err(words::failed)
}

fn adopted(partial: &Partial, mut document: Document, options: &Options) -> Result<Document, Error> {
    let (solved, detail, windows) = solve(partial, &document, options)?;
    if options.known && result::earlier(&document, &solved) {
        let found = "a calibration by scalarcal from the same series";
        let expected = "one from another source: with --known each reading would count twice";
        return Err(Error::document("calibration.scalar.recordings", found, expected));
    }
    let seen = seen(partial, &document, &solved, &detail, &windows, options)?;
    result::adopt(&mut document, &solved, (&detail, seen), options)?;
    Ok(document)
}

/// The windows that are used, by their place.
type Places = BTreeMap<i64, Window>;

fn solve(
    partial: &Partial,
    document: &Document,
    options: &Options,
) -> Result<(Solved, Detail, Places), Error> {
    if options.robust || options.constant_magnitude || options.vector || !options.with.is_empty() {
        let message =
            "--robust, --constant-magnitude, --vector and --with need rows, which a stream does not keep";
        return Err(Error::Request(message.into()));
    }
    let adopted = physics::adopt(document).map_err(|error| error.at("model"))?;
    if !adopted.is_empty() {
        let found = "effects, which a stream cannot subtract from the readings";
        let expected = "none; correct the readings, or calibrate a document with rows";
        return Err(Error::document("model.effects", found, expected));
    }
    let (unit, source) = (partial.unit(), partial.source());
    let (windows, left_out) = used(partial);
    let columns = Terms::new(ONE + 1).count();
    let raw = Factor::joined(columns, windows.values().map(|window| &window.factor));
    if raw.rows() == 0 {
        return Err(Error::Request(
            "no row in which all three sensors and the reference were read; expected rows without a null"
                .into(),
        ));
    }
    check(partial, document, &raw)?;
    let mean_nt = raw.product(columns - 2, columns - 1) / raw.product(columns - 2, columns - 2);
    let swing = (0..3).filter_map(|axis| partial.ends.range(axis)).map(|[high, low]| 0.5 * (high - low));
    let scales = start::scales_of(document, unit, Some(mean_nt), swing.fold(0.0, f64::max));
    let model = Model::new(ONE + 1, options.reference_offset.then_some(Parameter::ReferenceOffset));
    let by = column_scales(&model.terms, &scales);
    let plain = raw.scaled(&by);
    let windows: Places = windows
        .into_iter()
        .map(|(place, one)| (place, Window { factor: one.factor.scaled(&by), ..one }))
        .collect();
    let sensor = declared::sensor_variance(document, unit, &scales);
    let reference = declared::reference_variance(document, true, &scales);
    let like = Basic::found(document, unit).mu;
    let beforehand = beforehand(document, unit, &scales, &model)?;
    let (held, known) = (PriorRows::new(), solve::used(&beforehand, options));
    let starts = start::starts(document, unit, &scales, &model, &plain)?;
    let sums = Sums { plain: &plain, sensor, reference, held: &held };
    let series = vec![sample(partial)];
    let rows = Rows { series: &series, scales, follows: vec![Vec::new()], weights: None };
    let mut found = fit(&model, &sums, &known, &starts).map_err(|error| {
        determined::short(&model, &sums, &rows, &starts, &like, options, &beforehand).unwrap_or(error)
    })?;
    let declared = declared::declared_form(document, sensor.map(|sensor| sensor + reference), &scales);
    let white = declared == Some(WHITE);
    let alone = Noise { white_rms_nt: Some(found.variance.sqrt() * scales.magnitude_nt), ..Noise::default() };
    let groups = if white { None } else { groups(&windows, &model, &found) };
    let by_rotations = found.clone();
    let averaged = groups
        .map(|groups| memory::widen(&groups, &mut found, (&held, &known), (declared, scales.magnitude_nt)))
        .transpose()?
        .flatten();
    let told = if white || averaged.is_some() { Vec::new() } else { vec![NO_MEMORY.to_string()] };
    let (form, noise) = averaged.unwrap_or((WHITE, alone));
    let residuals = rows.residuals(&model, &found.state);
    let solved = Solved {
        unit,
        scales,
        units: Vec::new(),
        effects: Vec::new(),
        noise,
        form,
        white,
        beforehand,
        known: held.iter().chain(&known).cloned().collect(),
        held,
        mu: frame(&found.state, &like),
        recordings: vec![series[0].id.clone()],
        sources: vec![source],
        rows: plain.rows(),
        missing: partial.missing,
        left_out,
        told,
        body: None,
        includes_body: true,
        vector: None,
        model,
        found,
    };
    let detail = Detail { series, residuals, follows: vec![Vec::new()], plain };
    determined::determined(&solved, &by_rotations, &detail, options)?;
    Ok((solved, detail, windows))
}

/// The windows without rows in which an output stands at the end of its range, and how many these are by
/// sensor.
fn used(partial: &Partial) -> (Places, Vec<(String, u64)>) {
    let piles = partial.ends.piles();
    let mut left_out = [0; 3];
    let mut windows = Places::new();
    for (place, at, window) in partial.windows.iter() {
        match ends::sensor(at & piles) {
            Some(axis) => left_out[axis.index()] += window.factor.rows(),
            None => {
                windows.entry(place).and_modify(|own| own.join(window)).or_insert_with(|| window.clone());
            }
        }
    }
    (windows, checks::saturated(left_out))
}

/// A reference in another unit, and sensors that read one value, or one the same as another.
fn check(partial: &Partial, document: &Document, raw: &Factor) -> Result<(), Error> {
    let (unit, terms) = (partial.unit(), Terms::new(ONE + 1));
    let name = |axis: Axis| format!("sensor_{axis}_{}", unit.suffix());
    let refused = |message: String| Err(Error::Request(message));
    let square = |a: Axis, b: Axis| {
        let place = |axis: Axis| terms.place(axis.index(), ONE).expect("a product without F");
        raw.product(place(a), place(b))
    };
    for axis in Axis::ALL {
        if let Some([high, low]) = partial.ends.range(axis.index()).filter(|_| partial.rows > 1)
            && high <= low
        {
            return refused(format!(
                "{}: found the reading {high} in all rows; expected a rotated sensor; is it connected, or did the logger freeze?",
                name(axis)
            ));
        }
    }
    for (a, b) in [(Axis::X, Axis::Y), (Axis::Y, Axis::Z), (Axis::X, Axis::Z)] {
        let apart = square(a, a) + square(b, b) - 2.0 * square(a, b);
        if raw.rows() > 1 && apart <= SAME * square(a, a) {
            return refused(format!(
                "{}: found the readings of {}; expected readings of its own; was a column copied?",
                name(b),
                name(a)
            ));
        }
    }
    let last = terms.count() - 1;
    let (mean_square, own) = (raw.product(last, last), |axis: usize| {
        raw.product(terms.place(axis, axis).expect("a product without F"), last)
    });
    // Σ F² and Σ |V|², over four each.
    let magnitude_nt = (4.0 * mean_square / raw.rows() as f64).sqrt();
    let length = (4.0 * (0..3).map(own).sum::<f64>() / raw.rows() as f64).sqrt();
    let column = if partial.source() == read::Source::Ambient { "ambient_x_nt" } else { "reference_nt" };
    let read = read::by_nominal(length, unit, document);
    read::in_units(column.into(), magnitude_nt, read)
}

/// What is said where noise with memory was not looked for.
const NO_MEMORY: &str = "correlated noise was not estimated, because there are too few rows or windows, or the noise is too large: the uncertainties assume white noise";
/// Readings are those of another sensor where they differ by less than this share of their squares.
const SAME: f64 = 1e-14;

/// What the products over 2F are times in the units of a fit.
fn column_scales(terms: &Terms, scales: &Scales) -> Vec<f64> {
    let one = |f: usize| match f {
        0..=2 => scales.sensitivity[f] / scales.magnitude_nt,
        ONE => 1.0,
        _ => 1.0 / scales.magnitude_nt,
    };
    terms.pairs().iter().map(|[f, g]| one(*f) * one(*g) * scales.magnitude_nt).collect()
}

/// The sample as a recording, without rows that are left out.
fn sample(partial: &Partial) -> Series {
    let piles: At = partial.ends.piles();
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
        source: partial.source(),
        missing: 0,
    }
}

fn groups<'a>(
    windows: impl IntoIterator<Item = (&'a i64, &'a Window)>,
    model: &Model,
    found: &FittedState,
) -> Option<Groups> {
    let factors: Vec<([f64; 2], &Factor)> =
        windows.into_iter().map(|(_, window)| (window.span_s, &window.factor)).collect();
    Groups::of_factors(&factors, model, found)
}

fn seen(
    partial: &Partial,
    document: &Document,
    solved: &Solved,
    detail: &Detail,
    windows: &Places,
    options: &Options,
) -> Result<Seen, Error> {
    let Solved { model, found, scales, .. } = solved;
    let upper = detail.plain.upper();
    let rows = detail.plain.rows() as f64;
    let rms_nt = |state: &State| variance(model, &upper, state, rows).sqrt() * scales.magnitude_nt;
    // Columns ½ and F/2.
    let (half, whole) = (model.terms.count() - 2, model.terms.count() - 1);
    let product = |a: usize, b: usize| detail.plain.product(a, b);
    let varies = product(whole, whole) - product(half, whole).powi(2) / product(half, half);
    let varies_nt = (4.0 * varies.max(0.0) / rows).sqrt() * scales.magnitude_nt;
    let mut findings: Vec<String> = checks::repeats(partial.repeated, partial.rows).into_iter().collect();
    let about = |model: &Model, found: &FittedState| {
        if solved.form == WHITE {
            Groups::of_factors(&[([0.0; 2], &detail.plain)], model, found)
        } else {
            groups(windows, model, found)
        }
    };
    let parts = parts(partial, solved, windows, options);
    if let Some(length) =
        options.windows_s.filter(|length| (partial.windows.level() as f64).exp2() > 2.0 * length)
    {
        findings.push(format!(
            "windows of {} s are the shortest kept for a series of this length; {length} s were requested",
            (partial.windows.level() as f64).exp2()
        ));
    }
    Ok(Seen {
        rms_nt: rms_nt(&found.state),
        rms_before_nt: before(document, solved).map(|state| rms_nt(&state)),
        reference_offset: reference_offset(solved, varies_nt, about)?,
        stability: stability::of(solved, parts)?,
        findings,
    })
}

/// Windows as long as those that are asked for, or the eight at most into which they go.
fn parts(partial: &Partial, solved: &Solved, windows: &Places, options: &Options) -> Vec<Part> {
    let Solved { model, found, scales, .. } = solved;
    let joined = |shift: u32| {
        let mut parts = BTreeMap::<i64, Places>::new();
        for (place, window) in windows {
            parts.entry(place >> shift).or_default().insert(*place, window.clone());
        }
        parts
    };
    let shift = match options.windows_s {
        Some(length) => (length.log2().ceil() - f64::from(partial.windows.level())).clamp(0.0, 62.0) as u32,
        None => {
            let rows = (stability::ROWS_PER_PARAMETER * model.parameters.len()) as u64;
            let most = (solved.rows / rows).clamp(1, stability::PARTS as u64) as usize;
            (0..62).find(|shift| joined(*shift).len() <= most).unwrap_or(62)
        }
    };
    let of = |places: Places| {
        let mut all: Option<Window> = None;
        for window in places.values() {
            match &mut all {
                Some(all) => all.join(window),
                None => all = Some(window.clone()),
            }
        }
        let all = all?;
        let rows = all.factor.rows();
        let squares = variance(model, &all.factor.upper(), &found.state, rows as f64);
        Some(Part {
            span_s: all.span_s,
            rows,
            rms_nt: squares.sqrt() * scales.magnitude_nt,
            groups: groups(&places, model, found),
        })
    };
    joined(shift).into_values().filter_map(of).collect()
}
