//! A vector magnetometer against a scalar one: the length of the vector less the scalar, before and after
//! what diagnose found.

use serde_json::{Value, json};

use super::turned::{UNDETERMINED, within};
use crate::Error;
use crate::by_hand::{ByHand, mismatch, plane};
use crate::page::{self, Page, array, plus_minus, three};
use crate::plot::{self, Line, Panel};
use crate::prediction::Prediction;
use crate::series::{Series, mean, rms};
use crate::split::Split;
use crate::stages::Stages;

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
    /// Which part of the set this is, in words; empty where the set has one.
    pub of: &'a str,
}

/// A level and slopes, for a field that points one way.
pub const PLANE: (&str, ByHand) = ("a level and three slopes by plain least squares", plane);

/// Readings that correcting moves by no more were not corrected.
const UNMOVED_NT: f64 = 1e-6;

/// Length of the vector less scalar under one explanation, nT, of the fitted part and of the one that was
/// left out.
struct Left {
    what: String,
    nt: [Vec<f64>; 2],
}

impl Left {
    fn rms(&self, part: usize) -> f64 {
        rms(self.nt[part].iter().copied())
    }

    fn row(&self) -> Vec<String> {
        let level = mean(self.nt[1].iter().copied());
        vec![self.what.clone(), three(self.rms(0)), three(self.rms(1)), three(level)]
    }
}

/// Runs diagnose on the fitted part, corrects both parts by what it wrote, and shows what is left.
pub fn study(stages: &Stages, page: &mut Page, scalar: &Scalar) -> Result<(), Error> {
    let offsets = ["x", "y", "z"].into_iter().zip(scalar.offset_nt);
    let sensors: Value = offsets.map(|(axis, nt)| (axis.to_string(), json!({"offset_nt": nt}))).collect();
    let given = json!({"calibration": {"sensors": sensors}});
    let parts = [&scalar.fitted, &scalar.left_out];
    let came = parts.map(|part| mismatch(part, "sensor", scalar.offset_nt));
    let level = mean(came[0].iter().copied());
    let off = came.each_ref().map(|nt| nt.iter().map(|value| value - level).collect());
    let mut all = vec![
        Left { what: "as it came".into(), nt: came },
        Left { what: "the fitted part's level taken off".into(), nt: off },
    ];
    let (what, by_hand) = scalar.by_hand;
    let found = parts.map(|part| by_hand(&scalar.fitted, part, scalar.offset_nt));
    if let [Some(fitted), Some(left_out)] = found {
        all.push(Left { what: what.into(), nt: [fitted, left_out] });
    }
    let by_hand = all.get(2).map(|hand| [hand.rms(0), hand.rms(1)]);
    let recording = scalar.fitted.recording("vector-scalar", "free_run");
    let answer = stages.stage("diagnose", &["--refit"], vec![recording], &given)?;
    let mut programs_nt = None;
    if let Ok(document) = &answer {
        match corrected(stages, parts, document)? {
            Ok(nt) if moved(&nt[0], &all[0].nt[0]) => {
                programs_nt = Some(vec![scatter(&nt[1])]);
                all.push(Left { what: "corrected by what diagnose wrote".into(), nt });
            }
            Ok(nt) => programs_nt = Some(vec![scatter(&nt[1])]),
            Err(words) => page.refused("correct", &words),
        }
    }
    let (way, by_hand_nt) = by_hand_way(scalar, &all);
    page.predictions.push(Prediction {
        of: scalar.of.into(),
        ways: vec![way],
        by_hand_nt: vec![by_hand_nt],
        programs_nt,
        ..Prediction::default()
    });
    let [fitted, left_out] = scalar.parts;
    let head = [&format!("{fitted} (fitted)"), &format!("{left_out} (held out)")];
    page.table(
        &["length of the vector less scalar, rms, nT", head[0], head[1], "of which level"],
        &all.iter().map(Left::row).collect::<Vec<_>>(),
    );
    if let Some([_, unseen]) = by_hand {
        let alone = all[1].rms(1);
        page.head(format!("Held out, rms: level alone {} nT, {what} {} nT.", three(alone), three(unseen)));
        let word = if unseen < alone { "better than" } else { "no better than" };
        page.say(format!(
            "By hand, the held-out part is predicted {word} by the level of the fitted part alone."
        ));
    }
    match &answer {
        Ok(document) => diagnosis(page, document, &all, by_hand.map(|hand| hand[0])),
        Err(words) => page.refused("diagnose", words),
    }
    if let Some(name) = scalar.plot {
        draw(page, name, scalar, &all[1..]);
    }
    Ok(())
}

