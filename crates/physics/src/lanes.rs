//! The numbers of the forward model, and those that carry several derivatives at once.

use nalgebra::{ClosedAddAssign, ClosedMulAssign, ClosedSubAssign, Scalar};
use num_dual::{DualNum, DualSVec64};

/// A number that may carry a derivative: `f64` for simulation, a dual number for fits. An effect is
/// written once for any of them, so a prediction and its Jacobian cannot disagree.
pub trait Real:
    DualNum<Primitive = f64> + Copy + Scalar + ClosedAddAssign + ClosedSubAssign + ClosedMulAssign
{
}

impl<T> Real for T where
    T: DualNum<Primitive = f64> + Copy + Scalar + ClosedAddAssign + ClosedSubAssign + ClosedMulAssign
{
}

/// Most derivatives that are carried at once.
pub(crate) const LANES: usize = 8;

pub(crate) type Dual<const N: usize = LANES> = DualSVec64<N>;

/// Zero, with the derivative one in a lane.
pub(crate) fn unit<const N: usize>(lane: usize) -> Dual<N> {
    Dual::from_re(0.0).derivative(lane)
}

/// A value with derivatives.
pub(crate) fn dual(value: f64, derivatives: impl Fn(usize) -> f64) -> Dual {
    let lanes = nalgebra::SVector::from_fn(|lane, _| derivatives(lane));
    Dual::new(value, num_dual::Derivative::some(lanes))
}

pub(crate) fn slope<const N: usize>(value: &Dual<N>, lane: usize) -> f64 {
    value.eps.0.map_or(0.0, |lanes| lanes[lane])
}

pub(crate) fn is_finite(value: &Dual) -> bool {
    value.eps.0.is_none_or(|lanes| lanes.iter().all(|slope| slope.is_finite()))
}
