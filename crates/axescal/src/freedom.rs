//! What may move besides the directions, from what the document states and what the drives can show.

use common::uncertainty::{self, By};
use common::{Axis, Document, Quantity, Uncertainty, procedure};
use faer::Mat;
use nalgebra::{DMatrix, Vector3};
use physics::frames::{ARCSEC, tangents};

use crate::unknowns::KnownCoils;
use crate::{Error, Freedom, Observations, Options, OrientationGroup, Result};

/// What may move, from what the document states and what the drives can show.
pub fn freedom(document: &Document, observations: &Observations, options: &Options) -> Result<Freedom> {
    let empty = common::Calibration::default();
    let calibration = document.calibration.as_ref().unwrap_or(&empty);
    let exact = |group: &OrientationGroup| group.orientation.uncertainty.norm() == 0.0;
    let scale = |constant: Option<&Quantity>| {
        if options.free_scales { Some(f64::INFINITY) } else { constant.and_then(Quantity::relative_std) }
    };
    let stated =
        |offset: Option<&Quantity>| offset.and_then(Quantity::std).filter(|std| *std > NEGLIGIBLE_NT);
    let mut freedom = Freedom {
        known_coils: known_coils(calibration, observations, options)?,
        orientations: !observations.orientations.iter().all(exact),
        ..Freedom::default()
    };
    let joint = Uncertainty::of(document)?;
    // The coils stand along GEO but for a small angle, and so do their offsets.
    let mut coil_offsets = [0.0; 3];
    for axis in Axis::ALL {
        let i = axis.index();
        let sensor = calibration.sensor(axis);
        let offset = stated(sensor.and_then(|sensor| sensor.offset_nt.as_ref()));
        let shown = separates_constants(observations, axis).then_some(f64::INFINITY);
        freedom.sensor_scale[i] =
            scale(sensor.and_then(|sensor| physics::sensitivity(sensor, observations.unit)));
        let [share, constant] = drive_std(document, &joint, axis);
        freedom.coil_scale[i] = if options.free_scales { Some(f64::INFINITY) } else { share };
        coil_offsets[i] = constant.filter(|std| *std > NEGLIGIBLE_NT).unwrap_or(0.0);
        freedom.offsets[i] = offset.or(shown);
    }
    let shown = observations.sensors.iter().any(|sensor| separates_constants(observations, *sensor));
    freedom.residual_field = match residual_field_std(document) {
        Some(std) => Some(coil_offsets.map(|offset| std.hypot(offset))),
        None if shown => Some([f64::INFINITY; 3]),
        None if coil_offsets.iter().any(|offset| *offset > 0.0) => {
            Some(coil_offsets.map(|offset| offset.max(NEGLIGIBLE_NT)))
        }
        None => None,
    };
    Ok(freedom)
}

/// A coil's constant, nT/A.
pub fn constant(document: &Document, coil: Axis) -> f64 {
    let of = document.calibration.as_ref().and_then(|calibration| calibration.coil(coil));
    of.and_then(|of| of.constant_nt_per_a.as_ref()).map_or(1.0, Quantity::value)
}

/// What the calculated field of a coil rests on in the recordings that are read here.
pub fn drive(document: &Document, coil: Axis) -> By {
    let mine = document.recordings.iter().filter(|one| one.procedure == procedure::AXES_ORIENTATION);
    uncertainty::drive(document, coil, constant(document, coil), mine)
}

/// Standard uncertainties of a coil's calculated field, as a share of the drive and constant, nT, if stated.
pub fn drive_std(document: &Document, joint: &Uncertainty, coil: Axis) -> [Option<f64>; 2] {
    let covariance = joint.covariance_by(&drive(document, coil));
    let std = |which: usize| Some(covariance[(which, which)].sqrt()).filter(|std| *std > 0.0);
    [std(0).map(|std| std / constant(document, coil).abs()), std(1)]
}

/// What the facility states of the field that nulling leaves.
pub fn residual_field_std(document: &Document) -> Option<f64> {
    let facility = document.facility.as_ref()?;
    facility.residual_field_std_nt.filter(|std| *std > NEGLIGIBLE_NT)
}

/// Uncertainties of constants below this are as good as none, nT.
const NEGLIGIBLE_NT: f64 = 1e-9;

/// Whether in some orientation the drives read by a sensor tell a constant from a field in proportion to the
/// drive: with zero or reversed drives the rows (B_c, 1) have one rank more than the drives.
pub fn separates_constants(observations: &Observations, sensor: Axis) -> bool {
    let largest = observations.largest_drive_nt();
    let driven = |axis: Axis| f64::from(observations.coils.contains(&axis));
    (0..observations.orientations.len()).any(|orientation| {
        let own = observations.readings.iter().filter(|reading| {
            reading.orientation == orientation && reading.constant && reading.sensor == sensor
        });
        let drives = own.map(|one| Axis::ALL.map(|axis| driven(axis) * one.drive_nt[axis.index()] / largest));
        let rows: Vec<[f64; 4]> = drives.map(|[x, y, z]| [x, y, z, 1.0]).collect();
        let rank = |columns: usize| {
            let matrix = Mat::from_fn(rows.len(), columns, |i, j| rows[i][j]);
            estimate::Svd::of(matrix.as_ref(), 1e-3).map_or(0, |svd| svd.rank())
        };
        !rows.is_empty() && rank(4) > rank(3)
    })
}

