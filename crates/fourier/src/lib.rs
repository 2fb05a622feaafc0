//! Discrete Fourier transforms of real series in double precision: realfft, compiled here once and not in
//! each crate that uses it. Neither direction is scaled: x → X → x gives N x. And the cosine transform, which
//! is made of it.

mod cosine;

use std::sync::{Arc, Mutex, PoisonError};

pub use cosine::{Cosine, cosine};
pub use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

/// N real numbers to N/2 + 1 complex ones, X(k) = Σ x(n) exp(-2πi kn/N).
pub type Forward = Arc<dyn RealToComplex<f64>>;

/// N/2 + 1 complex numbers back to N real ones.
pub type Inverse = Arc<dyn ComplexToReal<f64>>;

/// Makes transforms and keeps what those of other lengths can share.
pub struct Planner(RealFftPlanner<f64>);

impl Planner {
    /// A planner that has made none yet.
    #[expect(clippy::new_without_default, reason = "a default planner would say no more than a new one")]
    pub fn new() -> Self {
        Self(RealFftPlanner::new())
    }

    /// The forward transform of `points` real numbers.
    pub fn forward(&mut self, points: usize) -> Forward {
        self.0.plan_fft_forward(points)
    }

    /// The inverse transform to `points` real numbers.
    pub fn inverse(&mut self, points: usize) -> Inverse {
        self.0.plan_fft_inverse(points)
    }
}

/// Transforms of a length are asked for again and again, and making one takes as long as using it: so many of
/// those used last are kept.
const KEPT: usize = 4;

static FORWARD: Mutex<Vec<Forward>> = Mutex::new(Vec::new());
static INVERSE: Mutex<Vec<Inverse>> = Mutex::new(Vec::new());

/// The forward transform of `points` real numbers.
pub fn forward(points: usize) -> Forward {
    kept(&FORWARD, |plan| plan.len() == points, || Planner::new().forward(points))
}

/// The inverse transform to `points` real numbers.
pub fn inverse(points: usize) -> Inverse {
    kept(&INVERSE, |plan| plan.len() == points, || Planner::new().inverse(points))
}

/// One of those that are kept, or a new one in place of that which was not used for longest.
fn kept<T: Clone>(plans: &Mutex<Vec<T>>, right: impl Fn(&T) -> bool, make: impl Fn() -> T) -> T {
    let mut plans = plans.lock().unwrap_or_else(PoisonError::into_inner);
    let plan = match plans.iter().position(right) {
        Some(place) => plans.remove(place),
        None => make(),
    };
    plans.truncate(KEPT - 1);
    plans.insert(0, plan.clone());
    plan
}
