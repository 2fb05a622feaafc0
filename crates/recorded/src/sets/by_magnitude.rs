//! scalarcal on sensors that others turned by hand: each half of a run predicts the other, and one run
//! another.

use super::turned::{self, HEADS, Part, Turned, within};
use crate::Error;
use crate::page::Page;
use crate::series::Series;
use crate::split::Split;
use crate::stages::Stages;

const MARG: &str = include_str!("../../../../fixtures/ingest/real/marg.json");
const PHONE: &str = include_str!("../../../../fixtures/ingest/real/phone.json");
const VN100: &str = include_str!("../../../../fixtures/ingest/real/vn100.json");
const QUADROTOR: &str = include_str!("../../../../fixtures/ingest/real/quadrotor.json");
const BALLOON: &str = include_str!("../../../../fixtures/ingest/real/balloon.json");

/// What data sheets of small magnetometers promise: a sensitivity within 5 %, axes within a degree.
const SENSITIVITY: f64 = 0.05;
const ARCSEC: f64 = 3600.0;

/// What lies between the runs of the phone, and of the VN-100.
const IRON: &str = "iron or a magnet was brought near or taken away between the runs: the calibration of the one is not that of the other";

/// One instrument that was turned in several runs.
struct Instrument<'a> {
    /// Name and readings of each run.
    runs: Vec<(String, Series)>,
    /// Runs of which one is to predict the other, by number.
    pairs: &'a [[usize; 2]],
    /// The magnitude of the field, nT, where the source states one.
    magnitude_nt: Option<f64>,
    /// What happened between the runs.
    between: &'static str,
}

/// Halves of each run by turns, then pairs of runs.
fn ask(stages: &Stages, page: &mut Page, instrument: &Instrument<'_>) -> Result<(), Error> {
    let known = within(SENSITIVITY, ARCSEC, [0.0; 3], 0.0);
    let mut rows = Vec::new();
    let mut predict = |page: &mut Page, fitted: (String, &Series), left_out: (String, &Series), why| {
        let part = |(what, series)| Part { what, series };
        let turned = Turned {
            fitted: part(fitted),
            left_out: vec![part(left_out)],
            magnitude_nt: instrument.magnitude_nt,
            known: known.clone(),
            why,
        };
        turned::study(stages, page, &turned, &mut rows)
    };
    for (name, run) in &instrument.runs {
        let Split { fitted: first, left_out: second } = Split::share(run, 0.5);
        let half = |which: &str| format!("{name}, {which} half");
        predict(page, (half("first"), &first), (half("second"), &second), "")?;
        predict(page, (half("second"), &second), (half("first"), &first), "")?;
        turned::by_turns(page);
    }
    for [fitted, left_out] in instrument.pairs {
        let of = |number: &usize| (instrument.runs[*number].0.clone(), &instrument.runs[*number].1);
        predict(page, of(fitted), of(left_out), instrument.between)?;
    }
    page.table(&HEADS, &rows);
    Ok(())
}

/// The words above every table.
fn introduction(page: &mut Page, what: &str) {
    page.say(format!(
        "{what} scalarcal is run on one part, `correct` applies what it found to another, and the spread of the magnitude there is held against the best by hand: the middles \
         of the ranges, a sphere, an ellipsoid along the axes or a full one, whichever is fitted to the first two thirds of the fitted part and predicts the last third best. Where scalarcal \
         refuses, it is run again as its words say, with what data sheets of such sensors promise: 5 % of sensitivity, 1° of angle (standard uncertainties)."
    ));
}

/// HMC5883L: two runs.
pub fn marg(stages: &Stages) -> Result<Page, Error> {
    let read = |what: &str, name: &str| {
        let file = stages.file(&format!("marg-hmc5883l-sunsided/{name}"))?;
        Ok::<_, Error>((what.to_string(), stages.ingest(&[file], Some(MARG))?))
    };
    let mut page = Page::default();
    introduction(&mut page, "Nothing measured the magnitude (`--constant-magnitude`).");
    let runs = vec![
        read("full sphere", "set2_full_sphere_mag.csv")?,
        read("partial sphere", "set1_tilt_sphere_mag.csv")?,
    ];
    let instrument = Instrument { runs, pairs: &[[0, 1], [1, 0]], magnitude_nt: None, between: "" };
    ask(stages, &mut page, &instrument)?;
    page.undecided("the absolute scale, and whether the magnitude of the field was constant wherever the board was moved indoors.");
    Ok(page)
}

