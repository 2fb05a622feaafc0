//! Calibration of a vector magnetometer by the magnitude of the field while it is turned, without a facility.
//!
//! Nine parameters make the output V_i of each sensor the field along its axis, B_i = k_i V_i + O_i, and give
//! the angles between the axes. The magnitude of the vector, |B|² = bᵀ (μᵀμ)⁻¹ b, is held against a scalar
//! magnetometer, a model of the field, or a constant. A turn of all sensors together does not change it: SEN
//! is then the frame in which the sensors are nearest to where the document has them.
//!
//! J. M. G. Merayo et al., Scalar calibration of vector magnetometers, Meas. Sci. Technol. 11 (2000) 120–132.
//!
//! - `read` takes the recordings, `design` makes rows of products of them (`terms`), of any
//!   number of rows as a triangular factor. `model` gives the coefficients of the products as a function of the parameters, with
//!   derivatives; `fit` is their least squares, corrected for the bias that noise adds to products. `given` has
//!   what a document declares and knows beforehand; `solved` makes a calibration of it, for rows at hand and
//!   for streams alike.
//! - `noise` goes through the rows once more as linear least squares about that fit, whitened by a Kalman
//!   filter in which each sensor has noise of its own, and averages over forms of noise.
//! - `effects` are those of the catalogue, by the derivatives of `physics::predict_with_jacobian`. `weakest`
//!   reports what the rotations determine least.
//! - `variations` answers for readings whose field hardly turns: the main field about which they vary.
//! - `stream` keeps factors by windows of time (`stream/windows`); `stream/memory` widens intervals by the
//!   scatter of the windows. `seen` answers the same questions of rows and of windows, both as `noise::Groups`.
//! - The magnitude has no rotation of the sensors, so `physics` does not predict it: the residual is that of
//!   the corrected readings, which is exact for the basic chain.

mod assumed;
mod body;
mod checks;
mod design;
mod directions;
mod effects;
mod fit;
mod given;
mod kalman;
mod known_field;
mod linear;
mod model;
mod noise;
mod options;
mod read;
mod result;
mod seen;
mod solve;
mod solved;
mod start;
pub mod stream;
mod terms;
mod variations;
mod vector;
mod weakest;
mod words;

pub use assumed::Assumed;
pub use common::Error;
pub use options::{FitOptions, Options};
pub use read::Source;
pub use stream::Columns;
pub use words::summary;

use common::{Code, Document, Finding};
use joined::Gathered;
use linear::Linear;
use model::NINE;
use read::Series;
use solved::Solved;

/// Calibrates the sensors and writes them to `calibration.sensors` and `calibration.axes.sensors`, what
/// stands behind them to `calibration.scalar`, and effects that were fitted to `model.effects`.
///
/// Errors: no recording that can be used; rotations that do not determine the calibration, in words; a second
/// run with --known on recordings from which what is known was found.
pub fn run(mut document: Document, options: &Options) -> Result<Document, Error> {
    let measured = document.recordings.iter().any(|one| one.columns.contains_key("reference_nt"));
    options.magnitude.state(&mut document, |recording| !measured && read::is_free(recording))?;
    if !options.assumed.is_any() {
        return adopted(document, Vec::new(), options);
    }
    // Readings that are variations about a main field have an answer of their own, without limits.
    let gathered = joined::gathered(&document)?;
    let read = gathered.as_ref().map_or(&document, |gathered| &gathered.document);
    if let Some(found) = variations::calibrated(read, options)? {
        document.calibration = found.calibration;
        return Ok(document);
    }
    let before = document.calibration.clone();
    let told = options.assumed.state(&mut document)?;
    let fit = FitOptions { known: true, ..options.fit.clone() };
    let found = adopted(document, vec![told], &Options { fit, ..options.clone() })?;
    options.assumed.restored(found, before)
}

fn adopted(document: Document, told: Vec<Finding>, options: &Options) -> Result<Document, Error> {
    let gathered = joined::gathered(&document)?;
    let joined = gathered.iter().flat_map(|gathered| gathered.told.clone());
    let told = told.into_iter().chain(joined).collect();
    calibrate(document, gathered, told, options).map_err(words::failed)
}

fn calibrate(
    mut document: Document,
    gathered: Option<Gathered>,
    told: Vec<Finding>,
    options: &Options,
) -> Result<Document, Error> {
    let read = gathered.as_ref().map_or(&document, |gathered| &gathered.document);
    let (mut solved, series) = match calibrated(read, options) {
        Ok(solved) => solved,
        // Where the field hardly turns, rotations determine nothing, and what is determined is another thing.
        Err(refused) => {
            let Some(found) = variations::calibrated(read, options)? else { return Err(refused) };
            document.calibration = found.calibration;
            return Ok(document);
        }
    };
    if options.fit.known && result::earlier(&document, &solved) {
        let found = "a calibration by scalarcal from the same recordings";
        let expected = "one from another source: with it as a prior each reading would count twice; use the document from before that run";
        return Err(Error::document("calibration.scalar.recordings", found, expected));
    }
    solved.scalar.findings.prepend(told);
    seen::of_rows(&document, &mut solved, &series, options)?;
    result::adopt(&mut document, solved, &series)?;
    let references = physics::References::of(&document);
    physics::state_references(&mut document, &references);
    Ok(document)
}

/// By the magnitude of the field, and where that is asked for by its direction. Sensors on a body, of which
/// the calibration away from it is known, show the body's iron as well.
fn calibrated(document: &Document, options: &Options) -> Result<(Solved, Vec<Series>), Error> {
    let [on_body, away] = body::mounted(document);
    // Limits are none of the sensors' own calibration.
    let known = on_body && options.fit.known && !options.assumed.is_any();
    if !on_body || !(away || known) {
        let (mut solved, series) = by_field(document, options)?;
        solved.scalar.includes_body = !away;
        if on_body {
            solved.scalar.findings.push(Code::IncludesBody.said(body::INCLUDED));
        }
        return Ok((solved, series));
    }
    let calibration = if away {
        let mut own = body::part(document, false);
        let (mut solved, series) = by_field(&own, options)?;
        seen::of_rows(&own, &mut solved, &series, options)?;
        result::adopt(&mut own, solved, &series)?;
        own.calibration
    } else {
        body::stated(document)?;
        document.calibration.clone()
    };
    // What is known of the sensors is their own: it is held against the body, not into the fit.
    let fit = FitOptions { known: false, ..options.fit.clone() };
    let options = &Options { fit, ..options.clone() };
    let on_body = Document { calibration, ..body::part(document, true) };
    let (mut solved, series) = by_field(&on_body, options)?;
    solved.scalar.body = Some(body::of(&solved)?);
    // It is the body that the readings are held against by what is known, not the other way round.
    solved.given.prior = Linear::none(NINE);
    Ok((solved, series))
}

fn by_field(document: &Document, options: &Options) -> Result<(Solved, Vec<Series>), Error> {
    let (solved, series) = solve::solve(document, options)?;
    if !options.vector {
        return Ok((solved, series));
    }
    Ok((vector::solve(document, solved, &series)?, series))
}
