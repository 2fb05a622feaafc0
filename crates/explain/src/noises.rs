//! The forms of noise that are weighed with the names.

use common::Noise;

/// Exponents of the part with memory, and by how many times it exceeds the white part at the frequency of
/// twenty steps.
const EXPONENTS: [f64; 3] = [1.0, 1.5, 2.0];
const RATIOS: [f64; 5] = [0.03, 0.3, 3.0, 30.0, 300.0];
/// That frequency, in cycles a step.
const AT: f64 = 0.05;

/// Noise for a white part of one: S(f) = 2 Δt (1 + r (0.05/(f Δt))^α), one-sided. An exponent of two is a random
/// walk, whose state needs no memory of the time before the first row: a level stands for it.
pub fn grid(step_s: f64) -> Vec<Noise> {
    let white = Noise { white_rms_nt: Some(1.0), ..Noise::default() };
    let with = |exponent: f64, ratio: f64| {
        let amplitude = ratio * 2.0 * step_s * (AT / step_s).powf(exponent);
        if exponent == 2.0 {
            // Density r²/(2π²f²).
            let walk = (2.0 * amplitude).sqrt() * std::f64::consts::PI;
            return Noise { random_walk_nt_per_sqrt_s: Some(walk), ..white.clone() };
        }
        Noise {
            flicker_nt2_per_hz_at_1hz: Some(amplitude),
            flicker_exponent: Some(exponent),
            ..white.clone()
        }
    };
    let red = EXPONENTS.iter().flat_map(|exponent| RATIOS.map(|ratio| with(*exponent, ratio)));
    [white.clone()].into_iter().chain(red).collect()
}
