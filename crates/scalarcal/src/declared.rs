//! What a document declares of the noise of sensors and reference.

use common::{Axis, Document, Noise};
use physics::Unit;

use crate::design::Scales;
use crate::kalman::{Form, Memory, WHITE};

/// Variance of the reference over the square of the magnitude, where one was read.
pub fn reference_variance(document: &Document, read: bool, scales: &Scales) -> f64 {
    let std = document.facility.as_ref().and_then(|facility| facility.reference_std_nt).filter(|_| read);
    (std.unwrap_or(0.0) / scales.magnitude_nt).powi(2)
}

/// Variance of the declared noise along a sensor over the square of the magnitude, in the mean of the
/// sensors.
pub fn sensor_variance(document: &Document, unit: Unit, scales: &Scales) -> Option<f64> {
    let instrument = document.instrument.as_ref()?;
    let of = |axis: Axis| instrument.noise_of(axis)?.white_rms_nt.filter(|rms| *rms > 0.0);
    let all: Vec<f64> = Axis::ALL.into_iter().filter_map(of).collect();
    let code = scales.sensitivity.map(|k| unit.code_width(Some(instrument)).map_or(0.0, |width| k * width));
    let rounding = code.iter().map(|width| width * width / 12.0).sum::<f64>() / 3.0;
    let mean = all.iter().map(|rms| rms * rms).sum::<f64>() / 3.0;
    (all.len() == 3).then(|| (mean + rounding) / scales.magnitude_nt.powi(2))
}

/// The form of the declared noise, where all three sensors have one; white where it has no memory.
pub fn declared_form(document: &Document, variance: Option<f64>, scales: &Scales) -> Option<Form> {
    let instrument = document.instrument.as_ref()?;
    let all: Vec<&Noise> = Axis::ALL.into_iter().filter_map(|axis| instrument.noise_of(axis)).collect();
    let white = variance? * scales.magnitude_nt.powi(2);
    let flicker = all.iter().filter_map(|noise| noise.flicker_nt2_per_hz_at_1hz).sum::<f64>() / 3.0;
    let exponent =
        all.iter().map(|noise| noise.flicker_exponent.unwrap_or(1.0)).sum::<f64>() / all.len() as f64;
    Some(if flicker > 0.0 { Form { of: Memory::Sensors, ratio: flicker / white, exponent } } else { WHITE })
}
