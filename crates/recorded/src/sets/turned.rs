//! Sensors that were turned by hand: scalarcal on one part, held against another by the spread of the
//! magnitude there.

use serde_json::{Value, json};

use crate::Error;
use crate::by_hand::{Shape, magnitudes};
use crate::page::{Page, three};
use crate::prediction::Prediction;
use crate::series::{Series, length, mean, rms};
use crate::split::Split;
use crate::stages::{Answer, Stages};

/// A part of a run.
#[derive(Debug)]
pub struct Part<'a> {
    /// In words.
    pub what: String,
    /// Its readings.
    pub series: &'a Series,
}

/// One part fitted, others predicted.
#[derive(Debug)]
pub struct Turned<'a> {
    /// What is fitted.
    pub fitted: Part<'a>,
    /// What is predicted.
    pub left_out: Vec<Part<'a>>,
    /// The magnitude of the field, nT, where the source states one.
    pub magnitude_nt: Option<f64>,
    /// What scalarcal may know of the sensors where their rotations are too few.
    pub known: Value,
    /// Why any calibration may predict badly; empty where nothing is known of that.
    pub why: &'static str,
}

/// What is stated of sensors, with standard uncertainties: a sensitivity of one, relative; axes at right
/// angles, arcseconds; and offsets, nT. Offsets without an uncertainty are free.
pub fn within(sensitivity: f64, arcsec: f64, offset_nt: [f64; 3], offset_std_nt: f64) -> Value {
    let sensors: Value = ["x", "y", "z"]
        .into_iter()
        .zip(offset_nt)
        .map(|(axis, nt)| {
            let stated = json!({
                "sensitivity_nt_per_nt": {"value": 1.0, "std": sensitivity},
                "offset_nt": {"value": nt, "std": offset_std_nt},
            });
            (axis.to_string(), stated)
        })
        .collect();
    let matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    json!({"calibration": {"sensors": sensors, "axes": {"sensors": {"matrix": matrix, "std_arcsec": arcsec}}}})
}

/// Adds a row for each part that is predicted, with its prediction.
pub fn study(
    stages: &Stages,
    page: &mut Page,
    turned: &Turned<'_>,
    rows: &mut Vec<Vec<String>>,
) -> Result<(), Error> {
    let (answer, how) = calibrated(stages, turned)?;
    for part in &turned.left_out {
        let (way, by_hand) = by_hand(turned.fitted.series, part.series);
        let programs = match &answer {
            Ok(document) => spread_of_corrected(stages, document, part.series)?,
            Err(words) => Err(words.clone()),
        };
        let mut row =
            vec![turned.fitted.what.clone(), part.what.clone(), format!("{way}: {}", three(100.0 * by_hand))];
        row.push(match &programs {
            Ok(spread) => three(100.0 * spread),
            Err(words) => format!("refused: {words}"),
        });
        row.push(how.clone());
        rows.push(row);
        let size = turned.magnitude_nt.unwrap_or_else(|| {
            let middle = middle(turned.fitted.series);
            mean(about(turned.fitted.series, middle))
        });
        let why = match (&answer, &programs) {
            (Ok(document), Ok(spread)) => {
                let added_nt = size * (spread.powi(2) - by_hand.powi(2)).max(0.0).sqrt();
                why(added_nt, offset_std_nt(document)).unwrap_or_else(|| turned.why.into())
            }
            (Err(words), _) if words.contains("do not determine") => UNDETERMINED.into(),
            _ => String::new(),
        };
        page.predictions.push(Prediction {
            of: format!("{} predicts {}", turned.fitted.what, part.what),
            ways: vec![way],
            by_hand_nt: vec![by_hand * size],
            programs_nt: programs.ok().map(|spread| vec![spread * size]),
            why,
        });
    }
    Ok(())
}

/// Why it may predict worse: scalarcal says that the offsets are no better known than by what is added to the
/// spread.
fn why(added_nt: f64, offset_std_nt: f64) -> Option<String> {
    (added_nt <= offset_std_nt).then(|| format!(
        "scalarcal says that an offset may be off by ± {} nT (standard uncertainty), which is more than the {} nT that the spread is worse by in the \
         sum of squares",
        three(offset_std_nt),
        three(added_nt)
    ))
}

/// Of the last two predictions, one part by another and that by the first: where one is worse and has no
/// other reason, that the two together are better, if they are.
pub fn by_turns(page: &mut Page) {
    let Some([.., first, second]) = page.predictions.get_mut(..) else { return };
    let both = |one: &Prediction| Some((*one.by_hand_nt.first()?, *one.programs_nt.as_ref()?.first()?));
    let (Some(a), Some(b)) = (both(first), both(second)) else { return };
    if a.1.hypot(b.1) < a.0.hypot(b.0) {
        for (one, other) in [(first, b), (second, a)] {
            if one.why.is_empty() {
                one.why = format!(
                    "the other way round it is {} nT by hand and {} nT by scalarcal, and the sum of the squares of both is less by scalarcal",
                    three(other.0),
                    three(other.1)
                );
            }
        }
    }
}

