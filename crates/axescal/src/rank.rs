//! What the recordings cannot show, in words, and which rotation would show it.

use common::Axis;
use common::number::{counted, fixed};
use estimate::Svd;
use nalgebra::{Matrix3, Vector3};
use physics::frames::{small_rotation, tangents};

use crate::unknowns::{Unknown, place, turns};
use crate::{AxesProblem, AxesState, Freedom, NoiseFactors, Observation, Observations};

/// The sentence for a fit whose directions are not all seen.
pub fn explain(
    problem: &AxesProblem<'_>,
    freedom: &Freedom,
    state: &AxesState,
    unseen: &[Vec<f64>],
) -> String {
    let observations = problem.observations;
    let turns = turns(&problem.meaning).len();
    let what = match unseen {
        [one] => describe(problem, state, one),
        _ => format!(
            "sensors and coils can turn together in {} independent ways without changing a reading",
            unseen.len()
        ),
    };
    let mut text = format!(
        "the directions are not determined: rank {} of {turns} from {}. Not observable: {what}",
        turns - unseen.len().min(turns),
        counted(observations.orientations.len(), "orientation")
    );
    if let Some(axis) = common_axis(observations) {
        text.push_str(&format!(
            ". All recorded orientations differ by rotations about one axis, {} of the block",
            name_axis(&axis)
        ));
    }
    text.push_str(". ");
    text.push_str(&advice(observations, freedom, state, turns));
    text
}

/// The common axis (SEN) of the turns between orientations, if they have one.
fn common_axis(observations: &Observations) -> Option<Vector3<f64>> {
    let first = observations.orientations[0].orientation.rotation;
    let axes: Vec<Vector3<f64>> = observations.orientations[1..]
        .iter()
        .filter_map(|group| {
            let relative =
                nalgebra::Rotation3::from_matrix_unchecked(group.orientation.rotation * first.transpose());
            // By way of the quaternion, which knows the axis of a half turn as well.
            nalgebra::UnitQuaternion::from_rotation_matrix(&relative).axis().map(|axis| axis.into_inner())
        })
        .collect();
    let axis = *axes.first()?;
    axes.iter().all(|other| other.cross(&axis).norm() < 1e-2).then_some(axis)
}

/// One unseen combination as a turn of sensors and coils.
fn describe(problem: &AxesProblem<'_>, state: &AxesState, vector: &[f64]) -> String {
    let observations = problem.observations;
    let part = |name: &str,
                frame: &str,
                axes: &[Axis],
                matrix: &Matrix3<f64>,
                unknown: fn(Axis, usize) -> Unknown| {
        let moved = axes.iter().map(|&axis| {
            let direction = matrix.column(axis.index()).into_owned();
            let change = place(&problem.meaning, unknown(axis, 0)).map_or(Vector3::zeros(), |place| {
                let [a, b] = tangents(&direction);
                a * vector[place] + b * vector[place + 1]
            });
            (direction, change)
        });
        let moved: Vec<(Vector3<f64>, Vector3<f64>)> = moved.collect();
        let size: f64 = moved.iter().map(|(_, change)| change.norm_squared()).sum();
        if size < 1e-6 {
            return format!("{name}s fixed");
        }
        match common_turn(&moved) {
            Some(axis) if moved.len() > 1 => {
                format!("all {name}s rotating together about the axis {} of {frame}", name_axis(&axis))
            }
            Some(axis) => format!("the {name} rotating about {} of {frame}", name_axis(&axis)),
            None => format!("the {name}s rotating against each other"),
        }
    };
    let sensors = part("sensor", "SEN", &observations.sensors, &state.mu, Unknown::Sensor);
    format!("{sensors} with {}", part("coil", "GEO", &observations.coils, &state.eta, Unknown::Coil))
}

