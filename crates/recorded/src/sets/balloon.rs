//! Two magnetometers on a balloon: the colder it gets, the farther they are apart.

use serde_json::{Value, json};

use super::pair::Drift;
use crate::Error;
use crate::affine::{Affine, least_squares, rms_of_each, scatter_of_each};
use crate::by_hand_pair;
use crate::known::KnownFact;
use crate::page::{Page, array, three, verdict};
use crate::prediction::Prediction;
use crate::series::{Series, length};
use crate::split::Split;
use crate::stages::Stages;

const MAPPING: &str = include_str!("../../../../fixtures/real/balloon-pair.json");
/// Readings beyond it are faults of the logger: the Earth's field is 53 µT here, and steel on the ground made
/// 89 µT of it.
const WILD_NT: f64 = 200_000.0;
/// Free flight: from the launch, when the steel was left behind, to the last row but those that follow the
/// release.
const FLIGHT_S: std::ops::Range<f64> = 3300.0..6900.0;
/// Means over so much: the vehicle turns in tens of seconds, and the two are read some ms apart.
const STEP_S: f64 = 4.0;

/// A slope counts where it exceeds so many of its standard uncertainties.
const SURE: f64 = 5.0;

/// What may explain the difference besides the matrix.
type Follows = (&'static str, fn(&Series) -> Vec<Vec<f64>>);

const EXPLANATIONS: [Follows; 4] = [
    ("the matrix alone", |_| Vec::new()),
    ("with a line in the temperature", |s| vec![s.column("sensor_temperature_c").to_vec()]),
    ("with a line in the time", |s| vec![hours(s)]),
    ("with a parabola in the time", |s| vec![hours(s), hours(s).iter().map(|h| h * h).collect()]),
];

fn hours(series: &Series) -> Vec<f64> {
    series.column("time_s").iter().map(|t| t / 3600.0).collect()
}

fn columns(series: &Series, further: fn(&Series) -> Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![1.0; series.rows()]];
    columns.extend(["x", "y", "z"].map(|axis| series.column(&format!("reference_{axis}_nt")).to_vec()));
    columns.extend(further(series));
    columns
}

