//! Plans and what is asked of the directions that come of them.

use axescal::Options;
use common::{AxesCalibration, AxesDirections, Document};
use nalgebra::Matrix3;
use physics::frames::{ARCSEC, angle, matrix};

/// A plan of the fixtures.
pub fn plan(name: &str) -> simulate::Plan {
    simulate::Plan::parse(&testkit::read_fixture(&format!("plans/{name}.json"))).expect("a plan")
}

/// How its recordings are made.
pub fn procedure(plan: &mut simulate::Plan) -> &mut simulate::AxesProcedure {
    match &mut plan.procedures[0] {
        simulate::Procedure::AxesOrientation(axes) => axes,
        _ => panic!("the plan begins with the axes"),
    }
}

/// What it has recorded.
pub fn simulated(plan: &simulate::Plan) -> simulate::Campaign {
    simulate::campaign(plan).expect("simulated")
}

pub fn solved(document: Document) -> Document {
    axescal::run(document, &Options::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Why a document is refused.
pub fn refused(document: Document) -> String {
    axescal::run(document, &Options::default()).expect_err("refused").to_string()
}

pub fn axes(document: &Document) -> &AxesCalibration {
    document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref()).expect("axes")
}

/// Whether one of the findings says something.
pub fn says(document: &Document, what: &str) -> bool {
    axes(document).findings.iter().any(|finding| finding.contains(what))
}

/// The directions, as columns.
pub fn columns(part: &Option<AxesDirections>) -> Matrix3<f64> {
    matrix(&part.as_ref().and_then(|part| part.matrix).expect("a matrix"))
}

/// Those of the sensors and of the coils.
pub fn matrices(axes: &AxesCalibration) -> [Matrix3<f64>; 2] {
    [&axes.sensors, &axes.coils].map(columns)
}

/// Largest angle between directions, arcsec.
pub fn off_arcsec(found: &Matrix3<f64>, meant: &Matrix3<f64>) -> f64 {
    let off = |k: usize| angle(&found.column(k).into_owned(), &meant.column(k).into_owned()) / ARCSEC;
    (0..3).map(off).fold(0.0, f64::max)
}

/// Largest angle between the found and the true directions of sensors and coils, arcsec.
pub fn worst_arcsec(document: &Document, truth: &simulate::Truth) -> f64 {
    let meant = matrices(truth.calibration.axes.as_ref().expect("true axes"));
    let off =
        matrices(axes(document)).into_iter().zip(meant).map(|(found, meant)| off_arcsec(&found, &meant));
    off.fold(0.0, f64::max)
}
