//! A vector magnetometer against a scalar one: |B| of the vector less the scalar, before and after what diagnose found.

use serde_json::{Value, json};

use crate::Error;
use crate::real::page::{Page, three};
use crate::real::plot::{self, Line, Panel};
use crate::real::series::{Series, length, mean, rms};
use crate::real::session::Session;

/// A vector (`sensor_*_nt`) and a scalar (`reference_nt`) at the same moments.
#[derive(Debug)]
pub struct Scalar<'a> {
    /// What is fitted.
    pub fitted: Series,
    /// What is predicted.
    pub left_out: Series,
    /// What the parts are, in words.
    pub parts: [&'a str; 2],
    /// Offset of each sensor as its maker or logger states it, added to the readings, nT.
    pub offset_nt: [f64; 3],
    /// Name of the plot; none without.
    pub plot: Option<&'a str>,
}

/// |v + offset| − reference of each row, nT.
fn mismatch(series: &Series, quantity: &str, offset_nt: [f64; 3]) -> Vec<f64> {
    let vectors = series.vectors(quantity).into_iter();
    let total = vectors.map(|v| length([0, 1, 2].map(|k| v[k] + offset_nt[k])));
    total.zip(series.column("reference_nt")).map(|(total, reference)| total - reference).collect()
}

/// Runs diagnose on the fitted part, corrects both parts by what it wrote, and shows what is left.
pub fn study(session: &Session, page: &mut Page, scalar: &Scalar) -> Result<(), Error> {
    let offsets = ["x", "y", "z"].into_iter().zip(scalar.offset_nt);
    let sensors: Value = offsets.map(|(axis, nt)| (axis.to_string(), json!({"offset_nt": nt}))).collect();
    let given = json!({"calibration": {"sensors": sensors}});
    let parts = [&scalar.fitted, &scalar.left_out];
    let before = parts.map(|part| mismatch(part, "sensor", scalar.offset_nt));
    let level = mean(before[0].iter().copied());
    let spread = |values: &[f64], level: f64| three(rms(values.iter().map(|value| value - level)));
    let mut rows = vec![
        vec![
            "as it came".to_string(),
            spread(&before[0], 0.0),
            spread(&before[1], 0.0),
            three(mean(before[1].iter().copied())),
        ],
        vec![
            "the fitted part's level taken off".into(),
            spread(&before[0], level),
            spread(&before[1], level),
            three(mean(before[1].iter().copied()) - level),
        ],
    ];
    let answer =
        session.stage("diagnose", &[], vec![scalar.fitted.recording("vector-scalar", "free_run")], &given)?;
    let mut after = None;
    if let Ok(document) = &answer {
        let written = ["calibration", "model"].into_iter().filter(|key| !document[key].is_null());
        let known: Value = written.map(|key| (key.to_string(), document[key].clone())).collect();
        match corrected(session, parts, &known)? {
            Ok(found) => {
                let left = found.each_ref().map(|part| mismatch(part, "field", [0.0; 3]));
                rows.push(vec![
                    "corrected by what diagnose found".into(),
                    spread(&left[0], 0.0),
                    spread(&left[1], 0.0),
                    three(mean(left[1].iter().copied())),
                ]);
                after = Some(left);
            }
            Err(words) => page.refused("correct", &words),
        }
    }
    let left_out = format!("{} (left out)", scalar.parts[1]);
    page.table(
        &[
            "length of the vector less scalar, rms, nT",
            &format!("{} (fitted)", scalar.parts[0]),
            &left_out,
            "of which level",
        ],
        &rows,
    );
    match &answer {
        Ok(document) => page.diagnosis(document),
        Err(words) => page.refused("diagnose", words),
    }
    if let (Some(name), Some(after)) = (scalar.plot, after) {
        let curve = |values: [&[f64]; 2], label: &str, level: f64| Line {
            label: label.into(),
            points: parts
                .iter()
                .zip(values)
                .flat_map(|(part, values)| {
                    let start = part.start_s - parts[0].start_s;
                    let hours = part.column("time_s").iter().map(move |t| (t + start) / 3600.0);
                    hours.zip(values.iter().map(move |value| value - level)).collect::<Vec<_>>()
                })
                .collect(),
        };
        let lines = vec![
            curve([&before[0], &before[1]], "level taken off", level),
            curve([&after[0], &after[1]], "with what diagnose found", 0.0),
        ];
        let first = scalar.left_out.column("time_s").first().copied().unwrap_or(0.0);
        let from = (first + scalar.left_out.start_s - scalar.fitted.start_s) / 3600.0;
        let title = format!(
            "vector less scalar; from the dashed line on ({}) it was left out of the fit",
            scalar.parts[1]
        );
        let panel = Panel { y: "nT".into(), lines };
        page.plot(name, plot::svg(&title, "time, h", &[panel], Some(from)), "mismatch before and after");
    }
    Ok(())
}

/// Both parts as `correct` has their field, with the scalar beside it.
fn corrected(
    session: &Session,
    parts: [&Series; 2],
    known: &Value,
) -> Result<Result<[Series; 2], String>, Error> {
    let mut fields = Vec::new();
    for part in parts {
        match session.stage("correct", &[], vec![part.recording("vector-scalar", "free_run")], known)? {
            Ok(document) => fields.extend(Series::of(&document)),
            Err(words) => return Ok(Err(words)),
        }
    }
    Ok(<[Series; 2]>::try_from(fields).map_err(|_| "no field was written".to_string()))
}
