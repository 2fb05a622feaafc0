//! Discrete Fourier transforms of real series: realfft, compiled here once and not in each crate that uses
//! it, unscaled: x → X → x gives N x. And the cosine transform, which is made of it.

mod cosine;

use std::sync::{Arc, Mutex, PoisonError};

pub use cosine::Cosine;
pub use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

/// Transforms of a length are asked for again and again, and making one takes as long as using it: so many of
/// those used last are kept, and more that have no more than so many points together.
const KEPT: usize = 4;
const KEPT_POINTS: usize = 1 << 20;

/// Plans with their lengths, that used last at the front.
type Plans<T> = Mutex<Vec<(usize, Arc<T>)>>;

static FORWARD: Plans<dyn RealToComplex<f64>> = Mutex::new(Vec::new());
static INVERSE: Plans<dyn ComplexToReal<f64>> = Mutex::new(Vec::new());

/// N real numbers to N/2 + 1 complex ones, X(k) = Σ x(n) exp(-2πi kn/N).
pub fn forward(mut series: Vec<f64>) -> Vec<Complex<f64>> {
    let points = series.len();
    let plan = kept(&FORWARD, points, || RealFftPlanner::new().plan_fft_forward(points));
    let mut spectrum = plan.make_output_vec();
    plan.process(&mut series, &mut spectrum).expect("buffers of the plan's lengths");
    spectrum
}

/// N/2 + 1 complex numbers back to N = `points` real ones. Imaginary parts at zero and at the Nyquist
/// frequency, which a real series has not, do not count.
///
/// Panics: unless there are as many numbers.
pub fn inverse(mut spectrum: Vec<Complex<f64>>, points: usize) -> Vec<f64> {
    let plan = kept(&INVERSE, points, || RealFftPlanner::new().plan_fft_inverse(points));
    let mut series = plan.make_output_vec();
    spectrum[0].im = 0.0;
    if points.is_multiple_of(2) {
        spectrum[points / 2].im = 0.0;
    }
    plan.process(&mut spectrum, &mut series).expect("buffers of the plan's lengths, real ends");
    series
}

/// One of those that are kept, or a new one in place of those that were not used for longest.
fn kept<T: ?Sized>(plans: &Plans<T>, points: usize, make: impl FnOnce() -> Arc<T>) -> Arc<T> {
    let mut plans = plans.lock().unwrap_or_else(PoisonError::into_inner);
    let plan = match plans.iter().position(|(length, _)| *length == points) {
        Some(place) => plans.remove(place).1,
        None => make(),
    };
    plans.insert(0, (points, plan.clone()));
    let (mut number, mut sum) = (0, 0);
    plans.retain(|(length, _)| {
        (number, sum) = (number + 1, sum + length);
        number <= KEPT || sum <= KEPT_POINTS
    });
    plan
}
