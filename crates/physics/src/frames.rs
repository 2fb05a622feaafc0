//! Frames and directions: rotations from theodolites, the nearest rotation, turns of unit vectors.

use common::number::{bare, significant};
use common::{Matrix3x3, Theodolite, TheodoliteAngle};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use num_dual::Dual64;

use crate::{Error, Real};

/// One arcsecond, rad.
pub const ARCSEC: f64 = std::f64::consts::PI / 648_000.0;

/// Without declared theodolites, a matrix that is printed to few digits may be this far from a rotation, rad.
const UNDECLARED_LIMIT_RAD: f64 = 1e-4;
/// Theodolite standard deviations by which a matrix may be off.
const LIMIT_SIGMAS: f64 = 5.0;

/// R with the uncertainty of the theodolites that gave it.
#[derive(Clone, Debug, PartialEq)]
pub struct Orientation {
    /// GEO -> SEN, rows = SEN axes in GEO.
    pub rotation: Matrix3<f64>,
    /// L with L Lᵀ = covariance of the small rotation about the SEN axes, rad; zero if undeclared.
    pub uncertainty: Matrix3<f64>,
    /// How far the given matrix was from a rotation, rad.
    pub moved_rad: f64,
}

impl Orientation {
    /// From R as given. `theodolite_rad` is the standard uncertainty of one theodolite reading.
    pub fn from_matrix(rows: &Matrix3x3, theodolite_rad: Option<f64>) -> Result<Self, Error> {
        let (rotation, moved_rad) = nearest_rotation(&matrix(rows), theodolite_rad)?;
        let uncertainty = Matrix3::identity() * theodolite_rad.unwrap_or(0.0);
        Ok(Self { rotation, uncertainty, moved_rad })
    }

    /// From the theodolites' angles (NASA eq. 7 to 11): R = N F, the rows of F being X_s = (cos φx sin θx,
    /// sin φx sin θx, cos θx), Y_s = (−sin φy sin θy, cos φy sin θy, cos θy), X_s × Y_s, projected to the
    /// nearest rotation. An angle that was read several times counts as its mean.
    ///
    /// `theodolite_rad` gives the standard uncertainty of the mean of so many readings. A turn about the
    /// faces' x axis is seen in θy, one about y in θx, and the one about z twice, in φx and φy.
    pub fn from_theodolite(
        angles: &Theodolite,
        nominal: Option<&Matrix3x3>,
        theodolite_rad: impl Fn(usize) -> Option<f64>,
    ) -> Result<Self, Error> {
        let all = [&angles.phi_x_rad, &angles.theta_x_rad, &angles.phi_y_rad, &angles.theta_y_rad];
        let readings = || all.iter().flat_map(|angle| angle.readings());
        if let Some(angle) = readings().find(|angle| angle.is_nan() || angle.abs() > std::f64::consts::TAU) {
            return Err(Error::NotARotation {
                found: format!("an angle of {angle} rad, more than a whole turn"),
                expected: "theodolite angles in rad; these may be degrees".into(),
            });
        }
        let [phi_x, theta_x, phi_y, theta_y] = all.map(TheodoliteAngle::mean);
        let x = Vector3::new(phi_x.cos() * theta_x.sin(), phi_x.sin() * theta_x.sin(), theta_x.cos());
        let y = Vector3::new(-phi_y.sin() * theta_y.sin(), phi_y.cos() * theta_y.sin(), theta_y.cos());
        let faces = Matrix3::from_rows(&[x.transpose(), y.transpose(), x.cross(&y).transpose()]);
        let std = all.map(|angle| theodolite_rad(angle.readings().len()));
        let (faces, moved_rad) = nearest_rotation(&faces, std.into_iter().flatten().reduce(f64::max))?;
        let (nominal, moved_nominal) = match nominal {
            Some(rows) => nearest_rotation(&matrix(rows), None)?,
            None => (Matrix3::identity(), 0.0),
        };
        let [phi_x, theta_x, phi_y, theta_y] = std.map(|std| std.unwrap_or(0.0));
        Ok(Self {
            rotation: nominal * faces,
            uncertainty: nominal * face_uncertainty([phi_x, theta_x, phi_y, theta_y]),
            moved_rad: moved_rad.max(moved_nominal),
        })
    }
}

