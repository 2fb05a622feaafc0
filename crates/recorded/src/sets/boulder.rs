//! Boulder: the observatory's own matrix, and its fluxgate against its scalar magnetometer.

use serde_json::json;

use super::scalar::{self, PLANE, Scalar};
use crate::Error;
use crate::affine::{Affine, rms_of_each, scatter_of_each};
use crate::by_hand_pair;
use crate::known::KnownFact;
use crate::page::{Page, plus_minus, three};
use crate::prediction::Prediction;
use crate::series::{Series, length, mean, rms};
use crate::split::Split;
use crate::stages::Stages;

const DAY_S: f64 = 86_400.0;
/// Standard uncertainty of the difference of two readings that are each printed to 0.01 nT.
const PRINTED_NT: f64 = 0.0041;
/// What is left by no more than this is the rounding.
const ROUNDED: f64 = 1.1;

/// Readings as the fluxgate gave them (`reference_*_nt`) and as the observatory adjusted them (`test_*_nt`).
fn both(stages: &Stages) -> Result<Series, Error> {
    let read = |name: &str| stages.ingest(&[stages.file(&format!("usgs-bou-2016-01/{name}"))?], None);
    let raw = read("BOU201601vmin.min")?.only(|name| name != "reference_nt").renamed("sensor", "reference");
    let adjusted = read("BOU201601adj.min")?.only(|name| name != "reference_nt").renamed("sensor", "test");
    Ok(raw.joined(&adjusted))
}

/// The observatory published raw and adjusted minutes: between them is one matrix, which diffmag must give
/// back.
pub fn published(stages: &Stages) -> Result<Page, Error> {
    let split = Split::share(&both(stages)?.complete(), 0.5);
    let mut page = Page::default();
    page.say(
        "The survey publishes January 2016 twice: as read by the fluxgate (H, E, Z), and adjusted to X, Y, Z by its own affine matrix from \
        absolute measurements. The second is computed from the first, so that `diffmag` must find that matrix, with no residual but the \
        rounding to 0.01 nT.",
    );
    let recording = split.fitted.recording("adjusted", "differential");
    match stages.stage("diffmag", &[], vec![recording], &json!({}))? {
        Err(words) => page.refused("diffmag", &words),
        Ok(document) => {
            let Some(found) = Affine::found(&document) else { return Ok(page) };
            let left =
                |part: &Series| rms_of_each(&found.differences(part)).map(|nt| format!("{nt:.4}")).join("; ");
            let unseen = rms_of_each(&found.differences(&split.left_out));
            let by_hand = by_hand_pair::best(&|_| split.fitted.clone(), &|_| split.left_out.clone());
            page.predictions.push(Prediction {
                ways: by_hand.words.to_vec(),
                by_hand_nt: by_hand.scatter_nt.to_vec(),
                programs_nt: Some(scatter_of_each(&found.differences(&split.left_out)).to_vec()),
                ..Prediction::default()
            });
            page.known.push(KnownFact {
                from: "the survey's notes",
                what: "adjusted data are raw data times one matrix, rounded to 0.01 nT",
                stage: "diffmag",
                answer: format!("a matrix that leaves {} nT where it was not fitted", left(&split.left_out)),
                found: unseen.iter().all(|nt| *nt < ROUNDED * PRINTED_NT),
            });
            let elements = &document["calibration"]["differential"]["fit"]["elements"];
            let element = |i: &str, j: &str| {
                let element = &elements[format!("{i}{j}")];
                let (value, std) = (element["weighted"].as_f64(), element["weighted_std"].as_f64());
                value.zip(std).map_or("unknown".into(), |(value, std)| plus_minus(value, std))
            };
            let rows: Vec<Vec<String>> = ["x", "y", "z"]
                .iter()
                .map(|j| {
                    std::iter::once(format!("adjusted {j}"))
                        .chain(["x", "y", "z"].map(|i| element(i, j)))
                        .collect()
                })
                .collect();
            page.table(&["", "from H", "E", "Z"], &rows);
            page.head(format!(
                "The survey's matrix comes back; what was held out is met to {} nT, the rounding.",
                left(&split.left_out)
            ));
            page.say(format!(
                "Left (rms of x; y; z): {} nT in the first half, {} nT in the second, which was held out; two roundings make {PRINTED_NT}.",
                left(&split.fitted),
                left(&split.left_out)
            ));
        }
    }
    page.undecided(
        "whether the survey's matrix is correct: it is reproduced here, not tested; the next section tests it.",
    );
    Ok(page)
}

/// Twenty days fitted, nine left out; beside the survey's own answer.
pub fn month(stages: &Stages) -> Result<Page, Error> {
    let read = |name: &str| stages.ingest(&[stages.file(&format!("usgs-bou-2016-01/{name}"))?], None);
    let means = |series: Series| Split::at(&series.complete().means(600.0), 20.0 * DAY_S);
    let raw = means(read("BOU201601vmin.min")?);
    let mut page = Page::default();
    page.say("A fluxgate (H, E, Z) and an independent scalar magnetometer, means of ten minutes, January 2016. Only the readings are given.");
    let adjusted = means(read("BOU201601adj.min")?);
    let scalar = Scalar {
        fitted: raw.fitted,
        left_out: raw.left_out,
        parts: ["1 to 20 January", "21 to 29 January"],
        offset_nt: [0.0; 3],
        by_hand: PLANE,
        plot: Some("real-boulder-2016.svg"),
        of: "",
    };
    scalar::study(stages, &mut page, &scalar)?;
    scalar::by_scalarcal(stages, &mut page, &scalar)?;
    let own = |part: &Series| -> Vec<f64> {
        let total = part.vectors("sensor").into_iter().map(length);
        total.zip(part.column("reference_nt")).map(|(total, reference)| total - reference).collect()
    };
    let (fitted, left_out) = (own(&adjusted.fitted), own(&adjusted.left_out));
    let level = mean(fitted.iter().copied());
    let about = |values: &[f64]| three(rms(values.iter().map(|value| value - level)));
    page.say(format!(
        "The survey's own adjusted data, made with absolute measurements, mismatch their scalar by {} nT on average and scatter by {} nT in the same first part and {} in \
         the second (that level taken off).",
        three(level),
        about(&fitted),
        about(&left_out)
    ));
    page.undecided(UNDECIDED);
    Ok(page)
}

/// Four days fitted, three with a storm left out.
pub fn storm(stages: &Stages) -> Result<Page, Error> {
    let series = stages.ingest(&stages.files("usgs-bou-2014-11", ".min")?, None)?;
    let split = Split::at(&series.complete().means(300.0), 4.0 * DAY_S);
    let mut page = Page::default();
    page.say(
        "The same observatory in another state of the instruments (H and D), means of five minutes, 1 to 7 November 2014; the days before the \
         storm are fitted, those from the 5th on held out.",
    );
    let scalar = Scalar {
        fitted: split.fitted,
        left_out: split.left_out,
        parts: ["1 to 4 November", "5 to 7 November"],
        offset_nt: [0.0; 3],
        by_hand: PLANE,
        plot: Some("real-boulder-2014.svg"),
        of: "",
    };
    scalar::study(stages, &mut page, &scalar)?;
    scalar::by_scalarcal(stages, &mut page, &scalar)?;
    page.undecided(UNDECIDED);
    Ok(page)
}

const UNDECIDED: &str = "the orientation of the vector instrument (a rotation does not change |B|); which of nine constants is wrong, since \
        the direction of the field is constant for the whole month and only their sum along it is observable; which of the two instruments \
        drifts, and whether temperature is the cause, which is not in the files; the difference of the field between two piers.";
