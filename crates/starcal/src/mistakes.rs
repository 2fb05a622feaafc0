//! What is wrong with attitudes that do not fit the readings: quaternions in another order or of the inverse rotation, or
//! from another frame.

use common::number::counted;
use estimate::Svd;
use faer::Mat;
use nalgebra::Vector3;

use crate::Error;
use crate::partial::Partial;
use crate::sample::Row;
use crate::taking::turn;

/// Attitudes that leave more than this share of the field may be wrong, and are beyond the second.
const DOUBTFUL: f64 = 0.01;
const WRONG: f64 = 0.1;
/// A mistake is known where undoing it leaves less than this share of what was left.
const KNOWN: f64 = 0.2;
/// Frames, with the place of their field in a row of the sample.
const FRAMES: [(&str, usize); 3] = [("geo", 8), ("itrf", 11), ("icrf", 14)];

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

/// Checks a flight by a few of its rows.
///
/// Errors: attitudes that do not fit the readings, with the remedy.
pub fn check(partial: &Partial) -> Result<(), Error> {
    let frame = partial.layout.frame.as_str();
    let rows: Vec<&Row> = partial.sample.rows().collect();
    if rows.len() < 12 {
        return Err(Error::Unanswerable(format!(
            "found {} with readings, field and an attitude of camera_1; expected at least 12. Of the others {} lack a value, {} have no attitude, and {} have no unit quaternion, or readings of a magnitude that is not that of the field within 20 %: are they in nT?",
            counted(rows.len(), "row"),
            partial.missing,
            partial.blind,
            partial.odd
        )));
    }
    let share = |order: usize, frame: &str| left(&rows, order, frame).unwrap_or(f64::INFINITY);
    let own = share(0, frame);
    if own < DOUBTFUL {
        return Ok(());
    }
    let frames = FRAMES.iter().filter(|(name, _)| partial.layout.place || *name == frame);
    let all = frames.flat_map(|(name, _)| (0..ORDERS.len()).map(move |order| (*name, order)));
    let best = all.map(|(name, order)| (name, order, share(order, name))).min_by(|a, b| a.2.total_cmp(&b.2));
    let found = format!("the attitudes of camera_1 leave {:.0} % of the field unexplained", 100.0 * own);
    Err(match best.filter(|(_, _, share)| *share < KNOWN * own) {
        // Readings of another moment leave as much; the fit finds them.
        None if own < WRONG => return Ok(()),
        Some((name, order, _)) => {
            let turned = (name != frame).then(|| {
                format!("they turn from {name}, and not from {frame}: state `conditions.attitude_frame` as \"{name}\", or give --attitude-frame {name}")
            });
            let said: Vec<String> =
                turned.into_iter().chain((order > 0).then(|| ORDERS[order].0.to_string())).collect();
            Error::Unanswerable(format!("{found}; {}", said.join("; ")))
        }
        None => Error::Unanswerable(format!(
            "{found}; expected unit quaternions w, x, y, z from {frame} to the camera, at the times of the readings, and a field in nT: check times, frame and columns"
        )),
    })
}

/// The share of the field that is left by a linear fit of the readings, with the parts of the quaternions in an order.
fn left(rows: &[&Row], order: usize, frame: &str) -> Option<f64> {
    let (_, places, sign) = ORDERS[order];
    let (_, first) = *FRAMES.iter().find(|(name, _)| *name == frame)?;
    let mut fields = Vec::new();
    for row in rows {
        let q = places.map(|place| row[4 + place]);
        let turn = turn([q[0], sign * q[1], sign * q[2], sign * q[3]])?;
        fields.push(turn * Vector3::new(row[first], row[first + 1], row[first + 2]));
    }
    let readings = Mat::from_fn(rows.len(), 4, |i, j| if j < 3 { rows[i][1 + j] / 5e4 } else { 1.0 });
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