/// The unit axis ω with change = ω × direction for all, if there is one.
fn common_turn(moved: &[(Vector3<f64>, Vector3<f64>)]) -> Option<Vector3<f64>> {
    let mut normal = Matrix3::identity() * 1e-12;
    let mut right = Vector3::zeros();
    for (direction, change) in moved {
        let cross = -direction.cross_matrix();
        normal += cross.transpose() * cross;
        right += cross.transpose() * change;
    }
    let omega = normal.try_inverse()? * right;
    let missed: f64 =
        moved.iter().map(|(direction, change)| (omega.cross(direction) - change).norm_squared()).sum();
    let size: f64 = moved.iter().map(|(_, change)| change.norm_squared()).sum();
    (missed < 1e-3 * size && omega.norm() > 0.0).then(|| omega.normalize())
}

/// Cosine of half a degree: an axis is called by its letter when it is no further away.
const NAMED: f64 = 0.999_961_9;

fn name_axis(axis: &Vector3<f64>) -> String {
    let largest = axis.iamax();
    if axis[largest].abs() > NAMED {
        return Axis::ALL[largest].to_string();
    }
    let sign = axis[largest].signum();
    format!("({})", [0, 1, 2].map(|k| fixed(axis[k] * sign, 2)).join(", "))
}

/// Which turn of the block, by 90° from the first orientation, would show what is unseen: tried out. Of the
/// turns that do, those are named that leave the directions almost as certain as the best.
fn advice(observations: &Observations, freedom: &Freedom, state: &AxesState, turns: usize) -> String {
    let quarter = std::f64::consts::FRAC_PI_2;
    let tried: Vec<(Axis, (usize, f64))> = Axis::ALL
        .into_iter()
        .map(|axis| (axis, with_one_more(observations, freedom, state, &Vector3::ith(axis.index(), quarter))))
        .collect();
    let rank = tried.iter().map(|(_, (rank, _))| *rank).max().unwrap_or(0);
    let ranked = || tried.iter().filter(|(_, gain)| gain.0 == rank);
    let least = ranked().map(|(_, gain)| gain.1).fold(f64::INFINITY, f64::min);
    let letters: Vec<&str> =
        ranked().filter(|(_, gain)| gain.1 <= 1.2 * least).map(|(axis, _)| axis.letter()).collect();
    let (letters, first) = (letters.join(" or "), &observations.orientations[0].recordings[0]);
    if rank >= turns {
        format!(
            "One more orientation determines it: the block turned by 90° about its {letters} axis from \"{first}\", driven by \
             the same coils"
        )
    } else {
        format!(
            "More than one further orientation is needed, with rotations about two different axes; begin with the block turned \
             by 90° about its {letters} axis from \"{first}\", which gives rank {rank} of {turns}"
        )
    }
}

/// What one more orientation, each coil driven once, gives: rank and largest relative standard deviation.
fn with_one_more(
    observations: &Observations,
    freedom: &Freedom,
    state: &AxesState,
    turn: &Vector3<f64>,
) -> (usize, f64) {
    let mut more = observations.clone();
    let mut group = more.orientations[0].clone();
    group.orientation.rotation = small_rotation(turn) * group.orientation.rotation;
    more.orientations.push(group);
    let like = &observations.readings[0];
    for &coil in &observations.coils {
        for &sensor in &observations.sensors {
            more.readings.push(Observation {
                orientation: more.orientations.len() - 1,
                sensor,
                drive_nt: Vector3::ith(coil.index(), observations.largest_drive_nt()),
                ..like.clone()
            });
        }
    }
    let problem = AxesProblem::new(&more, freedom, NoiseFactors::ONE);
    let mut state = state.clone();
    state.corrections.push(Vector3::zeros());
    let (_, jacobian) = estimate::linearised(&problem, &state);
    let turns = turns(&problem.meaning);
    let Ok(svd) = Svd::of(jacobian.as_ref(), estimate::Options::default().rank_tolerance) else {
        return (0, f64::INFINITY);
    };
    let covariance = svd.covariance();
    let worst = turns.iter().map(|&k| covariance[(k, k)]).fold(0.0, f64::max).sqrt();
    (turns.len() - svd.unseen(&turns).len(), worst)
}
