//! From the recordings to the calibration.

use common::number::{counted, significant};
use common::{Axis, BodyIron, Document, Noise, VectorFit};
use faer::Mat;
use nalgebra::Matrix3;
use physics::{Basic, EffectInstance, Unit};

use crate::design::{Rows, Scales};
use crate::effects::{Following, asked, following, taken_off};
use crate::factor::Factor;
use crate::fit::{Found, Known, Sums, fit};
use crate::kalman::{Form, Memory, WHITE};
use crate::known::{Beforehand, beforehand};
use crate::linear::RANK_TOLERANCE;
use crate::model::{Model, NINE, Parameter, State};
use crate::noise::Groups;
use crate::read::{Series, Source, is_stated, read};
use crate::weakest::{UNDETERMINED, frame};
use crate::{Error, Options, checks, robust, start, weakest};

/// Rounds in which what effects follow, and what those of the model add, settle with the sensors.
const ROUNDS: usize = 3;
/// Relative standard uncertainty with which a scale that nothing shows is held.
const HELD: f64 = 1e-9;
/// A parameter more than this many times as uncertain as the mean residual counts as undetermined: small unmodelled effects would decide it.
const MOST_WEAK: f64 = 1000.0;
/// Standard uncertainties with which parameters are held where they begin, when a fit finds no minimum without.
const LOOSELY: [f64; 3] = [0.3, 0.1, 0.03];

/// A calibration with all that stands behind it.
pub struct Solved {
    /// Unit of the readings.
    pub unit: Unit,
    /// The units of the parameters.
    pub scales: Scales,
    /// The parameters.
    pub model: Model,
    /// What one unit of the state is in the unit of an effect's parameter.
    pub units: Vec<f64>,
    /// The effects that were fitted.
    pub effects: Vec<EffectInstance>,
    /// The fit.
    pub found: Found,
    /// What was known beforehand.
    pub beforehand: Beforehand,
    /// Rows of the fit for what no reading shows and is held.
    pub held: Known,
    /// Those, and the rows for what is known beforehand and used.
    pub known: Known,
    /// μ.
    pub mu: Matrix3<f64>,
    /// Noise of a residual (white) and of the sensors (with memory).
    pub noise: Noise,
    /// Its form.
    pub form: Form,
    /// Whether the noise is declared white: the factor then holds all that the rows say.
    pub white: bool,
    /// Names of the recordings.
    pub recordings: Vec<String>,
    /// Where their magnitude comes from.
    pub sources: Vec<Source>,
    /// Rows used.
    pub rows: u64,
    /// Rows that lack a reading.
    pub missing: u64,
    /// Rows left out, by the reason.
    pub left_out: Vec<(String, u64)>,
    /// What was done or assumed, in words.
    pub told: Vec<String>,
    /// The iron of the body, where the sensors' own calibration is known.
    pub body: Option<BodyIron>,
    /// Whether the calibration includes it.
    pub includes_body: bool,
    /// The field and its direction, where they were used.
    pub vector: Option<VectorFit>,
}

impl Solved {
    /// The unit of a residual, nT.
    pub fn unit_nt(&self) -> f64 {
        self.scales.magnitude_nt * self.model.scale(&self.found.state)
    }

    /// Variance of the white noise of a residual over the square of that.
    pub fn white_variance(&self) -> f64 {
        (self.noise.white_rms_nt.unwrap_or(0.0) / self.unit_nt()).powi(2)
    }
}

/// The rows of a calibration, where they are at hand.
pub struct Detail {
    /// The rows that were used, without what the effects of the model add.
    pub series: Vec<Series>,
    /// |B| − F in each row, nT.
    pub residuals: Vec<Vec<f64>>,
    /// The columns that effects follow.
    pub follows: Vec<Vec<Vec<f64>>>,
    /// The factor of their products.
    pub plain: Factor,
}

