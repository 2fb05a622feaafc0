//! Two vector magnetometers side by side: diffmag's matrix, fitted on one part and held against another.

use common::{ClockDifference, Followed, Quantity};
use serde_json::{Value, json};

use crate::Error;
use crate::affine::{Affine, mean_of_each, scatter_of_each};
use crate::by_hand_pair;
use crate::page::{Page, array, plus_minus, quantity, three};
use crate::plot::{self, Line, Panel};
use crate::prediction::Prediction;
use crate::series::Series;
use crate::stages::Stages;

const AXES: [&str; 3] = ["x", "y", "z"];

/// A pair, and what of it is fitted.
#[derive(Debug)]
pub struct Pair<'a> {
    /// Readings of the reference (`reference_*_nt`) that are fitted.
    pub reference: Series,
    /// Readings of the test instrument (`test_*_nt`) that are fitted.
    pub test: Series,
    /// Readings that are left out, of both.
    pub left_out: (Series, Series),
    /// What the parts are, in words: fitted, left out.
    pub parts: [&'a str; 2],
    /// Whether the test instrument's times are corrected by what is found.
    pub correct_clock: bool,
    /// Name of the plot; none without.
    pub plot: Option<&'a str>,
    /// Why `diffmag` predicts worse than least squares by hand, where it does.
    pub why: &'static str,
}

/// Both at the test instrument's own times, whose readings stay as they are; the reference's are read where
/// it was when the test instrument's clock said `late_s` of the time more.
fn side_by_side(reference: &Series, test: &Series, late_s: impl Fn(f64) -> f64) -> Series {
    let test = test.clone().on_clock(reference.start_s);
    let stamps = test.column("time_s").to_vec();
    let moments: Vec<f64> = stamps.iter().map(|t| t - late_s(*t)).collect();
    reference.at(&moments).with("time_s", stamps).joined(&test).complete()
}

/// Runs diffmag and shows what its matrix leaves, in the fit and out of it; the document that it wrote, where
/// it did.
pub fn study(stages: &Stages, page: &mut Page, pair: &Pair) -> Result<Option<Value>, Error> {
    let recordings = vec![
        pair.reference.recording("reference", "differential"),
        pair.test.recording("test", "differential"),
    ];
    let arguments: &[&str] = if pair.correct_clock { &["--correct-clock"] } else { &[] };
    let document = match stages.stage("diffmag", arguments, recordings, &json!({}))? {
        Ok(document) => document,
        Err(words) => {
            page.refused("diffmag", &words);
            page.head("`diffmag` refuses.");
            return Ok(None);
        }
    };
    let Some(found) = Affine::found(&document) else { return Ok(None) };
    let clock = &document["calibration"]["differential"]["fit"]["clock"];
    let corrected = |key: &str| clock[key]["value"].as_f64().filter(|_| pair.correct_clock).unwrap_or(0.0);
    let (offset_s, rate) = (corrected("offset_s"), 1e-6 * corrected("rate_ppm"));
    let parts = [(&pair.reference, &pair.test), (&pair.left_out.0, &pair.left_out.1)];
    let aligned = |part: usize, late_s: f64| side_by_side(parts[part].0, parts[part].1, |_| late_s);
    let [fitted_raw, left_out_raw] = [0, 1].map(|part| aligned(part, 0.0));
    let drift = Drift::found(&document, fitted_raw.column("time_s"));
    let late_s = |t: f64| offset_s + rate * (t - drift.middle_s);
    let [fitted, left_out] = parts.map(|(reference, test)| side_by_side(reference, test, late_s));
    let levels = Affine::level(&fitted_raw);
    let [raw, unseen_raw] = [&fitted_raw, &left_out_raw].map(|series| levels.differences(series));
    let [fit, unseen] = [&fitted, &left_out].map(|series| drift.without(series, found.differences(series)));
    let by_hand = by_hand_pair::best(&|late_s| aligned(0, late_s), &|late_s| aligned(1, late_s));
    page.predictions.push(Prediction {
        ways: by_hand.words.iter().zip(AXES).map(|(words, axis)| format!("{axis}: {words}")).collect(),
        by_hand_nt: by_hand.scatter_nt.to_vec(),
        programs_nt: Some(scatter_of_each(&unseen).to_vec()),
        why: pair.why.into(),
        ..Prediction::default()
    });
    let row = |what: &str, values: [f64; 3]| -> Vec<String> {
        std::iter::once(what.to_string()).chain(values.map(three)).collect()
    };
    let [fitted_part, left_out_part] = pair.parts;
    page.table(
        &["test less reference, nT", "x", "y", "z"],
        &[
            row(&format!("{fitted_part} (fitted): scatter, levels alone"), scatter_of_each(&raw)),
            row("… with the matrix", scatter_of_each(&fit)),
            row(&format!("{left_out_part} (held out): scatter, levels alone"), scatter_of_each(&unseen_raw)),
            row("… by hand", by_hand.scatter_nt),
            row("… with the matrix", scatter_of_each(&unseen)),
            row("… its level, levels alone", mean_of_each(&unseen_raw)),
            row("… its level, by hand", by_hand.level_nt),
            row("… its level, with the matrix", mean_of_each(&unseen)),
        ],
    );
    let (alone, with) = (scatter_of_each(&unseen_raw), scatter_of_each(&unseen));
    let each = |values: [f64; 3]| values.map(three).join("; ");
    page.head(format!(
        "On {left_out_part}, held out, the matrix fitted to {fitted_part} leaves a scatter of {} nT (x; y; z); levels alone leave {} nT.",
        each(with),
        each(alone)
    ));
    let worse: Vec<&str> = (0..3).filter(|k| with[*k] >= alone[*k]).map(|k| AXES[k]).collect();
    page.say(match worse.as_slice() {
        [] => "The matrix predicts the held-out part better than levels alone in every axis.".to_string(),
        axes => format!(
            "The matrix predicts what was held out no better than levels alone in {}.",
            axes.join(" and ")
        ),
    });
    matrix(page, &document);
    if let Some(name) = pair.plot {
        let panels = panels(&levels, &found, [&fitted, &left_out]);
        let title = format!(
            "test less reference; from the dashed line on ({}) it was held out of the fit",
            pair.parts[1]
        );
        let from = left_out.column("time_s").first().map(|t| t / 3600.0);
        page.plot(name, plot::svg(&title, "time, h", &panels, from), "differences before and after");
    }
    findings(page, &document);
    Ok(Some(document))
}