/// The largest standard uncertainty of an offset, nT.
fn offset_std_nt(document: &Value) -> f64 {
    let sensors = &document["calibration"]["sensors"];
    ["x", "y", "z"].iter().filter_map(|axis| sensors[*axis]["offset_nt"]["std"].as_f64()).fold(0.0, f64::max)
}

/// Why a calibration is refused.
pub const UNDETERMINED: &str = "scalarcal refuses: the rotations do not determine the calibration";

/// The heads of the table of those rows.
pub const HEADS: [&str; 5] = [
    "fitted",
    "held out",
    "best by hand: spread of the magnitude, % of its mean",
    "scalarcal and correct, %",
    "how scalarcal was run",
];

/// scalarcal as a user would run it: as it is, and where it refuses as its own words say.
fn calibrated(stages: &Stages, turned: &Turned<'_>) -> Result<(Answer, String), Error> {
    let mut recording = turned.fitted.series.recording("turned", "free_run");
    let mut arguments = Vec::new();
    match turned.magnitude_nt {
        Some(nt) => recording["conditions"]["magnitude_nt"] = json!(nt),
        None => arguments.push("--constant-magnitude"),
    }
    let alone = stages.stage("scalarcal", &arguments, vec![recording.clone()], &json!({}))?;
    let Err(words) = alone else { return Ok((alone, "as it is".into())) };
    if !words.contains("--known") {
        return Ok((Err(words), "as it is".into()));
    }
    arguments.push("--known");
    let answer = stages.stage("scalarcal", &arguments, vec![recording], &turned.known)?;
    let how = "with --known: alone it refuses, the rotations do not determine the calibration".into();
    Ok((answer, how))
}

/// Spread of the magnitude of a part that `correct` has made a field of, over its mean.
fn spread_of_corrected(
    stages: &Stages,
    document: &Value,
    part: &Series,
) -> Result<Result<f64, String>, Error> {
    let known = json!({"calibration": document["calibration"]});
    let answer = stages.stage("correct", &[], vec![part.recording("other", "free_run")], &known)?;
    Ok(answer.map(|document| {
        let field = Series::of(&document).unwrap_or_default().vectors("field");
        spread(&field.into_iter().map(length).collect::<Vec<_>>())
    }))
}

/// The way by hand that predicts the last third of the fitted part best from its first two thirds, and the
/// spread that it leaves of another part.
fn by_hand(fitted: &Series, part: &Series) -> (String, f64) {
    let Split { fitted: first, left_out: last } = Split::share(fitted, 2.0 / 3.0);
    let shapes = [None, Some(Shape::Sphere), Some(Shape::AlongAxes), Some(Shape::Full)];
    let by = |shape: Option<Shape>, fitted: &Series, part: &Series| -> Option<f64> {
        let middle = middle(fitted);
        Some(spread(&match shape {
            None => about(part, middle),
            Some(shape) => magnitudes(shape, fitted, part, middle.map(|nt| -nt))?,
        }))
    };
    let tried = shapes
        .into_iter()
        .filter_map(|shape| Some((shape, by(shape, &first, &last)?, by(shape, fitted, part)?)));
    let best = tried.min_by(|a, b| a.1.total_cmp(&b.1));
    let words = |shape: Option<Shape>| shape.map_or("the middles of the ranges", Shape::words).to_string();
    best.map_or(("nothing".into(), f64::NAN), |(shape, _, spread)| (words(shape), spread))
}

/// The middle of the readings of each sensor, nT: where iron and offsets put the centre of the sphere,
/// roughly.
pub fn middle(series: &Series) -> [f64; 3] {
    ["x", "y", "z"].map(|axis| {
        let values = series.column(&format!("sensor_{axis}_nt"));
        let (low, high) =
            values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        (low + high) / 2.0
    })
}

/// Lengths of the readings about a point, nT.
pub fn about(series: &Series, middle: [f64; 3]) -> Vec<f64> {
    series.vectors("sensor").into_iter().map(|v| length([0, 1, 2].map(|k| v[k] - middle[k]))).collect()
}

/// Standard deviation over the mean: whatever the scale is.
fn spread(magnitudes: &[f64]) -> f64 {
    let level = mean(magnitudes.iter().copied());
    rms(magnitudes.iter().map(|value| value - level)) / level
}