/// Known coils must be known from elsewhere, and be stated in a form that is understood.
fn check_known(
    calibration: &common::Calibration,
    observations: &Observations,
    given: &common::AxesDirections,
) -> Result<()> {
    let axes = calibration.axes.as_ref();
    let own = |axes: &common::AxesCalibration| {
        let mut recordings = axes.orientations.iter().flat_map(|orientation| &orientation.recordings);
        let read = |id| observations.orientations.iter().any(|group| group.recordings.contains(id));
        axes.known_coils.is_none() && axes.fit.is_some() && recordings.any(read)
    };
    if axes.is_some_and(own) {
        return Err(Error::document(
            "calibration.axes.coils",
            "directions that axescal found from these same recordings",
            "known coils from another source, in calibration.axes.known_coils; otherwise the readings count twice",
        ));
    }
    let order: Vec<String> = (0..9).map(|k| format!("matrix[{}][{}]", k % 3, k / 3)).collect();
    if given.covariance.is_some() && given.covariance_order.as_ref().is_some_and(|given| *given != order) {
        let expected = format!("column by column, {}", order.join(", "));
        return Err(Error::document("calibration.axes.coils.covariance_order", "another order", expected));
    }
    let negative =
        |axis: Axis| given.std_arcsec.as_ref().and_then(|std| std.get(axis)).is_some_and(|std| std < 0.0);
    if Axis::ALL.into_iter().any(negative) {
        let expected = "a standard uncertainty, which is not negative";
        return Err(Error::document("calibration.axes.coils.std_arcsec", "a negative number", expected));
    }
    Ok(())
}

/// The coils as `calibration.axes.coils` gives them, where they are to be taken as known.
fn known_coils(
    calibration: &common::Calibration,
    observations: &Observations,
    options: &Options,
) -> Result<Option<KnownCoils>> {
    if !options.known_coils {
        return Ok(None);
    }
    let given = calibration.axes.as_ref().and_then(|axes| axes.known_coils.as_ref().or(axes.coils.as_ref()));
    let Some(given) = given else { return Ok(None) };
    check_known(calibration, observations, given)?;
    let Some(matrix) = given.matrix else { return Ok(None) };
    let matrix = physics::frames::matrix(&matrix);
    let directions = [0, 1, 2].map(|j| matrix.column(j).normalize());
    let coils = &observations.coils;
    // T maps turns along the tangents to changes of the matrix, column by column.
    let mut covariance = DMatrix::zeros(2 * coils.len(), 2 * coils.len());
    match &given.covariance {
        Some(full) if full.len() == 9 && full.iter().all(|row| row.len() == 9) => {
            let tangent = |n: usize, k: usize| -> (usize, Vector3<f64>) {
                let j = coils[n].index();
                (3 * j, tangents(&directions[j])[k])
            };
            for a in 0..2 * coils.len() {
                for b in 0..2 * coils.len() {
                    let ((first, left), (second, right)) = (tangent(a / 2, a % 2), tangent(b / 2, b % 2));
                    covariance[(a, b)] = (0..9)
                        .map(|k| left[k / 3] * full[first + k / 3][second + k % 3] * right[k % 3])
                        .sum();
                }
            }
        }
        Some(_) => {
            let key = "calibration.axes.coils.covariance";
            let expected = "9x9, over the elements of `matrix` column by column, as covariance_order says";
            return Err(Error::document(key, "a matrix that is not 9x9", expected));
        }
        None => {
            for (n, &axis) in coils.iter().enumerate() {
                let std = given.std_arcsec.as_ref().and_then(|std| std.get(axis)).unwrap_or(0.0) * ARCSEC;
                covariance[(2 * n, 2 * n)] = std * std;
                covariance[(2 * n + 1, 2 * n + 1)] = std * std;
            }
        }
    }
    if covariance.iter().all(|element| *element == 0.0) {
        return Ok(Some(KnownCoils { directions, whitening: None }));
    }
    let inverse_root = covariance.clone().cholesky().and_then(|root| root.l().try_inverse()).ok_or_else(|| {
        Error::document(
            "calibration.axes.coils",
            "an uncertainty that is zero for one direction and not for another, or a covariance that is not positive",
            "a covariance, or std_arcsec, that is positive for every coil that is driven",
        )
    })?;
    Ok(Some(KnownCoils { directions, whitening: Some(inverse_root) }))
}
