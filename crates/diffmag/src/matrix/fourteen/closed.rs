//! The closed form, for plain numbers and for numbers with a derivative alike.

use common::Magnetometer;
use nalgebra::{Matrix3, Vector3};
use physics::Real;

use super::pair::Pair;

/// The reference: β (rad), Z_r, K_xr/K_yr and K_zr/K_yr.
type Reference<T> = (T, Vector3<T>, [T; 2]);

/// The pair that has this η and the five values that are known of one of its instruments.
pub(super) fn solve<T: Real>(eta: &Matrix3<T>, known: Magnetometer, values: &[T; 5]) -> Pair<T> {
    let [a, b, c, x_y, z_y] = *values;
    match known {
        Magnetometer::Reference => test_from_reference(eta, &(c, upright(a, b), [x_y, z_y])),
        Magnetometer::Test => {
            let reference = reference_from_test(eta, [a, b, c], [x_y, z_y]);
            let mut pair = test_from_reference(eta, &reference);
            // Equal already, up to rounding.
            (pair.ratios[3], pair.ratios[4]) = (x_y, z_y);
            pair
        }
    }
}

/// The unit vector with the horizontal part (x, y) and a positive vertical part.
fn upright<T: Real>(x: T, y: T) -> Vector3<T> {
    Vector3::new(x, y, (T::from(1.0) - x * x - y * y).sqrt())
}

/// The reference from G = η⁻ᵀ (M_t M_tᵀ) η⁻¹ = M_r M_rᵀ, where M_t M_tᵀ = K_yt² (q_j q_k c_jk), q the known
/// ratios of K and c the cosines between the test's axes. The ratios of K_r are roots of ratios of G's
/// diagonal; its off-diagonals over those roots are the cosines between the reference's axes,
///
/// ```text
/// x·y = sin β    y·z = sin γ cos α    x·z = sin γ sin(α + β) = sin γ sin α cos β + sin γ cos α sin β
/// ```
///
/// so that sin γ sin α = (x·z − x·y y·z)/cos β. Source: DIFF eq. 4 with the signs of its figure 1.
fn reference_from_test<T: Real>(eta: &Matrix3<T>, [xy, yz, xz]: [T; 3], ratios: [T; 2]) -> Reference<T> {
    let columns: [Vector3<T>; 3] = std::array::from_fn(|j| eta.column(j).into_owned());
    // η⁻ᵀ has the columns (η_k × η_l)/det η; the sign of det η falls out of G.
    let cofactors: [Vector3<T>; 3] =
        std::array::from_fn(|j| columns[(j + 1) % 3].cross(&columns[(j + 2) % 3]));
    let determinant = columns[0].dot(&cofactors[0]);
    let one = T::from(1.0);
    let factors = [ratios[0], one, ratios[1]];
    let cosines = [[one, xy, xz], [xy, one, yz], [xz, yz, one]].map(Vector3::from);
    // Row i of η⁻ᵀ diag(q).
    let rows: [Vector3<T>; 3] =
        std::array::from_fn(|i| Vector3::from_fn(|j, _| cofactors[j][i] * factors[j] / determinant));
    let g = |i: usize, k: usize| rows[i].dot(&Vector3::from_fn(|j, _| cosines[j].dot(&rows[k])));
    let lengths: [T; 3] = std::array::from_fn(|i| g(i, i).sqrt());
    let sin_beta = g(0, 1) / (lengths[0] * lengths[1]);
    let toward_y = g(1, 2) / (lengths[1] * lengths[2]);
    let beta = sin_beta.asin();
    let toward_x = (g(0, 2) / (lengths[0] * lengths[2]) - sin_beta * toward_y) / beta.cos();
    (beta, upright(toward_x, toward_y), [lengths[0] / lengths[1], lengths[2] / lengths[1]])
}

/// The rows of ηᵀ M_r, in units of K_yr, are K_tj × test axis j.
fn test_from_reference<T: Real>(eta: &Matrix3<T>, (beta, z, ratios): &Reference<T>) -> Pair<T> {
    let zero = T::from(0.0);
    let rows = [
        Vector3::new(beta.cos(), beta.sin(), zero) * ratios[0],
        Vector3::new(zero, T::from(1.0), zero),
        z * ratios[1],
    ];
    let vectors: [Vector3<T>; 3] = std::array::from_fn(|j| {
        let weights = eta.column(j).into_owned();
        Vector3::from_fn(|component, _| Vector3::from_fn(|axis, _| rows[axis][component]).dot(&weights))
    });
    Pair::beside((*beta, *z, *ratios), &vectors)
}