/// What data sheets of observatories' fluxgates promise: sensitivities within 0.1 %, axes within 2 mrad; and
/// how far a compensation may be off.
const SENSITIVITY: f64 = 1e-3;
const ARCSEC: f64 = 413.0;
const OFFSET_NT: f64 = 500.0;

/// scalarcal where the field points one way: as it is, and with what data sheets say.
pub fn by_scalarcal(stages: &Stages, page: &mut Page, scalar: &Scalar<'_>) -> Result<(), Error> {
    let recording = || vec![scalar.fitted.recording("vector-scalar", "free_run")];
    let known = within(SENSITIVITY, ARCSEC, scalar.offset_nt, OFFSET_NT);
    match stages.stage("scalarcal", &[], recording(), &known)? {
        Ok(_) => page.say("`scalarcal` takes the field's own changes as rotations enough."),
        Err(words) => page.refused("scalarcal", &words),
    }
    let answer = stages.stage("scalarcal", &["--known"], recording(), &known)?;
    let document = match answer {
        Ok(document) => document,
        Err(words) => {
            page.say("With `--known`, sensitivities within 0.1 %, angles within 2 mrad, offsets within 500 nT of what is stated (standard uncertainties):");
            page.refused("scalarcal", &words);
            predicted(page, None);
            return Ok(());
        }
    };
    let parts = [&scalar.fitted, &scalar.left_out];
    let nt = match corrected(stages, parts, &document)? {
        Ok(nt) => nt,
        Err(words) => {
            page.refused("correct", &words);
            return Ok(());
        }
    };
    let found = &document["calibration"]["scalar"];
    let parameters = array(&found["parameters"]).filter_map(|one| {
        Some(format!(
            "{} {}",
            one["name"].as_str()?,
            plus_minus(one["value"].as_f64()?, one["std"].as_f64()?)
        ))
    });
    let offsets: Vec<String> = parameters.filter(|words| words.starts_with("offset")).collect();
    page.say(format!(
        "With `--known`, sensitivities within 0.1 %, angles within 2 mrad, offsets within 500 nT of what is stated (standard uncertainties): {} nT; the length less the scalar has an rms of {} nT where it was \
         fitted, and scatters by {} nT in what was held out.",
        offsets.join(", "),
        three(rms(nt[0].iter().copied())),
        three(scatter(&nt[1]))
    ));
    let weakest = found["weakest"]["words"].as_str().unwrap_or_default();
    page.list(
        std::iter::once(format!("shown least: {weakest}"))
            .chain(array(&found["findings"]).filter_map(|words| words.as_str().map(String::from))),
    );
    predicted(page, Some(vec![scatter(&nt[1])]));
    Ok(())
}

/// Beside the prediction by diagnose that of scalarcal, by the same way by hand.
fn predicted(page: &mut Page, programs_nt: Option<Vec<f64>>) {
    let Some(last) = page.predictions.last().cloned() else { return };
    let of = "scalarcal --known".into();
    let why = if programs_nt.is_none() { UNDETERMINED.into() } else { String::new() };
    page.predictions.push(Prediction { of, programs_nt, why, ..last });
}

/// What diagnose says, and what is wrong with its refit.
fn diagnosis(page: &mut Page, document: &Value, all: &[Left], by_hand_nt: Option<f64>) {
    let refit = document["diagnosis"][0]["fit"]["rms_refitted_nt"].as_f64().unwrap_or(f64::NAN);
    page.head(format!("`diagnose` refits to {} nT: {}.", three(refit), page::verdict(document)));
    if let Some(fault) = fault(refit, all[0].rms(0), by_hand_nt.unwrap_or(f64::NAN)) {
        page.head(fault);
        page.say(fault);
    }
    page.diagnosis(document);
    if !all.iter().any(|left| left.what.starts_with("corrected")) {
        page.say("It wrote no other calibration: what it says of readings held out is its own count.");
    }
}