/// L with L Lᵀ = covariance of the small rotation about the faces' axes, by the standard uncertainties of φx,
/// θx, φy, θy (rad).
pub fn face_uncertainty([phi_x, theta_x, phi_y, theta_y]: [f64; 4]) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(theta_y, theta_x, 0.5 * phi_x.hypot(phi_y)))
}

/// A matrix from its rows as JSON writes them.
pub fn matrix(rows: &Matrix3x3) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

/// The rows of a matrix as JSON writes them.
pub fn rows(matrix: &Matrix3<f64>) -> Matrix3x3 {
    std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]))
}

/// The orthogonal matrix nearest to M: the factor R of its polar decomposition M = R S, by Newton's iteration
/// R ← (R + R⁻ᵀ)/2. None of a singular matrix; its determinant has the sign of that of M.
pub fn polar(given: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let mut rotation = *given;
    for _ in 0..30 {
        let next = (rotation + rotation.try_inverse()?.transpose()) * 0.5;
        let change = (next - rotation).norm();
        rotation = next;
        if change < 1e-15 {
            break;
        }
    }
    Some(rotation)
}

/// The rotation by a unit quaternion w, x, y, z; None of another length.
pub fn attitude([w, x, y, z]: [f64; 4]) -> Option<Matrix3<f64>> {
    let q = Quaternion::new(w, x, y, z);
    let rotation = || UnitQuaternion::from_quaternion(q).to_rotation_matrix().into_inner();
    ((q.norm() - 1.0).abs() <= 1e-3).then(rotation)
}

/// The rotation nearest to M and the largest |eigenvalue| of S − 1: how far it had to move, rad.
fn nearest_rotation(given: &Matrix3<f64>, theodolite_rad: Option<f64>) -> Result<(Matrix3<f64>, f64), Error> {
    let refuse = |found: String| {
        Error::NotARotation {
        found,
        expected: "R (GEO -> SEN), a rotation: rows = SEN axes in GEO, orthogonal, right-handed; read it again from the \
                   theodolites' book, or see whether rows and columns, or a sign, were mixed up"
            .into(),
    }
    };
    if given.iter().any(|element| !element.is_finite() || element.abs() > 2.0) {
        return Err(refuse("elements that are no direction cosines".into()));
    }
    let determinant = given.determinant();
    if determinant < -0.5 {
        return Err(refuse(format!("a left-handed matrix (its determinant is {})", bare(determinant))));
    }
    let rotation = polar(given).ok_or_else(|| refuse("a singular matrix".into()))?;
    let stretch = rotation.transpose() * given;
    let eigenvalues = ((stretch + stretch.transpose()) * 0.5).symmetric_eigenvalues();
    let moved = eigenvalues.iter().map(|value| (value - 1.0).abs()).fold(0.0, f64::max);
    let limit = match theodolite_rad {
        Some(sigma) if sigma > 0.0 => LIMIT_SIGMAS * sigma,
        _ => UNDECLARED_LIMIT_RAD,
    };
    if moved.is_nan() || moved > limit {
        return Err(refuse(format!(
            "a matrix that is not orthogonal: {} arcsec from the nearest rotation, where {} arcsec can be allowed",
            significant(moved / ARCSEC, 3),
            significant(limit / ARCSEC, 3)
        )));
    }
    Ok((rotation, moved))
}

/// exp([ρ]×): the rotation by the small vector ρ (rad) about the axes of the frame it is applied in.
pub fn small_rotation(rho: &Vector3<f64>) -> Matrix3<f64> {
    *nalgebra::Rotation3::from_scaled_axis(*rho).matrix()
}

/// Two unit vectors that with `direction` make an orthogonal frame.
pub fn tangents(direction: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let helper = Vector3::ith(direction.iamin(), 1.0);
    let first = direction.cross(&helper).normalize();
    [first, direction.cross(&first)]
}

