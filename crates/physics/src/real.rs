//! The numbers that the forward model is written in.

use nalgebra::{ClosedAddAssign, ClosedMulAssign, ClosedSubAssign, Scalar};
use num_dual::DualNum;

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