impl Detail {
    /// The rows in the units of the parameters.
    pub fn rows(&self, scales: Scales) -> Rows<'_> {
        Rows { series: &self.series, scales, follows: self.follows.clone(), weights: None }
    }

    /// The rows about a fit of a model, as they are whitened.
    pub fn groups(&self, solved: &Solved, model: &Model, found: &Found, timed: bool) -> Option<Groups> {
        if solved.white {
            return Groups::of_factors(&[([0.0; 2], &self.plain)], model, found);
        }
        Groups::of(&self.rows(solved.scales), model, found, timed)
    }

    /// Some rows of one recording.
    pub fn part(&self, solved: &Solved, number: usize, from: usize, to: usize) -> Self {
        let follows = self.follows[number].iter().map(|column| column[from..to].to_vec()).collect();
        let mut part = Self {
            series: vec![self.series[number].part(from, to)],
            residuals: vec![self.residuals[number][from..to].to_vec()],
            follows: vec![follows],
            plain: Factor::new(solved.model.terms.count()),
        };
        if solved.white {
            part.plain = part.rows(solved.scales).factor(&solved.model.terms);
        }
        part
    }
}

/// Finds the calibration.
///
/// # Errors
///
/// As [`read`] and [`fit`]; rotations that do not determine the calibration.
pub fn solve(document: &Document, options: &Options) -> Result<(Solved, Detail), Error> {
    let (unit, mut series) = read(document, options)?;
    let mut told = Vec::new();
    let mut left_out = checks::saturated(checks::without_saturated(&mut series));
    let repeated = checks::without_repeated(&mut series);
    if repeated > 0 {
        left_out.push(("the readings of the row before once more".into(), repeated as u64));
    }
    unlike(&mut series, &mut told);
    series.retain(|one| one.len() > 0);
    let constant = series.iter().all(|one| one.source == Source::Constant);
    if constant && !is_stated(document, unit) {
        let expected = "`instrument.nominal_sensitivity_nt_per_v`, or `conditions.magnitude_nt`: one of the two gives the field its scale";
        let found = "neither a sensitivity nor a magnitude, with --constant-magnitude";
        return Err(common::Error::document("instrument", found, expected).into());
    }
    if constant && series.len() > 1 {
        told.push(format!("one magnitude is assumed for all {}", counted(series.len(), "recording")));
    }
    let scales = start::scales(document, unit, &series);
    if constant {
        series.iter_mut().for_each(|one| one.magnitude_nt.fill(scales.magnitude_nt));
    }
    let effects = asked(document, options)?;
    let mut adopted =
        physics::adopt(document).map_err(|source| Error::Physics { path: "model".into(), source })?;
    // What is fitted anew is not taken off.
    adopted.retain(|one| !effects.iter().any(|other| replaces(other, one)));
    let stated = stated_magnitude(document, &series)?;
    let read = series.iter().any(|one| matches!(one.source, Source::Scalar | Source::Ambient));
    let reference = reference_variance(document, read, &scales);
    let sensor = sensor_variance(document, unit, &scales);
    let like = Basic::found(document, unit).mu;

    let more = |following: &Following| {
        let mut more = following.parameters.clone();
        if options.reference_offset && !constant {
            more.push(Parameter::ReferenceOffset);
        }
        if constant || stated.is_some() {
            more.push(Parameter::Magnitude);
        }
        more
    };
    let raw = series;
    let none = Following { parameters: Vec::new(), units: Vec::new(), columns: vec![Vec::new(); raw.len()] };
    let mut current = raw.clone();
    let mut follow = none;
    let mut last: Option<(Model, Beforehand, Found, Factor)> = None;
    let rounds = if effects.is_empty() && adopted.is_empty() { 1 } else { ROUNDS };
    for _ in 0..rounds {
        if let Some((_, _, found, _)) = &last {
            let basic = basic(&found.state, &scales, &like);
            current = taken_off(document, &raw, &basic, &adopted)?;
            follow = following(document, &current, &scales, &basic, &effects)?;
        }
        let columns = follow.columns[0].len();
        let model = Model::new(crate::terms::ONE + 1 + columns, more(&follow));
        let rows = Rows { series: &current, scales, follows: follow.columns.clone(), weights: None };
        let plain = rows.factor(&model.terms);
        let beforehand = beforehand(document, unit, &scales, &model)?;
        let held = held(&model, &beforehand, options, (constant, stated));
        let starts = match &last {
            Some((_, _, before, _)) => {
                let mut neutral = model.nominal();
                neutral[..NINE].copy_from_slice(&before.state[..NINE]);
                vec![neutral]
            }
            None => start::starts(document, unit, &scales, &model, &plain)?,
        };
        let sums = Sums { plain: &plain, sensor, reference, held: &held };
        let found = fit(&model, &sums, &used(&beforehand, options), &starts).map_err(|error| {
            short(&model, &sums, &rows, &starts, &like, options, &beforehand).unwrap_or(error)
        })?;
        last = Some((model, beforehand, found, plain));
    }
    let (model, beforehand, mut found, mut plain) =
        last.ok_or_else(|| Error::Undetermined("no rows".into()))?;
    let held = held(&model, &beforehand, options, (constant, stated));
    let known = used(&beforehand, options);
    let mut kept = current;
    let mut follows = follow.columns;
    if options.robust {
        let mut rows = Rows { series: &kept, scales, follows: follows.clone(), weights: None };
        let keep = robust::kept(&model, &mut rows, (sensor, reference), (&held, &known), &found.state)?;
        let mut count = 0;
        for ((one, columns), keep) in kept.iter_mut().zip(&mut follows).zip(&keep) {
            count += keep.iter().filter(|keep| !**keep).count() as u64;
            checks::retain(one, keep);
            for column in columns.iter_mut() {
                let mut flags = keep.iter();
                column.retain(|_| *flags.next().unwrap_or(&true));
            }
        }
        left_out.push(("far from the rest (--robust)".into(), count));
        let rows = Rows { series: &kept, scales, follows: follows.clone(), weights: None };
        plain = rows.factor(&model.terms);
        let sums = Sums { plain: &plain, sensor, reference, held: &held };
        found = fit(&model, &sums, &known, std::slice::from_ref(&found.state))?;
    }
    let rows = Rows { series: &kept, scales, follows: follows.clone(), weights: None };
    let unit_nt = scales.magnitude_nt * model.scale(&found.state);
    let alone = Noise { white_rms_nt: Some(found.variance.sqrt() * unit_nt), ..Noise::default() };
    let declared = declared_form(document, sensor.map(|sensor| sensor + reference), &scales);
    let white = declared == Some(WHITE);
    let groups = if white { None } else { Groups::of(&rows, &model, &found, true) };
    let by_rotations = found.clone();
    let averaged = groups
        .map(|groups| {
            groups.average(
                &mut found,
                (&held, &known),
                (declared.unwrap_or(WHITE), declared.is_none(), unit_nt),
            )
        })
        .transpose()?
        .flatten();
    let (form, noise) = averaged.unwrap_or((WHITE, alone));
    let residuals = rows.residuals(&model, &found.state);
    let mu = frame(&found.state, &like);
    let mut sources: Vec<Source> = kept.iter().map(|one| one.source).collect();
    sources.sort_unstable();
    sources.dedup();
    let mut solved = Solved {
        unit,
        scales,
        units: follow.units,
        effects,
        noise,
        form,
        white,
        beforehand,
        known: held.iter().chain(&known).cloned().collect(),
        held,
        mu,
        recordings: kept.iter().map(|one| one.id.clone()).collect(),
        sources,
        rows: kept.iter().map(|one| one.len() as u64).sum(),
        missing: kept.iter().map(|one| one.missing as u64).sum(),
        left_out,
        told,
        body: None,
        includes_body: true,
        vector: None,
        model,
        found,
    };
    let detail = Detail { series: kept, residuals, follows, plain };
    determined(&solved, &by_rotations, &detail, options)?;
    solved.told.extend(wandering(&solved));
    Ok((solved, detail))
}