/// The unit vector (u + a e₁ + b e₂)/|…|, with e the tangents of u: no pole anywhere on the sphere.
pub fn turned<T: Real>(direction: &Vector3<f64>, turn: [T; 2]) -> Vector3<T> {
    let [e1, e2] = tangents(direction);
    let moved = Vector3::from_fn(|i, _| turn[0] * e1[i] + turn[1] * e2[i] + direction[i]);
    let length = (moved[0] * moved[0] + moved[1] * moved[1] + moved[2] * moved[2]).sqrt();
    moved.map(|component| component / length)
}

/// The same of a vector that keeps its length: columns of η and μ of two magnetometers are no unit vectors.
pub fn turned_at_length<T: Real>(column: &Vector3<f64>, turn: [T; 2]) -> Vector3<T> {
    let length = column.norm();
    turned(&(column / length), turn).map(|component| component * length)
}

/// The derivatives of [`turned`] by its two turns.
pub fn turned_derivatives(direction: &Vector3<f64>, turn: [f64; 2]) -> [Vector3<f64>; 2] {
    [0, 1].map(|which| {
        let seeded = std::array::from_fn(|k| Dual64::new(turn[k], f64::from(u8::from(k == which))));
        turned(direction, seeded).map(|component: Dual64| component.eps)
    })
}