/// What is wrong with a refit, where something is: it is worse than what came, or so much better than plain
/// least squares that only sensitivities of nothing reach it (k = 0 with an offset as long as the field
/// leaves no residual at all).
fn fault(refit_nt: f64, came_nt: f64, by_hand_nt: f64) -> Option<&'static str> {
    if refit_nt > 1.01 * came_nt {
        return Some("The refit is worse than what came: a fault of the program and no finding.");
    }
    let collapsed = refit_nt < 0.1 * by_hand_nt;
    collapsed.then_some(
        "The refit has switched the instrument off (no sensitivity, an offset as long as the field): a fault of the program and no finding.",
    )
}

/// The level alone or the constants by hand: what predicts the last third of the fitted part better from its
/// first two thirds, and the scatter that it leaves of what was left out.
fn by_hand_way(scalar: &Scalar<'_>, all: &[Left]) -> (String, f64) {
    let (what, by_hand) = scalar.by_hand;
    let Split { fitted, left_out } = Split::share(&scalar.fitted, 2.0 / 3.0);
    let alone = scatter(&mismatch(&left_out, "sensor", scalar.offset_nt));
    let with = by_hand(&fitted, &left_out, scalar.offset_nt).map(|left| scatter(&left));
    match all.iter().find(|left| left.what == what) {
        Some(found) if with.is_some_and(|with| with < alone) => (what.into(), scatter(&found.nt[1])),
        _ => ("the level alone".into(), scatter(&all[1].nt[1])),
    }
}

/// Standard deviation about the own mean.
fn scatter(values: &[f64]) -> f64 {
    let level = mean(values.iter().copied());
    rms(values.iter().map(|value| value - level))
}

fn moved(after: &[f64], before: &[f64]) -> bool {
    after.iter().zip(before).any(|(after, before)| (after - before).abs() > UNMOVED_NT)
}

/// What is left of both parts as `correct` has their field by a document's calibration and model; its words
/// where it refuses.
fn corrected(
    stages: &Stages,
    parts: [&Series; 2],
    document: &Value,
) -> Result<Result<[Vec<f64>; 2], String>, Error> {
    let written = ["calibration", "model"].into_iter().filter(|key| !document[key].is_null());
    let known: Value = written.map(|key| (key.to_string(), document[key].clone())).collect();
    let mut left = [Vec::new(), Vec::new()];
    for (part, left) in parts.into_iter().zip(&mut left) {
        match stages.stage("correct", &[], vec![part.recording("vector-scalar", "free_run")], &known)? {
            Ok(document) => *left = mismatch(&Series::of(&document).unwrap_or_default(), "field", [0.0; 3]),
            Err(words) => return Ok(Err(words)),
        }
    }
    Ok(Ok(left))
}

fn draw(page: &mut Page, name: &str, scalar: &Scalar, all: &[Left]) {
    let parts = [&scalar.fitted, &scalar.left_out];
    let hours = |part: &Series| -> Vec<f64> {
        let start = part.start_s - scalar.fitted.start_s;
        part.column("time_s").iter().map(|t| (t + start) / 3600.0).collect()
    };
    let curve = |left: &Left| {
        let points =
            parts.iter().zip(&left.nt).flat_map(|(part, nt)| hours(part).into_iter().zip(nt.clone()));
        Line { label: left.what.clone(), points: points.collect() }
    };
    let panel = Panel { y: "nT".into(), lines: all.iter().map(curve).collect() };
    let title = format!(
        "vector less scalar; from the dashed line on ({}) it was held out of the fit",
        scalar.parts[1]
    );
    let from = hours(&scalar.left_out).first().copied();
    page.plot(name, plot::svg(&title, "time, h", &[panel], from), "mismatch before and after");
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