/// The chain that a state means; its coils are none.
pub fn basic(state: &State, scales: &Scales, like: &Matrix3<f64>) -> Basic {
    let mut basic = Basic::of(&Document::default(), Unit::Nanotesla);
    basic.mu = frame(state, like);
    for axis in 0..3 {
        basic.sensors[axis].sensitivity = state[axis] * scales.sensitivity[axis];
        basic.sensors[axis].offset_nt = state[3 + axis] * scales.magnitude_nt;
    }
    basic
}

/// Whether a fitted effect takes the place of one of the model: the same of all recordings at all times.
fn replaces(fitted: &EffectInstance, one: &EffectInstance) -> bool {
    let of = |effect: &EffectInstance| {
        (effect.kind, effect.axis, effect.column.clone(), effect.recording.clone(), effect.within)
    };
    of(fitted) == of(one)
}

/// Recordings of a magnitude that is not known are of no use beside ones where it is.
fn unlike(series: &mut Vec<Series>, told: &mut Vec<String>) {
    let known = series.iter().any(|one| one.source != Source::Constant);
    let before = series.len();
    series.retain(|one| !known || one.source != Source::Constant);
    if series.len() < before {
        let left = counted(before - series.len(), "recording");
        told.push(format!("{left} without a known magnitude left out: others have one"));
    }
}

