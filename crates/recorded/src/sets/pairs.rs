//! Pairs of vector magnetometers.

use serde_json::{Value, json};

use super::pair::{self, Pair};
use crate::Error;
use crate::affine::Affine;
use crate::known::KnownFact;
use crate::page::{Page, array, three};
use crate::series::{Series, length};
use crate::split::{Split, longest_part};
use crate::stages::Stages;

const DIDD: &str = include_str!("../../../../fixtures/ingest/real/didd.json");
const MESON_HALL: &str = include_str!("../../../../fixtures/real/meson-hall-pair.json");
const QUADROTOR: &str = include_str!("../../../../fixtures/ingest/real/quadrotor.json");
const DAY_S: f64 = 86_400.0;

/// What diffmag says of instruments whose filters differ.
const UNLIKE: &str = "the responses of the instruments differ";
/// What it says of a matrix that is not one.
const MOVES: &str = "the matrix is not constant";
/// Standard uncertainties beyond which an offset of a clock is one.
const SURE: f64 = 5.0;

/// What diffmag says besides its matrix.
fn findings(document: &Value) -> impl Iterator<Item = &str> {
    array(&document["calibration"]["differential"]["fit"]["findings"]).filter_map(Value::as_str)
}

/// The first finding with some words, or that there is none.
fn finding(document: &Value, words: &str) -> String {
    findings(document)
        .find(|finding| finding.contains(words))
        .map_or("nothing of it".into(), |finding| format!("“{finding}”"))
}

/// The readings of one instrument of a pair, without the other's.
fn instrument(series: &Series, name: &str) -> Series {
    series.clone().only(|column| column == "time_s" || column.starts_with(name))
}

/// The parts of two instruments before and after a moment of the reference's clock.
fn parts(reference: Series, test: Series, at_s: f64) -> [(Series, Series); 2] {
    let test = test.on_clock(reference.start_s);
    let (reference, test) = (Split::at(&reference, at_s), Split::at(&test, at_s));
    [(reference.fitted, test.fitted), (reference.left_out, test.left_out)]
}

/// Conrad: sixteen hours fitted, eight left out.
pub fn conrad(stages: &Stages) -> Result<Page, Error> {
    let read = |name: &str| stages.ingest(&[stages.file(&format!("wic-conrad-2022-08/{name}"))?], None);
    let reference = read("fge_s0252_2022-08-10_1s.csv")?.renamed("sensor", "reference");
    let test = read("lemi036_xyz_2022-08-10_1s.csv")?.renamed("sensor", "test");
    let [fitted, left_out] = parts(reference, test, 2.0 / 3.0 * DAY_S);
    let mut page = Page::default();
    page.say("FGE S0252 (reference) and LEMI-036 (test) in different buildings of the tunnel; 2022-08-10, a quiet day, one reading a second.");
    let pair = Pair {
        reference: fitted.0,
        test: fitted.1,
        left_out,
        parts: ["0 to 16 h", "16 to 24 h"],
        correct_clock: true,
        plot: Some("real-conrad.svg"),
        why: "",
    };
    let document = pair::study(stages, &mut page, &pair)?;
    if let Some(document) = &document {
        page.known.push(KnownFact {
            from: "notes of Conrad",
            what: "the LEMI passes 0.3 Hz at most, the FGE 1 Hz",
            stage: "diffmag",
            answer: finding(document, UNLIKE),
            found: findings(document).any(|words| words.contains(UNLIKE)),
        });
    }
    page.undecided(
        "which of the two is noisy (a third vector instrument would show it); to which instrument the departure from orthogonality belongs; \
        the matrix at periods of seconds, because the LEMI's filter cuts there and the day was quiet. In z, where the field hardly changed, \
        the matrix does not improve the prediction of the held-out part.",
    );
    Ok(page)
}

/// Cobenzl: eight days fitted, four left out, with the storm of the 9th and 10th among them.
pub fn cobenzl(stages: &Stages) -> Result<Page, Error> {
    let folder = "wik-cobenzl-2011-09a";
    let didd = stages.ingest(&stages.files(&format!("{folder}/didd"), ".WIK")?, Some(DIDD))?;
    let lemi = stages.ingest(&stages.files(&format!("{folder}/lemi025"), ".min")?, None)?;
    let reference = instrument(&didd, "sensor").renamed("sensor", "reference");
    let test = instrument(&lemi, "sensor").renamed("sensor", "test");
    let [fitted, left_out] = parts(reference, test, 8.0 * DAY_S);
    let mut page = Page::default();
    page.say(
        "DIDD (reference) and LEMI-025 (test), minutes of 1 to 12 September 2011 at the edge of a city. The LEMI stamps its minutes at 47 s; \
         times are corrected by what the field itself says.",
    );
    let pair = Pair {
        reference: fitted.0,
        test: fitted.1,
        left_out,
        parts: ["1 to 8 September", "9 to 12 September"],
        correct_clock: true,
        plot: Some("real-cobenzl.svg"),
        why: "",
    };
    let document = pair::study(stages, &mut page, &pair)?;
    if let Some(document) = &document {
        let clock = &document["calibration"]["differential"]["fit"]["clock"];
        let offset = &clock["offset_s"];
        let (value, std) = (offset["value"].as_f64(), offset["std"].as_f64());
        page.known.push(KnownFact {
            from: "notes of Cobenzl",
            what: "the LEMI stamps the minutes of 15 to 105 s, whose middle is 60 s, at 47 s: 13 s early",
            stage: "diffmag",
            answer: format!("the test instrument's timestamps are {}", pair::clock_in_words(clock)),
            found: value.zip(std).is_some_and(|(value, std)| value < 0.0 && -value > SURE * std),
        });
    }
    page.undecided(
        "any dependence on temperature, since the room's log is at 21.0 °C for all twelve days, in steps of half a degree; which of the two \
        changed where the level of the held-out part is not zero; whether disturbances in one instrument come from trams or from the \
        instrument.",
    );
    Ok(page)
}

