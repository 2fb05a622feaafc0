//! Where the iteration begins, and whether a channel is reversed or two are swapped.

use common::{Axis, Code, Document, Finding};
use nalgebra::{Matrix3, Vector3};
use physics::frames;

use crate::{AxesState, Error, Observations, Options, Result, Start};

/// The start that the options ask for, with signs and columns of the sensors as the readings show them; and
/// what had to be turned round or swapped for it, in words.
///
/// Every reading is compared with the one that the first model predicts for it. Reversing a sensor changes
/// the sign of all its products, swapping two sensors exchanges them: of the 6 × 2⁶ combinations that with
/// the largest sum of products is taken, of equals the one that changes least.
pub fn begin(
    document: &Document,
    observations: &Observations,
    options: &Options,
) -> Result<(AxesState, Vec<Finding>)> {
    let first = first_model(document, observations, options)?;
    let mut products = [[[0.0; 3]; 3]; 3];
    for reading in &observations.readings {
        let rotation = &observations.orientations[reading.orientation].orientation.rotation;
        for j in 0..3 {
            let field: Vector3<f64> = rotation * first.eta.column(j) * reading.drive_nt[j];
            for (direction, sums) in products[reading.sensor.index()].iter_mut().enumerate() {
                sums[j] += reading.value_nt * first.mu.column(direction).dot(&field);
            }
        }
    }
    let coil_signs = if options.known_coils { 1 } else { 8 };
    let swaps: &[[usize; 3]] = if observations.sensors.len() == 3 {
        &[[0, 1, 2], [1, 0, 2], [2, 1, 0], [0, 2, 1], [1, 2, 0], [2, 0, 1]]
    } else {
        &[[0, 1, 2]]
    };
    let sign = |signs: usize, axis: usize| if signs >> axis & 1 == 1 { -1.0 } else { 1.0 };
    let size: f64 = products.iter().flatten().flatten().map(|p: &f64| p.abs()).sum();
    let mut best = (f64::NEG_INFINITY, usize::MAX, [0, 1, 2], 0, 0);
    for &swap in swaps {
        for sensors in 0..8 {
            for coils in 0..coil_signs {
                let sum: f64 = (0..3)
                    .flat_map(|i| (0..3).map(move |j| (i, j)))
                    .map(|(i, j)| sign(sensors, i) * sign(coils, j) * products[i][swap[i]][j])
                    .sum();
                let moved = (0..3).filter(|&i| swap[i] != i).count();
                let changes = (sensors.count_ones() + coils.count_ones()) as usize + moved;
                let margin = 1e-3 * size;
                if sum > best.0 + margin || (sum > best.0 - margin && changes < best.1) {
                    best = (sum, changes, swap, sensors, coils);
                }
            }
        }
    }
    let (_, _, swap, sensors, coils) = best;
    let mu = Matrix3::from_columns(&[0, 1, 2].map(|i| first.mu.column(swap[i]) * sign(sensors, i)));
    let eta = Matrix3::from_columns(&[0, 1, 2].map(|j| first.eta.column(j) * sign(coils, j)));
    let mut findings = Vec::new();
    for axis in Axis::ALL {
        let i = axis.index();
        if swap[i] != i {
            let other = Axis::ALL[swap[i]];
            let words = format!("sensor {axis} reads along {other}: columns or cables may be swapped");
            findings.push(Code::Swapped.about(axis).said(words));
        }
        if sign(sensors, i) < 0.0 {
            findings.push(Code::SensorReversed.about(axis).said(format!(
                "sensor {axis} reads with the opposite sign, as with a mirrored axis or reversed wiring; its direction is fitted as it reads"
            )));
        }
        if sign(coils, i) < 0.0 {
            findings.push(Code::CoilReversed.about(axis).said(format!(
                "the field of coil {axis} has the opposite sign, as with reversed leads or a reversed current reading; its direction is fitted as it acts"
            )));
        }
    }
    Ok((AxesState { mu, eta, ..first }, findings))
}

fn first_model(document: &Document, observations: &Observations, options: &Options) -> Result<AxesState> {
    let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    let given = |part: &str, from: Option<&common::AxesDirections>, why: &str| -> Result<_> {
        let Some(rows) = from.and_then(|part| part.matrix) else {
            let path = format!("calibration.axes.{part}.matrix");
            let expected = format!("a 3x3 matrix whose columns are unit vectors, which {why} asks for");
            return Err(Error::document(path, "nothing", expected));
        };
        let mut matrix = frames::matrix(&rows);
        // Of length one but for the digits that are written: a document is held to that when it is read.
        for mut column in matrix.column_iter_mut() {
            column.normalize_mut();
        }
        Ok(matrix)
    };
    let (mut mu, mut eta) = (Matrix3::identity(), Matrix3::identity());
    if options.start == Start::Document {
        mu = given("sensors", axes.and_then(|axes| axes.sensors.as_ref()), "--start=document")?;
        eta = given("coils", axes.and_then(|axes| axes.coils.as_ref()), "--start=document")?;
    }
    if options.known_coils {
        let known = axes.and_then(|axes| axes.known_coils.as_ref().or(axes.coils.as_ref()));
        eta = given("coils", known, "--known-coils")?;
    }
    Ok(AxesState::new(mu, eta, observations.orientations.len()))
}