/// Fits on the way into the cold, predicts the way back, by four explanations; then asks diagnose.
pub fn run(stages: &Stages) -> Result<Page, Error> {
    let file = stages.file("mxl-balloon-2025-02-22a/flight_part1.csv")?;
    let all = stages.ingest(&[file], Some(MAPPING))?;
    let (time, vectors) = (all.column("time_s").to_vec(), all.vectors("reference"));
    let wild = vectors.iter().filter(|vector| length(**vector) > WILD_NT).count();
    let flight = all.filter(|row| FLIGHT_S.contains(&time[row]) && length(vectors[row]) <= WILD_NT);
    let means = flight.means(STEP_S);
    let temperature = means.column("sensor_temperature_c");
    let coldest = temperature.iter().copied().enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
    let (turn, coldest_c) = coldest.unwrap_or((0, f64::NAN));
    let split = Split::at(&means, means.column("time_s")[turn] - 300.0);

    let mut page = Page::default();
    page.say(format!(
        "An RM3100 (reference) and the AK09916 of an ICM-20948 (test) side by side on a vehicle that turns freely; means of {STEP_S} s from the launch \
         on, {wild} wild readings of the whole flight left out. The die cools from {} to {} °C and warms to {} °C again, so that \
         temperature and time part: what was before is fitted, to 5 minutes short of the coldest moment; what came after is held out.",
        three(temperature[0]),
        three(coldest_c),
        three(temperature[temperature.len() - 1]),
    ));
    page.head("Held out, rms of x; y; z in nT:");
    let mut rows = Vec::new();
    let mut slopes = String::new();
    for (what, further) in EXPLANATIONS {
        let mut coefficients = Vec::new();
        for axis in ["x", "y", "z"] {
            let y = split.fitted.column(&format!("test_{axis}_nt"));
            let found = least_squares(&columns(&split.fitted, further), y);
            coefficients.push(found.unwrap_or_default());
        }
        let left = |part: &Series| {
            let columns = columns(part, further);
            let tests = part.vectors("test");
            let residual = |row: usize| {
                let predicted = |k: usize| -> f64 {
                    columns.iter().zip(&coefficients[k]).map(|(column, c)| c * column[row]).sum()
                };
                [0, 1, 2].map(|k| tests[row][k] - predicted(k))
            };
            rms_of_each(&(0..part.rows()).map(residual).collect::<Vec<_>>())
        };
        let each = |part: &Series| left(part).map(three).join("; ");
        page.head(format!("{what} {};", each(&split.left_out)));
        rows.push(vec![what.to_string(), each(&split.fitted), each(&split.left_out)]);
        if what.ends_with("temperature") {
            slopes = coefficients
                .iter()
                .filter_map(|c| c.last())
                .map(|c| three(*c))
                .collect::<Vec<_>>()
                .join("; ");
        }
    }
    page.say("By least squares of this page's own, rms of x; y; z in nT:");
    page.table(&["explanation", "cooling (fitted)", "coldest and warming (held out)"], &rows);
    page.say(format!(
        "The temperature of the die predicts what was held out, and time does not: {slopes} nT/K in x; y; z. What is left is some counts of the AK09916 \
         (150 nT each) in the fit, and more on the way back, so a line is not all of it."
    ));
    let fitted = split.fitted.recording("flight", "differential");
    let answer = stages.stage("diffmag", &[], vec![fitted], &json!({}))?;
    let programs_nt = answer.as_ref().ok().and_then(|document| {
        let left = Affine::found(document)?.differences(&split.left_out);
        let drift = Drift::found(document, split.fitted.column("time_s"));
        Some(scatter_of_each(&drift.without(&split.left_out, left)).to_vec())
    });
    match &answer {
        Ok(document) => page.say(format!(
            "`diffmag`, fitted to the same part, answers: {}.",
            document["calibration"]["differential"]["fit"]["answer"].as_str().unwrap_or("nothing")
        )),
        Err(words) => page.refused("diffmag", words),
    }
    let by_hand = by_hand_pair::best(&|_| split.fitted.clone(), &|_| split.left_out.clone());
    page.predictions.push(Prediction {
        ways: by_hand
            .words
            .iter()
            .zip(["x", "y", "z"])
            .map(|(words, axis)| format!("{axis}: {words}"))
            .collect(),
        by_hand_nt: by_hand.scatter_nt.to_vec(),
        programs_nt,
        ..Prediction::default()
    });
    let answer =
        stages.stage("diagnose", &[], vec![means.recording("flight", "differential")], &json!({}))?;
    match answer {
        Ok(document) => {
            let warm = array(&document["diagnosis"][0]["effects"]).find(|effect| {
                effect["column"].as_str().is_some_and(|column| column.contains("temperature_c"))
            });
            let follows = |axis: &&str| {
                let slope =
                    &warm.map_or(&Value::Null, |effect| &effect["parameters"])[format!("{axis}_nt_per_k")];
                let of = |key: &str| slope[key].as_f64().unwrap_or(f64::NAN);
                of("value").abs() > SURE * of("std")
            };
            let axes = ["x", "y", "z"].into_iter().filter(follows).count();
            page.known.push(KnownFact {
                from: "the balloon's way back, by least squares",
                what: "the two go apart with the temperature of the die, and not with time",
                stage: "diagnose",
                answer: format!("the readings follow the temperature in {axes} of three axes"),
                found: axes == 3,
            });
            page.head(format!("`diagnose` {}.", verdict(&document)));
            page.diagnosis(&document);
        }
        Err(words) => page.refused("diagnose", &words),
    }
    page.undecided(
        "whether the cause is the sensor's offset or a nearby current that varies with temperature (a heater, a battery that weakens in the \
        cold), since no current is recorded; how much of the difference belongs to the magnetometer that serves as the reference.",
    );
    Ok(page)
}