/// The nine elements with the uncertainty to be quoted, and the clock.
fn matrix(page: &mut Page, document: &Value) {
    let differential = &document["calibration"]["differential"];
    let element = |i: &str, j: &str| {
        let element = &differential["fit"]["elements"][format!("{i}{j}")];
        match (element["weighted"].as_f64(), element["weighted_std"].as_f64()) {
            (Some(value), Some(std)) => plus_minus(value, std),
            _ => "unknown".into(),
        }
    };
    let rows: Vec<Vec<String>> = AXES
        .iter()
        .map(|j| {
            let offset = quantity(&differential["offset_nt"][j]);
            let elements = AXES.iter().map(|i| element(i, j));
            std::iter::once(format!("test {j}")).chain(elements).chain([offset]).collect()
        })
        .collect();
    page.table(&["", "from reference x", "y", "z", "offset, nT"], &rows);
    let clock = &differential["fit"]["clock"];
    if clock.is_object() {
        page.say(format!("Clock of the test instrument: {}.", clock_in_words(clock)));
    }
}

/// Late or early and fast or slow, with sizes.
pub fn clock_in_words(clock: &Value) -> String {
    match serde_json::from_value::<ClockDifference>(clock.clone()) {
        Ok(clock) => format!("{}, {}", clock.offset_in_words(), clock.rate_in_words()),
        Err(_) => "unknown".into(),
    }
}

/// The drift of each axis that diffmag found in the fitted part and that goes on, and the housekeeping
/// columns that it follows.
pub struct Drift {
    follows: [Vec<Followed>; 3],
    first_s: f64,
    middle_s: f64,
    axes: [DriftOf; 3],
}

#[derive(Clone, Copy, Default)]
struct DriftOf {
    nt_per_s: f64,
    amplitude_nt: f64,
    time_constant_s: f64,
}

