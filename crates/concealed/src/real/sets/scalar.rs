//! A vector magnetometer against a scalar one: |B| of the vector less the scalar, before and after what diagnose found.

use serde_json::{Value, json};

use crate::Error;
use crate::real::by_hand::{ByHand, mismatch, plane};
use crate::real::page::{self, Page, three};
use crate::real::plot::{self, Line, Panel};
use crate::real::series::{Series, mean, rms};
use crate::real::stages::Stages;

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
    /// What the same is by plain least squares, in words, and how.
    pub by_hand: (&'a str, ByHand),
    /// Name of the plot; none without.
    pub plot: Option<&'a str>,
}

/// A level and slopes, for a field that points one way.
pub const PLANE: (&str, ByHand) = ("a level and three slopes by plain least squares", plane);

/// Readings that correcting moves by no more were not corrected.
const UNMOVED_NT: f64 = 1e-6;

/// Runs diagnose on the fitted part, corrects both parts by what it wrote, and shows what is left.
pub fn study(stages: &Stages, page: &mut Page, scalar: &Scalar) -> Result<(), Error> {
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
    let (what, by_hand) = scalar.by_hand;
    let (mut verdict, mut by_hand_fitted) = (None, f64::NAN);
    if let [Some(fitted), Some(left_out)] = parts.map(|part| by_hand(&scalar.fitted, part, scalar.offset_nt))
    {
        let row = [spread(&fitted, 0.0), spread(&left_out, 0.0), three(mean(left_out.iter().copied()))];
        rows.push(std::iter::once(what.to_string()).chain(row).collect());
        let (unseen, level_alone) = (rms(left_out), rms(before[1].iter().map(|value| value - level)));
        let word = if unseen < level_alone { "better than" } else { "no better than" };
        page.head(format!(
            "Left out, rms: level alone {} nT, {what} {} nT.",
            three(level_alone),
            three(unseen)
        ));
        by_hand_fitted = rms(fitted.iter().copied());
        verdict =
            Some(format!("By hand, what was left out is predicted {word} by the fitted part's level alone."));
    }
    let answer =
        stages.stage("diagnose", &[], vec![scalar.fitted.recording("vector-scalar", "free_run")], &given)?;
    let mut after = None;
    match &answer {
        Ok(document) => match corrected(stages, parts, document)? {
            Ok(found) => {
                let left = found.each_ref().map(|part| mismatch(part, "field", [0.0; 3]));
                if left[0].iter().zip(&before[0]).any(|(after, before)| (after - before).abs() > UNMOVED_NT) {
                    let row =
                        [spread(&left[0], 0.0), spread(&left[1], 0.0), three(mean(left[1].iter().copied()))];
                    rows.push(
                        std::iter::once("corrected by what diagnose wrote".to_string()).chain(row).collect(),
                    );
                    after = Some(left);
                }
            }
            Err(words) => page.refused("correct", &words),
        },
        Err(words) => page.refused("diagnose", words),
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
    if let Some(verdict) = verdict {
        page.say(verdict);
    }
    if let Ok(document) = &answer {
        let refit = document["diagnosis"][0]["fit"]["rms_refitted_nt"].as_f64().unwrap_or(f64::NAN);
        page.head(format!("`diagnose` refits to {} nT: {}.", three(refit), page::verdict(document)));
        if let Some(fault) = fault(refit, rms(before[0].iter().copied()), by_hand_fitted) {
            page.head(fault);
            page.say(fault);
        }
        page.diagnosis(document);
        if after.is_none() {
            page.say("It wrote no other calibration: what it says of readings left out is its own count.");
        }
    }
    if let Some(name) = scalar.plot {
        let curve = |values: &[Vec<f64>; 2], label: &str, level: f64| Line {
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
        let mut lines = vec![curve(&before, "the fitted part's level taken off", level)];
        lines.extend(after.map(|after| curve(&after, "corrected by what diagnose wrote", 0.0)));
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

/// What is wrong with a refit, where something is: it is worse than what came, or so much better than plain least squares that only
/// sensitivities of nothing reach it (k = 0 with an offset as long as the field leaves no residual at all).
fn fault(refit_nt: f64, before_nt: f64, by_hand_nt: f64) -> Option<&'static str> {
    if refit_nt > 1.01 * before_nt {
        return Some("The refit is worse than what came: a fault of the program and no finding.");
    }
    let collapsed = refit_nt < 0.1 * by_hand_nt;
    collapsed.then_some("The refit has switched the instrument off (no sensitivity, an offset as long as the field): a fault of the program and no finding.")
}

/// Both parts as `correct` has their field by a document's calibration and model, with the scalar beside it.
fn corrected(
    stages: &Stages,
    parts: [&Series; 2],
    document: &Value,
) -> Result<Result<[Series; 2], String>, Error> {
    let written = ["calibration", "model"].into_iter().filter(|key| !document[key].is_null());
    let known: Value = written.map(|key| (key.to_string(), document[key].clone())).collect();
    let mut fields = Vec::new();
    for part in parts {
        match stages.stage("correct", &[], vec![part.recording("vector-scalar", "free_run")], &known)? {
            Ok(document) => fields.extend(Series::of(&document)),
            Err(words) => return Ok(Err(words)),
        }
    }
    Ok(<[Series; 2]>::try_from(fields).map_err(|_| "no field was written".to_string()))
}

#[cfg(test)]
mod tests {
    use super::fault;

    #[test]
    fn refits_that_cannot_be_right_are_called_so() {
        assert_eq!(fault(150.0, 2800.0, 154.0), None);
        assert!(fault(49_091.0, 9906.0, 1180.0).is_some_and(|words| words.contains("worse")));
        assert!(fault(0.0, 12_894.0, 2964.0).is_some_and(|words| words.contains("switched")));
        assert_eq!(fault(0.05, 76.0, f64::NAN), None);
    }
}