/// Relative standard uncertainty of a stated magnitude.
///
/// # Errors
///
/// Magnitudes that are stated with an uncertainty beside another reference, or several: each would need a scale of its own.
fn stated_magnitude(document: &Document, series: &[Series]) -> Result<Option<f64>, Error> {
    let of = |one: &Series| {
        let stated = document.recordings[one.index].conditions.extra.get(crate::read::MAGNITUDE)?;
        let quantity = serde_json::from_value::<common::Quantity>(stated.clone()).ok()?;
        Some((quantity.value(), quantity.relative_std()?))
    };
    let stated: Vec<Option<(f64, f64)>> = series.iter().map(of).collect();
    let Some(first) = stated.iter().flatten().next().copied() else { return Ok(None) };
    if let Some(other) = stated.iter().position(|one| *one != Some(first)) {
        let path = format!("{}.conditions.{}", series[other].path(), crate::read::MAGNITUDE);
        let found =
            "a magnitude that is stated with an uncertainty beside recordings whose magnitude is another";
        let expected =
            "one magnitude for all recordings, or none with an uncertainty; calibrate them one by one";
        return Err(common::Error::document(path, found, expected).into());
    }
    Ok(Some(first.1))
}

/// Variance of the reference over the square of the magnitude, where one was read.
pub fn reference_variance(document: &Document, read: bool, scales: &Scales) -> f64 {
    let std = document.facility.as_ref().and_then(|facility| facility.reference_std_nt).filter(|_| read);
    (std.unwrap_or(0.0) / scales.magnitude_nt).powi(2)
}

/// Variance of the declared noise along a sensor over the square of the magnitude, in the mean of the sensors.
pub fn sensor_variance(document: &Document, unit: Unit, scales: &Scales) -> Option<f64> {
    let instrument = document.instrument.as_ref()?;
    let of = |axis: Axis| instrument.noise_of(axis)?.white_rms_nt.filter(|rms| *rms > 0.0);
    let all: Vec<f64> = Axis::ALL.into_iter().filter_map(of).collect();
    let code = scales.sensitivity.map(|k| unit.code_width(Some(instrument)).map_or(0.0, |width| k * width));
    let rounding = code.iter().map(|width| width * width / 12.0).sum::<f64>() / 3.0;
    let mean = all.iter().map(|rms| rms * rms).sum::<f64>() / 3.0;
    (all.len() == 3).then(|| (mean + rounding) / scales.magnitude_nt.powi(2))
}

/// The rows for scales that nothing shows.
fn held(
    model: &Model,
    beforehand: &Beforehand,
    options: &Options,
    (constant, stated): (bool, Option<f64>),
) -> Known {
    let mut rows = Known::new();
    if let Some(place) = model.place(&Parameter::Magnitude) {
        let mut weights = vec![0.0; model.parameters.len()];
        match stated {
            Some(std) => {
                weights[place] = 1.0 / std;
                rows.push((weights, 1.0 / std));
            }
            // Only the ratio of magnitude and sensitivities is seen: the mean sensitivity is held at what is known of it.
            None if constant && !options.known => {
                let mean = beforehand.nine[..3].iter().sum::<f64>() / HELD;
                weights[..3].fill(1.0 / HELD);
                rows.push((weights, mean));
            }
            None => {}
        }
    }
    rows
}

