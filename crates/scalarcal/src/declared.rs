//! What a document declares of sensors, reference and their noise, before anything is fitted.

use common::{Axis, Document, Instrument, Noise};
use nalgebra::Matrix3;
use physics::{Basic, Unit};

use crate::Options;
use crate::design::Scales;
use crate::kalman::{Form, Memory, WHITE};

/// What is given. Variances are over the square of the magnitude.
pub struct Given<'a> {
    pub document: &'a Document,
    pub options: &'a Options,
    pub unit: Unit,
    pub scales: Scales,
    /// Variance of the declared noise along a sensor, in the mean of the sensors.
    pub sensor: Option<f64>,
    /// Variance of the reference, where one was read.
    pub reference: f64,
    pub mu: Matrix3<f64>,
    /// Whether the magnitude is constant and not known.
    pub constant: bool,
    /// Relative standard uncertainty of a magnitude that is stated with one.
    pub stated: Option<f64>,
}

impl<'a> Given<'a> {
    /// By a document, with a reference that was read.
    pub fn of(document: &'a Document, options: &'a Options, unit: Unit, scales: Scales) -> Self {
        let facility = document.facility.as_ref();
        let std = facility.and_then(|facility| facility.reference_std_nt).unwrap_or(0.0);
        Self {
            document,
            options,
            unit,
            scales,
            sensor: document.instrument.as_ref().and_then(|one| sensor_variance(one, unit, &scales)),
            reference: (std / scales.magnitude_nt).powi(2),
            mu: Basic::found(document, unit).mu,
            constant: false,
            stated: None,
        }
    }
}

fn sensor_variance(instrument: &Instrument, unit: Unit, scales: &Scales) -> Option<f64> {
    let of = |axis: Axis| instrument.noise_of(axis)?.white_rms_nt.filter(|rms| *rms > 0.0);
    let all: Vec<f64> = Axis::ALL.into_iter().filter_map(of).collect();
    let code = scales.sensitivity.map(|k| unit.code_width(Some(instrument)).map_or(0.0, |width| k * width));
    let rounding = code.iter().map(|width| width * width / 12.0).sum::<f64>() / 3.0;
    let mean = all.iter().map(|rms| rms * rms).sum::<f64>() / 3.0;
    (all.len() == 3).then(|| (mean + rounding) / scales.magnitude_nt.powi(2))
}

/// The form of the declared noise, where all three sensors have one; white where it has no memory. `variance`
/// is that of the white noise of a residual.
pub fn declared_form(document: &Document, variance: Option<f64>, scales: &Scales) -> Option<Form> {
    let instrument = document.instrument.as_ref()?;
    let all: Vec<&Noise> = Axis::ALL.into_iter().filter_map(|axis| instrument.noise_of(axis)).collect();
    let white = variance? * scales.magnitude_nt.powi(2);
    let flicker = all.iter().filter_map(|noise| noise.flicker_nt2_per_hz_at_1hz).sum::<f64>() / 3.0;
    let exponent =
        all.iter().map(|noise| noise.flicker_exponent.unwrap_or(1.0)).sum::<f64>() / all.len() as f64;
    Some(if flicker > 0.0 { Form { of: Memory::Sensors, ratio: flicker / white, exponent } } else { WHITE })
}