/// The angle between two directions, rad; exact also where they nearly agree.
pub fn angle(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// Rotations from a list of matrices; an error says which of the list it is about.
pub fn rotations(list: &[Matrix3x3], path: &str) -> Result<Vec<Matrix3<f64>>, common::Error> {
    list.iter()
        .enumerate()
        .map(|(index, rows)| {
            let orientation = Orientation::from_matrix(rows, None);
            orientation.map(|given| given.rotation).map_err(|error| error.at(&format!("{path}[{index}]")))
        })
        .collect()
}

/// The 24 rotations of a cube, the identity first.
pub fn cube_rotations() -> Vec<Matrix3<f64>> {
    let mut all = Vec::with_capacity(24);
    for permutation in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]] {
        for signs in 0..8 {
            let sign = |bit: usize| if signs >> bit & 1 == 1 { -1.0 } else { 1.0 };
            let candidate = Matrix3::from_fn(|i, j| if permutation[i] == j { sign(i) } else { 0.0 });
            if candidate.determinant() > 0.0 {
                all.push(candidate);
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIGHT: f64 = std::f64::consts::FRAC_PI_2;

    fn angles(theta_y_rad: f64) -> Theodolite {
        Theodolite {
            phi_x_rad: TheodoliteAngle::Once(0.1),
            theta_x_rad: TheodoliteAngle::Once(RIGHT),
            phi_y_rad: TheodoliteAngle::Once(0.1),
            theta_y_rad: TheodoliteAngle::Once(theta_y_rad),
            nominal_rotation: None,
            extra: Default::default(),
        }
    }

    #[test]
    fn theodolites_by_hand() {
        // NASA eq. 7 to 11 with φx = 0.1, θx = π/2, φy = 0.1, θy = π/2: a turn of 0.1 rad about down.
        let angles = angles(RIGHT);
        let orientation = Orientation::from_theodolite(&angles, None, |_| None).expect("a rotation");
        let expected =
            Matrix3::new(0.1f64.cos(), 0.1f64.sin(), 0.0, -0.1f64.sin(), 0.1f64.cos(), 0.0, 0.0, 0.0, 1.0);
        assert!((orientation.rotation - expected).norm() < 1e-15);
        // The fixture turned by 90° about down: SEN x looks east.
        let nominal = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let turned = Orientation::from_theodolite(&angles, Some(&nominal), |_| None).expect("a rotation");
        assert!((turned.rotation.row(0) - expected.row(1)).norm() < 1e-15);
    }

    #[test]
    fn repeated_readings_count_as_their_mean() {
        let once = angles(RIGHT + 1e-5);
        let several = Theodolite {
            phi_x_rad: TheodoliteAngle::Repeated(vec![0.1 - 2e-6, 0.1 + 2e-6]),
            theta_y_rad: TheodoliteAngle::Repeated(vec![RIGHT, RIGHT + 1e-5, RIGHT + 2e-5, RIGHT + 1e-5]),
            ..once.clone()
        };
        // σ² = 3² + 4²/n: 5" for one reading.
        let std = |n: usize| Some(ARCSEC * (9.0 + 16.0 / n as f64).sqrt());
        let of = |angles: &Theodolite| Orientation::from_theodolite(angles, None, std).expect("a rotation");
        assert!((of(&once).rotation - of(&several).rotation).norm() < 1e-14);
        let diagonal = |orientation: Orientation| orientation.uncertainty.diagonal() / ARCSEC;
        let whole = diagonal(of(&once));
        assert!((whole - Vector3::new(5.0, 5.0, 5.0 / 2f64.sqrt())).norm() < 1e-12, "{whole}");
        let shared = diagonal(of(&several));
        assert!((shared - Vector3::new(13f64.sqrt(), 5.0, 0.5 * 42f64.sqrt())).norm() < 1e-12, "{shared}");
    }

    #[test]
    fn half_of_a_skew_goes_to_each_face() {
        let sigma = Some(2.0 * ARCSEC);
        let skew = 6.0 * ARCSEC;
        let rows = [[1.0, skew, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let orientation =
            Orientation::from_matrix(&rows, sigma).expect("within the theodolites' uncertainty");
        assert!((orientation.moved_rad - skew / 2.0).abs() < 1e-9);
        assert!((orientation.rotation[(0, 1)] - skew / 2.0).abs() < 1e-9);
        let far = [[1.0, 10.0 * skew, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let refused = Orientation::from_matrix(&far, sigma).expect_err("too far");
        assert!(refused.to_string().contains("30 arcsec from the nearest rotation, where 10 "), "{refused}");
    }

    #[test]
    fn left_handed_and_singular_are_refused() {
        let mirrored = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let error = Orientation::from_matrix(&mirrored, None).expect_err("a mirror");
        assert!(error.to_string().contains("left-handed"), "{error}");
        assert!(Orientation::from_matrix(&[[0.0; 3]; 3], None).is_err());
        // Table 1's R6 as scanned.
        let c = std::f64::consts::FRAC_1_SQRT_2;
        let scanned = [[c, 0.0, c], [0.0, 1.0, -c], [0.0, c, 0.0]];
        assert!(Orientation::from_matrix(&scanned, None).is_err());
    }

    #[test]
    fn tangents_are_orthonormal_everywhere() {
        for direction in
            [Vector3::x(), -Vector3::z(), Vector3::new(0.6, 0.64, 0.48), Vector3::new(-0.8, 0.0, 0.6)]
        {
            let [a, b] = tangents(&direction);
            let frame = Matrix3::from_columns(&[direction, a, b]);
            assert!((frame.transpose() * frame - Matrix3::identity()).norm() < 1e-14);
        }
        assert_eq!(cube_rotations().len(), 24);
        assert_eq!(cube_rotations()[0], Matrix3::identity());
    }

    /// A column turns without growing, and its derivatives are those of what it is.
    #[test]
    fn a_turned_column_keeps_its_length() {
        let column = Vector3::new(0.3, -1.1, 0.7);
        let turn = [0.02, -0.05];
        let at = |turn: [f64; 2]| turned_at_length(&column, turn);
        assert!((at(turn).norm() - column.norm()).abs() < 1e-15 && (at([0.0; 2]) - column).norm() < 1e-15);
        let unit = column.normalize();
        for (which, exact) in turned_derivatives(&unit, turn).into_iter().enumerate() {
            let moved = |step: f64| {
                turned(&unit, std::array::from_fn(|k| turn[k] + if k == which { step } else { 0.0 }))
            };
            let by_difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((by_difference - exact).norm() < 1e-9, "{by_difference} for {exact}");
        }
    }
}
