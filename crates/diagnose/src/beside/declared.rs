//! What the instruments' declared noise leaves of a difference, beside what is left.

use common::{Axis, Instrument, Noise, NoiseOfSensors};
use noise::Whitening;

use crate::level::Rest;
use crate::whitening::known_freedom;

/// The declared noise of a difference.
pub struct Declared {
    /// Rms of a reading of each axis, nT.
    pub rms_nt: Vec<f64>,
    /// What is left, whitened by it.
    pub rest: Rest,
}

impl Declared {
    /// Of the test instrument and the reference's noise beside the residual of each axis (nT) at some times; None unless
    /// both have noise that is declared.
    pub fn of(
        (instrument, reference): (&Instrument, &NoiseOfSensors),
        time_s: &[f64],
        residual: &[Vec<f64>],
    ) -> Option<Self> {
        let code = instrument.quantisation_nt.unwrap_or(0.0) / 12.0_f64.sqrt();
        let length_s = time_s.last()? - time_s.first()?;
        let (mut noises, mut rms_nt, mut sum_of_squares, mut freedom) = (Vec::new(), Vec::new(), 0.0, 0.0);
        for (axis, residual) in Axis::ALL.into_iter().zip(residual) {
            let rounded = Noise { white_rms_nt: Some(code), ..Noise::default() };
            let both = [instrument.noise_of(axis)?.clone(), reference.of(axis)?.clone(), rounded];
            let whitening = Whitening::of_sum(&both, Some(time_s), time_s.len(), length_s).ok()?;
            rms_nt.push(whitening.variance_nt2().sqrt());
            sum_of_squares += whitening.whiten(residual).iter().map(|white| white * white).sum::<f64>();
            freedom += residual.len() as f64;
            noises.extend(both.into_iter().take(2).map(Some));
        }
        Some(Self { rms_nt, rest: Rest { sum_of_squares, freedom, known: known_freedom(&noises) } })
    }
}
