//! Two vector magnetometers side by side: diffmag's matrix, fitted on one part and held against another.

use serde_json::{Value, json};

use crate::Error;
use crate::affine::{Affine, mean_of_each, scatter_of_each};
use crate::page::{Page, array, plus_minus, quantity, three};
use crate::plot::{self, Line, Panel};
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
}

/// Both at the reference's times; the test instrument's readings from where its clock says `late_s` more.
fn side_by_side(reference: &Series, test: &Series, late_s: f64) -> Series {
    let times = reference.column("time_s").to_vec();
    let stamps: Vec<f64> = times.iter().map(|t| t + late_s).collect();
    let test = test.clone().on_clock(reference.start_s).at(&stamps).with("time_s", times);
    reference.joined(&test).complete()
}

/// Runs diffmag and shows what its matrix leaves, in the fit and out of it; the document that it wrote, where it did.
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
    let late_s = clock["offset_s"]["value"].as_f64().filter(|_| pair.correct_clock).unwrap_or(0.0);
    let parts = [(&pair.reference, &pair.test), (&pair.left_out.0, &pair.left_out.1)];
    let [fitted_raw, left_out_raw] = parts.map(|(reference, test)| side_by_side(reference, test, 0.0));
    let [fitted, left_out] = parts.map(|(reference, test)| side_by_side(reference, test, late_s));
    let levels = Affine::level(&fitted_raw);
    let by_parts = [(&levels, &fitted_raw), (&found, &fitted), (&levels, &left_out_raw), (&found, &left_out)];
    let [raw, fit, unseen_raw, unseen] = by_parts.map(|(affine, series)| affine.differences(series));
    let row = |what: &str, values: [f64; 3]| -> Vec<String> {
        std::iter::once(what.to_string()).chain(values.map(three)).collect()
    };
    let [fitted_part, left_out_part] = pair.parts;
    page.table(
        &["test less reference, nT", "x", "y", "z"],
        &[
            row(&format!("{fitted_part} (fitted): scatter, levels alone"), scatter_of_each(&raw)),
            row("… with the matrix", scatter_of_each(&fit)),
            row(&format!("{left_out_part} (left out): scatter, levels alone"), scatter_of_each(&unseen_raw)),
            row("… with the matrix", scatter_of_each(&unseen)),
            row("… its level, levels alone", mean_of_each(&unseen_raw)),
            row("… its level, with the matrix", mean_of_each(&unseen)),
        ],
    );
    let (alone, with) = (scatter_of_each(&unseen_raw), scatter_of_each(&unseen));
    let each = |values: [f64; 3]| values.map(three).join("; ");
    page.head(format!(
        "Of {left_out_part}, unseen, the matrix of {fitted_part} leaves {} nT (x; y; z, scatter); levels alone {}.",
        each(with),
        each(alone)
    ));
    let worse: Vec<&str> = (0..3).filter(|k| with[*k] >= alone[*k]).map(|k| AXES[k]).collect();
    page.say(match worse.as_slice() {
        [] => "The matrix predicts what was left out better than levels alone in every axis.".to_string(),
        axes => format!(
            "The matrix predicts what was left out no better than levels alone in {}.",
            axes.join(" and ")
        ),
    });
    matrix(page, &document);
    if let Some(name) = pair.plot {
        let panels = panels(&levels, &found, [&fitted, &left_out]);
        let title = format!(
            "test less reference; from the dashed line on ({}) it was left out of the fit",
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
        page.say(format!(
            "Clock of the test instrument: {} s late, {} ppm.",
            quantity(&clock["offset_s"]),
            quantity(&clock["rate_ppm"])
        ));
    }
}

fn findings(page: &mut Page, document: &Value) {
    let findings: Vec<&str> = array(&document["calibration"]["differential"]["fit"]["findings"])
        .filter_map(Value::as_str)
        .collect();
    if !findings.is_empty() {
        page.say("`diffmag` says besides:");
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