/// The largest standard uncertainty of a parameter that is determined.
fn most(found: &Found, rows: u64) -> f64 {
    // A mean of all rows has the uncertainty s/√n.
    UNDETERMINED.min(MOST_WEAK * (found.variance / rows as f64).sqrt())
}

/// That the rotations determine every parameter, by what is left as if it were white: of an offset that wanders they say no more, but that is no
/// fault of theirs.
pub fn determined(
    solved: &Solved,
    by_rotations: &Found,
    detail: &Detail,
    options: &Options,
) -> Result<(), Error> {
    let (model, found) = (&solved.model, by_rotations);
    // A scale of sensors and field together, where that of the field is a parameter, is as uncertain as what is known of it: the rest counts.
    let scale = model.scale(&found.state);
    let apart = Mat::from_fn(NINE, model.parameters.len(), |i, j| {
        let own = if i == j { 1.0 } else { 0.0 };
        let scaled = model.place(&Parameter::Magnitude).is_some() && i < 6 && j < 3;
        own - if scaled { found.state[i] / (3.0 * scale) } else { 0.0 }
    });
    let covariance = &apart * &found.covariance * apart.transpose();
    let worst = (0..NINE).map(|k| covariance[(k, k)]).fold(0.0, f64::max).sqrt();
    let rows = found.jacobian.nrows();
    let all = Mat::from_fn(rows + solved.known.len(), model.parameters.len(), |i, j| {
        if i < rows { found.jacobian[(i, j)] } else { solved.known[i - rows].0[j] }
    });
    let full = estimate::Svd::of(all.as_ref(), RANK_TOLERANCE)?.rank() == model.parameters.len();
    // Where the scale is that of something known, it is no better than that.
    let scaled = options.known || model.place(&Parameter::Magnitude).is_some();
    let most = if scaled { UNDETERMINED } else { most(found, solved.rows) };
    if full && worst <= most {
        return Ok(());
    }
    let rows = detail.rows(solved.scales);
    let state = &solved.found.state;
    Err(message(&solved.model, &all, &rows, state, &solved.mu, &solved.beforehand, options))
}

/// That offsets are known badly because they wander, in a sentence.
fn wandering(solved: &Solved) -> Option<String> {
    let offset = (3..6).map(|k| solved.found.covariance[(k, k)]).fold(0.0, f64::max).sqrt();
    let wanders = solved.form.of == Memory::Sensors && solved.form.ratio > 0.0;
    (wanders && offset > UNDETERMINED).then(|| {
        format!(
            "what is left changes slowly and turns with the sensors, as offsets do that wander: longer recordings of this kind make their {} nT no \
             smaller. Is there iron or a current near by, is the field another where the block was moved to, or does the instrument correct itself?",
            significant(offset * solved.scales.magnitude_nt, 2)
        )
    })
}

/// The same for a fit that found no minimum: with the parameters held loosely where they begin there is one, and it says what the
/// readings do not.
pub fn short(
    model: &Model,
    sums: &Sums<'_>,
    rows: &Rows<'_>,
    starts: &[State],
    like: &Matrix3<f64>,
    options: &Options,
    beforehand: &Beforehand,
) -> Option<Error> {
    if sums.plain.rows() <= model.parameters.len() as u64 {
        return None;
    }
    let loosely = |place: usize, std: f64| {
        let mut weights = vec![0.0; model.parameters.len()];
        weights[place] = 1.0 / std;
        (weights, starts[0][place] / std)
    };
    let held =
        |std: &f64| -> Known { (0..model.parameters.len()).map(|place| loosely(place, *std)).collect() };
    let found = LOOSELY.iter().find_map(|std| fit(model, sums, &held(std), starts).ok());
    let (state, jacobian, most) = match found {
        Some(found) => (found.state.clone(), found.jacobian.clone(), most(&found, sums.plain.rows())),
        // Not even those are found: the derivatives where they begin, and what is left when they are followed.
        None => linear(model, sums.plain, &starts[0])?,
    };
    let (least, _) = weakest::least(&(jacobian.transpose() * &jacobian))?;
    let mu = frame(&state, like);
    (least < most.powi(-2)).then(|| message(model, &jacobian, rows, &state, &mu, beforehand, options))
}

