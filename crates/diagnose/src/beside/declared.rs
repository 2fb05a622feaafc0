//! What the instruments' declared noise leaves of a difference, beside what is left.

use common::{Axis, Document, Noise};
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
    /// Of the residual of each axis (nT) at some times; None unless both instruments' noise is declared.
    pub fn of(
        document: &Document,
        recordings: &[String],
        time_s: &[f64],
        residual: &[Vec<f64>],
    ) -> Option<Self> {
        let first = document.recordings.iter().find(|one| recordings.contains(&one.id))?;
        let reference = first.conditions.reference_noise.as_ref()?;
        let instrument = document.instrument.as_ref()?;
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
