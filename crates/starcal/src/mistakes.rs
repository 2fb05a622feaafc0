//! What is wrong with attitudes that do not fit the readings: quaternions in another order or of the inverse rotation, or
//! from another frame.

use common::AttitudeFrame;
use common::number::counted;
use estimate::Svd;
use faer::Mat;
use nalgebra::Vector3;
use physics::frames::attitude;

use crate::Error;
use crate::layout::FIELD_NT;
use crate::partial::{Partial, WIDTH};

/// Attitudes that leave more than the first share of the field may be wrong; beyond the second they are.
const DOUBTFUL: f64 = 0.01;
const WRONG: f64 = 0.1;
/// A mistake is known where undoing it leaves less than this share of what was left.
const KNOWN: f64 = 0.2;
/// How the parts of a quaternion may stand.
const ORDERS: [(&str, [usize; 4], f64); 4] = [
    ("", [0, 1, 2, 3], 1.0),
    (
        "they turn from the camera to the frame: reverse the signs of camera_1_x, camera_1_y and camera_1_z",
        [0, 1, 2, 3],
        -1.0,
    ),
    (
        "their scalar part stands last: name the four columns camera_1_x, camera_1_y, camera_1_z, camera_1_w",
        [3, 0, 1, 2],
        1.0,
    ),
    (
        "their scalar part stands last, and they turn from the camera to the frame: name the four columns camera_1_x, camera_1_y, camera_1_z, camera_1_w and reverse the signs of the first three",
        [3, 0, 1, 2],
        -1.0,
    ),
];

/// Checks a flight by a few of its rows. Errors: attitudes that do not fit the readings, with the remedy.
pub fn check(partial: &Partial) -> Result<(), Error> {
    let frame = partial.layout.frame;
    let rows = partial.sample.rows();
    if rows.len() < 12 {
        return Err(Error::Unanswerable(format!(
            "found {} with readings, field and an attitude of camera_1; expected at least 12. Of the others {} lack a value, {} have no attitude, and {} have a quaternion of another length than 1, or readings whose magnitude differs from that of the field by more than 20 %: are they in nT?",
            counted(rows.len(), "row"),
            partial.missing,
            partial.blind,
            partial.odd
        )));
    }
    let share = |order: usize, frame: AttitudeFrame| left(&rows, order, frame).unwrap_or(f64::INFINITY);
    let own = share(0, frame);
    if own < DOUBTFUL {
        return Ok(());
    }
    let frames = AttitudeFrame::ALL.into_iter().filter(|other| partial.layout.place || *other == frame);
    let all = frames.flat_map(|other| (0..ORDERS.len()).map(move |order| (other, order)));
    let best =
        all.map(|(other, order)| (other, order, share(order, other))).min_by(|a, b| a.2.total_cmp(&b.2));
    let found = format!("the attitudes of camera_1 leave {:.0} % of the field unexplained", 100.0 * own);
    Err(match best.filter(|(_, _, share)| *share < KNOWN * own) {
        // Readings that are late leave as much; the fit finds them.
        None if own < WRONG => return Ok(()),
        Some((other, order, _)) => {
            let turned = (other != frame).then(|| {
                let [name, frame] = [other, frame].map(AttitudeFrame::name);
                format!("they turn from {name}, and not from {frame}: state `conditions.attitude_frame` as \"{name}\", or give --attitude-frame {name}")
            });
            let said: Vec<String> =
                turned.into_iter().chain((order > 0).then(|| ORDERS[order].0.to_string())).collect();
            Error::Unanswerable(format!("{found}; {}", said.join("; ")))
        }
        None => Error::Unanswerable(format!(
            "{found}; expected unit quaternions w, x, y, z from {} to the camera, at the times of the readings, and a field in nT: check times, frame and columns",
            frame.name()
        )),
    })
}

/// The share of the field that is left by a linear fit of the readings, with the parts of the quaternions in an order.
fn left(rows: &[[f64; WIDTH]], order: usize, frame: AttitudeFrame) -> Option<f64> {
    let (_, places, sign) = ORDERS[order];
    let first = match frame {
        AttitudeFrame::Geo => 8,
        AttitudeFrame::Itrf => 11,
        AttitudeFrame::Icrf => 14,
    };
    let mut fields = Vec::new();
    for row in rows {
        let q = places.map(|place| row[4 + place]);
        let turn = attitude([q[0], sign * q[1], sign * q[2], sign * q[3]])?;
        fields.push(turn * Vector3::new(row[first], row[first + 1], row[first + 2]));
    }
    let readings = Mat::from_fn(rows.len(), 4, |i, j| if j < 3 { rows[i][1 + j] / FIELD_NT } else { 1.0 });
    let svd = Svd::of(readings.as_ref(), 1e-9).ok()?;
    let mut squares = 0.0;
    for component in 0..3 {
        let field: Vec<f64> = fields.iter().map(|field| field[component]).collect();
        let solved = svd.solve(&field);
        squares += (0..rows.len())
            .map(|i| field[i] - (0..4).map(|j| readings[(i, j)] * solved[j]).sum::<f64>())
            .map(|left| left * left)
            .sum::<f64>();
    }
    let all: f64 = fields.iter().map(|field| field.norm_squared()).sum();
    Some((squares / all).sqrt())
}
