//! Instruments turned in a field whose size is taken as constant: what |B| says of nine constants.

use super::scalar::{self, Scalar};
use super::turned::{about, middle};
use crate::Error;
use crate::by_hand::ellipsoid;
use crate::page::Page;
use crate::series::{Series, mean};
use crate::split::Split;
use crate::stages::Stages;

const MARG: &str = include_str!("../../../../fixtures/ingest/real/marg.json");
const PHONE: &str = include_str!("../../../../fixtures/ingest/real/phone.json");
const VN100: &str = include_str!("../../../../fixtures/ingest/real/vn100.json");

/// With the constant size of the field beside the readings.
fn with_size(series: &Series, size_nt: f64) -> Series {
    let rows = series.rows();
    series.clone().with("reference_nt", vec![size_nt; rows])
}

/// One run fitted, another left out.
fn study(
    stages: &Stages,
    page: &mut Page,
    runs: [&Series; 2],
    parts: [&str; 2],
    size_nt: Option<f64>,
    of: &str,
) -> Result<(), Error> {
    let centre = middle(runs[0]);
    let size = size_nt.unwrap_or_else(|| mean(about(runs[0], centre)));
    let scalar = Scalar {
        fitted: with_size(runs[0], size),
        left_out: with_size(runs[1], size),
        parts,
        offset_nt: centre.map(|nt| -nt),
        by_hand: ("an ellipsoid by plain least squares", ellipsoid),
        plot: None,
        of,
    };
    scalar::study(stages, page, &scalar)
}

/// HMC5883L: the fuller sphere fitted, the other left out.
pub fn marg(stages: &Stages) -> Result<Page, Error> {
    let read = |name: &str| {
        let file = stages.file(&format!("marg-hmc5883l-sunsided/{name}"))?;
        Ok::<_, Error>(stages.ingest(&[file], Some(MARG))?.every(8))
    };
    let mut page = Page::default();
    page.say(
        "Every eighth reading. The magnitude of the field was not measured: it is set to the mean of the readings about the middle of their \
        ranges, so that scales are relative. \
         Offsets as given are those middles.",
    );
    let (full, partial) = (read("set2_full_sphere_mag.csv")?, read("set1_tilt_sphere_mag.csv")?);
    let split = Split::share(&full, 0.6);
    page.head("*Within a run.*");
    page.say("One run, its later part held out:");
    study(
        stages,
        &mut page,
        [&split.fitted, &split.left_out],
        ["first 60 %", "last 40 %"],
        None,
        "within a run",
    )?;
    page.head("*From one run to another.*");
    page.say("One run fitted, another held out:");
    study(
        stages,
        &mut page,
        [&full, &partial],
        ["the full sphere", "the partial sphere, another run"],
        None,
        "from one run to another",
    )?;
    page.undecided(
        "the absolute scale; the orientation of the axes on the board; whether the magnitude of the field was constant wherever the board \
        was moved indoors; if not, its variation is in the constants.",
    );
    Ok(page)
}

/// Phone and VN-100, each in halves; then the runs with iron.
pub fn phone(stages: &Stages) -> Result<Page, Error> {
    let read = |name: &str, mapping: &str, every: usize| {
        let file = stages.file(&format!("phone-vn100-rotations/{name}"))?;
        let series = stages.ingest(&[file], Some(mapping))?;
        Ok::<_, Error>(series.only(|column| !column.starts_with("attitude")).every(every))
    };
    let mut page = Page::default();
    page.say(
        "About six readings a second; the magnitude of the field is set to the 52.0 µT that the authors assume.",
    );
    for (what, name, mapping, every) in [
        ("The phone by itself", "SLACleanMagnetometerUncalibrated.csv", PHONE, 4),
        ("The phone, a magnet at 7 cm", "SLA7HardMagnetometerUncalibrated.csv", PHONE, 4),
        ("The VN-100 by itself", "clearIMU.csv", VN100, 6),
        ("The VN-100, a magnet at 7 cm", "vn7Hard.csv", VN100, 6),
    ] {
        page.head(format!("*{what}.*"));
        page.say(format!("{what}:"));
        let split = Split::share(&read(name, mapping, every)?, 0.6);
        study(
            stages,
            &mut page,
            [&split.fitted, &split.left_out],
            ["first 60 %", "last 40 %"],
            Some(52_000.0),
            what,
        )?;
    }
    page.undecided(
        "the instruments' own offsets, separately from iron that rotates with them; anything based on the VN-100's attitude, which the \
        maker's filter computes from the same magnetometer; whether the magnitude of the field near a building was constant: that is an \
        assumption here, not a measurement.",
    );
    Ok(page)
}