/// A phone and a VN-100: the run by itself and each with iron or a magnet.
pub fn phone(stages: &Stages) -> Result<Page, Error> {
    let read = |mapping: &str, what: &str, name: &str| {
        let file = stages.file(&format!("phone-vn100-rotations/{name}"))?;
        let series = stages.ingest(&[file], Some(mapping))?;
        Ok::<_, Error>((what.to_string(), series.only(|column| !column.starts_with("attitude"))))
    };
    let mut page = Page::default();
    introduction(
        &mut page,
        "The magnitude is stated as the 52.0 µT that the authors take (`conditions.magnitude_nt`).",
    );
    let phone = [
        ("phone alone", "SLACleanMagnetometerUncalibrated.csv"),
        ("phone, iron at 7 cm", "SLA7SoftMagnetometerUncalibrated.csv"),
        ("phone, magnet at 7 cm", "SLA7HardMagnetometerUncalibrated.csv"),
        ("phone, iron at 30 cm", "SLA30SoftMagnetometerUncalibrated.csv"),
        ("phone, magnet at 30 cm", "SLA30HardMagnetometerUncalibrated.csv"),
    ];
    let vn100 = [
        ("VN-100 alone", "clearIMU.csv"),
        ("VN-100, iron at 7 cm", "vn7Soft.csv"),
        ("VN-100, magnet at 7 cm", "vn7Hard.csv"),
        ("VN-100, magnet at 30 cm", "vn30Hard.csv"),
    ];
    let pairs = &[[0, 1], [1, 0], [0, 2], [2, 0], [0, 3], [3, 0], [0, 4], [4, 0]];
    for (mapping, names, pairs) in [(PHONE, &phone[..], &pairs[..]), (VN100, &vn100[..], &pairs[..6])] {
        let runs = names.iter().map(|(what, name)| read(mapping, what, name)).collect::<Result<_, _>>()?;
        let instrument = Instrument { runs, pairs, magnitude_nt: Some(52_000.0), between: IRON };
        ask(stages, &mut page, &instrument)?;
    }
    page.undecided(
        "whether the magnitude of the field was constant: the runs were made indoors or near a building, and the VN-100's readings range \
        from 36 to 68 µT. No calibration makes a varying magnitude constant.",
    );
    Ok(page)
}

/// Two magnetometers of a quadrotor, and one that was to fly on a balloon.
pub fn michigan(stages: &Stages) -> Result<Page, Error> {
    let file = stages.file("mxl-quadrotor-2021-04-23/test1_esti.csv")?;
    let both = stages.ingest(&[file], Some(QUADROTOR))?;
    let own = |instrument: &str| {
        both.clone()
            .only(|name| name == "time_s" || name.starts_with(instrument))
            .renamed(instrument, "sensor")
    };
    let file = stages.file("mxl-balloon-2025-02-22a/preflight_rotation_2025-02-12.csv")?;
    let balloon = stages
        .ingest_with(&[file], Some(BALLOON), &["--sort"])?
        .only(|name| name == "time_s" || name.starts_with("sensor"));
    let mut page = Page::default();
    introduction(&mut page, "Nothing measured the magnitude (`--constant-magnitude`). Outdoors; motors off.");
    let runs = vec![
        ("quadrotor, RM3100".to_string(), own("test")),
        ("quadrotor, autopilot".to_string(), own("reference")),
        ("balloon before the flight, RM3100".to_string(), balloon.complete()),
    ];
    let instrument = Instrument { runs, pairs: &[], magnitude_nt: None, between: "" };
    ask(stages, &mut page, &instrument)?;
    page.undecided("iron on the frame, separately from the sensors' own offsets.");
    Ok(page)
}