/// Meson Hall: two thirds of the longest stretch fitted.
pub fn meson_hall(stages: &Stages) -> Result<Page, Error> {
    let file = stages.file("tucan-fluxgates-2019-08-09-quiet/online_data.csv")?;
    let whole = stages.ingest_with(&[file], Some(MESON_HALL), &["--sort"])?;
    let series = longest_part(&whole, 30.0);
    let split = Split::share(&series, 2.0 / 3.0);
    let mut page = Page::default();
    page.say("Fluxgates “3” (reference) and “4” (test), metres apart under a cyclotron; one reading a second for 17 minutes.");
    let both = |series: &Series| (instrument(series, "reference"), instrument(series, "test"));
    let (reference, test) = both(&split.fitted);
    let pair = Pair {
        reference,
        test,
        left_out: both(&split.left_out),
        parts: ["the first two thirds", "the last third"],
        correct_clock: false,
        plot: None,
        why: "",
    };
    let document = pair::study(stages, &mut page, &pair)?;
    let all = vec![
        instrument(&whole, "reference").recording("reference", "differential"),
        instrument(&whole, "test").recording("test", "differential"),
    ];
    if let Ok(document) = stages.stage("diffmag", &[], all, &json!({}))? {
        page.known.push(KnownFact {
            from: "notes of the Meson Hall",
            what: "the fluxgates are metres apart in a strong gradient: no common field, no one matrix",
            stage: "diffmag",
            answer: format!("of the whole run: {}", finding(&document, MOVES)),
            found: findings(&document).any(|words| words.contains(MOVES)),
        });
    }
    if let Some(found) = document.as_ref().and_then(Affine::found) {
        let lengths = [0, 1, 2].map(|j| three(length([0, 1, 2].map(|i| found.matrix[i][j]))));
        page.head(format!(
            "A test axis is {} (x; y; z) of the reference's field, where instruments in one field have 1: no calibration.",
            lengths.join("; ")
        ));
    }
    page.undecided(
        "everything: the sources of change in this hall are near, so that the two sensors are in different fields, and no matrix between \
        them is a calibration, however well it predicts the next minutes. \
         `diffmag` does not say so.",
    );
    Ok(page)
}

/// The quadrotor: the first half fitted.
pub fn quadrotor(stages: &Stages) -> Result<Page, Error> {
    let file = stages.file("mxl-quadrotor-2021-04-23/test1_esti.csv")?;
    let series = stages.ingest(&[file], Some(QUADROTOR))?;
    let split = Split::share(&series, 0.5);
    let repeated = series.vectors("reference").windows(2).filter(|pair| pair[0] == pair[1]).count();
    let both = |series: &Series| {
        (
            instrument(series, "test").renamed("test", "reference"),
            instrument(series, "reference").renamed("reference", "test"),
        )
    };
    let (reference, test) = both(&split.fitted);
    let mut page = Page::default();
    page.say(format!(
        "An RM3100 (reference) and the autopilot's magnetometer (test), turned about three axes by hand in a meadow, motors off; 24 s at 200 Hz \
         (nominal: the file's own times are ruined). The autopilot's readings are those of the row before in {repeated} of {} rows.",
        series.rows()
    ));
    let pair = Pair {
        reference,
        test,
        left_out: both(&split.left_out),
        parts: ["the first half", "the second half"],
        correct_clock: true,
        plot: None,
        why: "the first half shows a clock rate of 2.6 of its uncertainties, and the prediction carries it on into the second half; least squares with the offset of 0.013 s and no rate leave 900; 826; 882 nT",
    };
    pair::study(stages, &mut page, &pair)?;
    page.undecided(
        "whether the offsets are iron on the frame or the sensors' own (the frame turned as one piece); the clock's offset in seconds, because the \
         rate is only nominal; anything that follows temperature, which is not recorded fast enough.",
    );
    Ok(page)
}