/// Linear least squares at a state: the state, its derivatives over the standard deviation of what they leave, and the largest standard uncertainty of
/// a parameter that is determined.
fn linear(model: &Model, plain: &Factor, state: &State) -> Option<(State, Mat<f64>, f64)> {
    let (coefficients, slopes) = (model.coefficients(state)?, model.slopes(state)?);
    let upper = plain.upper();
    let jacobian = &upper * slopes;
    let residual: Vec<f64> = (0..upper.nrows())
        .map(|i| (0..upper.ncols()).map(|k| upper[(i, k)] * coefficients[k]).sum())
        .collect();
    let step = estimate::Svd::of(jacobian.as_ref(), RANK_TOLERANCE).ok()?.solve(&residual);
    let left = (0..residual.len())
        .map(|i| residual[i] - (0..step.len()).map(|j| jacobian[(i, j)] * step[j]).sum::<f64>());
    let variance = left.map(|value| value * value).sum::<f64>() / plain.rows() as f64;
    let variance = variance.max(f64::MIN_POSITIVE);
    let most = UNDETERMINED.min(MOST_WEAK * (variance / plain.rows() as f64).sqrt());
    Some((state.clone(), jacobian * faer::Scale(1.0 / variance.sqrt()), most))
}

/// The form of the declared noise, where all three sensors have one; white where it has no memory.
pub fn declared_form(document: &Document, variance: Option<f64>, scales: &Scales) -> Option<Form> {
    let instrument = document.instrument.as_ref()?;
    let all: Vec<&Noise> = Axis::ALL.into_iter().filter_map(|axis| instrument.noise_of(axis)).collect();
    let white = variance? * scales.magnitude_nt.powi(2);
    let flicker = all.iter().filter_map(|noise| noise.flicker_nt2_per_hz_at_1hz).sum::<f64>() / 3.0;
    let exponent =
        all.iter().map(|noise| noise.flicker_exponent.unwrap_or(1.0)).sum::<f64>() / all.len() as f64;
    Some(if flicker > 0.0 { Form { of: Memory::Sensors, ratio: flicker / white, exponent } } else { WHITE })
}

/// What is known beforehand, where it is to be used.
pub fn used(beforehand: &Beforehand, options: &Options) -> Known {
    if options.known { beforehand.rows.clone() } else { Known::new() }
}

fn message(
    model: &Model,
    jacobian: &faer::Mat<f64>,
    rows: &Rows<'_>,
    state: &State,
    mu: &Matrix3<f64>,
    beforehand: &Beforehand,
    options: &Options,
) -> Error {
    let directions: Vec<_> =
        weakest::directions(rows, model, state, mu).into_iter().map(|(_, _, field)| field).collect();
    let found = weakest::weakest(model, state, jacobian, (&directions, rows.scales.magnitude_nt), mu);
    let (words, remedy) = found.map_or_else(
        || {
            (
                "the directions of the field do not differ".into(),
                "turn the block about all three axes".to_string(),
            )
        },
        |weakest| (weakest.words, weakest.remedy.split(": the combination").next().unwrap_or("").to_string()),
    );
    let known = match (beforehand.rows.is_empty(), options.known) {
        (true, _) => {
            "state what is known of the sensors beforehand under `calibration`, with its uncertainty, and give --known"
        }
        (false, false) => {
            "give --known, which holds what the document states of the sensors within its uncertainty"
        }
        (false, true) => {
            "state under `calibration` more of what is known of the sensors, or with a smaller uncertainty"
        }
    };
    Error::Undetermined(format!(
        "the rotations do not determine the calibration: {words}. {}; or {known}",
        capital(&remedy)
    ))
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