impl Drift {
    /// Of a document that was made of readings at these times.
    pub fn found(document: &Value, time: &[f64]) -> Self {
        let axes = &document["calibration"]["differential"]["fit"]["axes"];
        let number = |value: &Value| value.as_f64().or_else(|| value["value"].as_f64()).unwrap_or(0.0);
        let of = |axis: &str| {
            let drift = &axes[axis]["drift"];
            let demanded = drift["demanded"].as_str().unwrap_or("none");
            let joint = &drift["joint"];
            let mut of = DriftOf::default();
            // What a drift that may be one is expected to bring; beside a column that is followed none is
            // fitted.
            if axes[axis]["follows"].is_null() {
                let explanations = &drift["explanations"];
                of.nt_per_s =
                    number(&explanations["drift"]) * number(&explanations["straight_nt_per_day"]) / 86_400.0;
            }
            if demanded != "none" {
                of.nt_per_s = number(&drift["straight_nt_per_day"]) / 86_400.0;
            }
            if matches!(demanded, "exponential" | "both") {
                of.nt_per_s = number(&joint["straight_nt_per_day"]) / 86_400.0;
                (of.amplitude_nt, of.time_constant_s) =
                    (number(&joint["amplitude_nt"]), number(&joint["time_constant_s"]));
            }
            of
        };
        let (first_s, last_s) = (time.first().copied().unwrap_or(0.0), time.last().copied().unwrap_or(0.0));
        let follows =
            AXES.map(|axis| serde_json::from_value(axes[axis]["follows"].clone()).unwrap_or_default());
        Self { follows, first_s, middle_s: (first_s + last_s) / 2.0, axes: AXES.map(of) }
    }

    /// What is left of differences without it.
    pub fn without(&self, series: &Series, differences: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
        let at = |t: f64, of: DriftOf| {
            let decay =
                if of.time_constant_s > 0.0 { (-(t - self.first_s) / of.time_constant_s).exp() } else { 0.0 };
            of.nt_per_s * (t - self.middle_s) + of.amplitude_nt * decay
        };
        let followed = self.follows.each_ref().map(|all| followed(series, all));
        let rows = series.column("time_s").iter().zip(differences).enumerate();
        rows.map(|(row, (t, d))| [0, 1, 2].map(|k| d[k] - at(*t, self.axes[k]) - followed[k][row])).collect()
    }
}

/// What follows housekeeping columns in each row, nT.
fn followed(series: &Series, all: &[Followed]) -> Vec<f64> {
    let mut sum = vec![0.0; series.rows()];
    let time = series.column("time_s");
    for one in all.iter().filter(|one| series.holds(&one.column)) {
        let values = series.column(&one.column);
        let Some(mut behind) = values.first().copied() else { continue };
        for row in 0..values.len() {
            if row > 0 {
                let lag_s = one.lag_s.as_ref().map_or(0.0, Quantity::value);
                let share = 1.0 - (-(time[row] - time[row - 1]) / lag_s).exp();
                behind += share * (values[row] - behind);
            }
            let apart = behind - one.at;
            let square = one.nt_per_unit2.as_ref().map_or(0.0, Quantity::value);
            sum[row] += one.nt_per_unit.value() * apart + square * apart * apart;
        }
    }
    sum
}

fn findings(page: &mut Page, document: &Value) {
    let findings: Vec<&str> = array(&document["calibration"]["differential"]["fit"]["findings"])
        .filter_map(Value::as_str)
        .collect();
    if let Some(answer) = document["calibration"]["differential"]["fit"]["answer"].as_str() {
        page.say(format!("`diffmag` answers: {answer}."));
    }
    if !findings.is_empty() {
        page.say("`diffmag` also reports:");
        page.list(findings);
    }
}

fn panels(before: &Affine, after: &Affine, parts: [&Series; 2]) -> Vec<Panel> {
    let curve = |affine: &Affine, axis: usize, label: &str| {
        let points = parts.iter().flat_map(|part| {
            let hours = part.column("time_s").iter().map(|t| t / 3600.0);
            hours.zip(affine.differences(part).into_iter().map(move |d| d[axis])).collect::<Vec<_>>()
        });
        Line { label: label.into(), points: points.collect() }
    };
    let panel = |(axis, name): (usize, &str)| Panel {
        y: format!("{name}, nT"),
        lines: vec![curve(before, axis, "levels alone"), curve(after, axis, "with the matrix")],
    };
    AXES.into_iter().enumerate().map(panel).collect()
}
