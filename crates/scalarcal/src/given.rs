//! What a document gives before anything is fitted: units, declared noise, and what is known, as rows.

use common::uncertainty::{self, By};
use common::{Axis, Document, Instrument, Noise, Uncertainty};
use faer::{ColRef, Mat};
use nalgebra::Matrix3;
use physics::{Basic, Unit};

use crate::design::Scales;
use crate::kalman::{Form, Memory, WHITE};
use crate::linear::{Linear, root_of_free, unit as one};
use crate::model::{Model, NINE, PAIRS, Parameter};
use crate::read::sensitivity;
use crate::{Error, FitOptions};

/// A combination with less than this share of the largest variance is not known but fixed, and left out.
const FIXED: f64 = 1e-12;
/// Relative standard uncertainty with which a scale that nothing shows is held.
const HELD: f64 = 1e-9;

/// What is given. Variances are over the square of the magnitude.
#[derive(Clone)]
pub struct Given {
    pub unit: Unit,
    pub scales: Scales,
    /// Variance of the declared noise along a sensor, in the mean of the sensors.
    pub sensor: Option<f64>,
    /// A (nT²/Hz at 1 Hz) and α of the noise that an instrument declares, in the mean of the sensors.
    flicker: Option<[f64; 2]>,
    /// Variance of the reference, where one was read.
    pub reference: f64,
    pub mu: Matrix3<f64>,
    /// Whether the magnitude is constant and not known.
    pub constant: bool,
    /// Relative standard uncertainty of a magnitude that is stated with one.
    pub stated: Option<f64>,
    /// The nine parameters as they are stated, and their covariance.
    pub nine: [f64; NINE],
    pub covariance: Mat<f64>,
    /// Parameters of the document, with the derivatives of the nine by each; none where nothing is known.
    pub by: By,
    /// What is known of the nine as rows of the fit: combinations over their standard deviations.
    pub prior: Linear,
    pub known: bool,
}

impl Given {
    /// By a document, with a reference that was read.
    ///
    /// Errors: a stated covariance that none can be.
    pub fn of(document: &Document, options: &FitOptions, unit: Unit, scales: Scales) -> Result<Self, Error> {
        let facility = document.facility.as_ref();
        let std = facility.and_then(|facility| facility.reference_std_nt).unwrap_or(0.0);
        let instrument = document.instrument.as_ref();
        let basic = Basic::found(document, unit);
        let nine = stated(document, unit, &scales);
        let mut by = derivatives(document, &basic, unit, &scales);
        let covariance = Uncertainty::of(document)?.covariance_by(&by);
        let there: Vec<usize> = (0..NINE).filter(|place| covariance[(*place, *place)] > 0.0).collect();
        let prior = if there.is_empty() {
            by.clear();
            Linear::none(NINE)
        } else {
            let own = Mat::from_fn(there.len(), there.len(), |a, b| covariance[(there[a], there[b])]);
            let free = root_of_free(&own, FIXED);
            let at = |place: usize| there.iter().position(|other| *other == place);
            let jacobian =
                Mat::from_fn(free.nrows(), NINE, |i, place| at(place).map_or(0.0, |a| free[(i, a)]));
            let right = (&jacobian * ColRef::from_slice(&nine)).iter().copied().collect();
            Linear { jacobian, right }
        };
        Ok(Self {
            unit,
            scales,
            sensor: instrument.and_then(|one| sensor_variance(one, unit, &scales)),
            flicker: instrument.map(flicker),
            reference: (std / scales.magnitude_nt).powi(2),
            mu: basic.mu,
            constant: false,
            stated: None,
            nine,
            covariance,
            by,
            prior,
            known: options.known,
        })
    }

    /// The form of the declared noise, white without memory; `variance` is that of a residual's white noise.
    pub fn form(&self, variance: f64) -> Option<Form> {
        let [amplitude, exponent] = self.flicker?;
        let white = variance * self.scales.magnitude_nt.powi(2);
        let memory = Form { of: Memory::Sensors, ratio: amplitude / white, exponent };
        Some(if amplitude > 0.0 { memory } else { WHITE })
    }

    pub fn held(&self, model: &Model) -> Linear {
        let count = model.parameters.len();
        match (model.place(&Parameter::Magnitude), self.stated) {
            (Some(place), Some(std)) => {
                let weights: Vec<f64> = one(place, count).iter().map(|one| one / std).collect();
                Linear::one(&weights, 1.0 / std)
            }
            // Only the ratio of magnitude and sensitivities is seen: their mean is held as known.
            (Some(_), None) if self.constant && !self.known => {
                let weights: Vec<f64> = (0..count).map(|j| if j < 3 { 1.0 / HELD } else { 0.0 }).collect();
                Linear::one(&weights, self.nine[..3].iter().sum::<f64>() / HELD)
            }
            _ => Linear::none(count),
        }
    }
}

/// The nine parameters as the document states them; nominal where it does not.
pub fn stated(document: &Document, unit: Unit, scales: &Scales) -> [f64; NINE] {
    let basic = Basic::found(document, unit);
    let mut nine = [0.0; NINE];
    for axis in 0..3 {
        nine[axis] =
            sensitivity(document, unit, Axis::ALL[axis]).map_or(1.0, |k| k / scales.sensitivity[axis]);
        nine[3 + axis] = basic.sensors[axis].offset_nt / scales.magnitude_nt;
    }
    for (place, [a, b]) in PAIRS.iter().enumerate() {
        nine[6 + place] = basic.mu.column(*a).dot(&basic.mu.column(*b));
    }
    nine
}

fn sensor_variance(instrument: &Instrument, unit: Unit, scales: &Scales) -> Option<f64> {
    let of = |axis: Axis| instrument.noise_of(axis)?.white_rms_nt.filter(|rms| *rms > 0.0);
    let all: Vec<f64> = Axis::ALL.into_iter().filter_map(of).collect();
    let code = scales.sensitivity.map(|k| unit.code_width(Some(instrument)).map_or(0.0, |width| k * width));
    let rounding = code.iter().map(|width| width * width / 12.0).sum::<f64>() / 3.0;
    let mean = all.iter().map(|rms| rms * rms).sum::<f64>() / 3.0;
    (all.len() == 3).then(|| (mean + rounding) / scales.magnitude_nt.powi(2))
}

fn flicker(instrument: &Instrument) -> [f64; 2] {
    let all: Vec<&Noise> = Axis::ALL.into_iter().filter_map(|axis| instrument.noise_of(axis)).collect();
    let amplitude = all.iter().filter_map(|noise| noise.flicker_nt2_per_hz_at_1hz).sum::<f64>() / 3.0;
    let exponents = all.iter().map(|noise| noise.flicker_exponent.unwrap_or(1.0));
    [amplitude, exponents.sum::<f64>() / all.len() as f64]
}

/// The derivatives of the nine by the parameters of the document.
fn derivatives(document: &Document, basic: &Basic, unit: Unit, scales: &Scales) -> By {
    let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    let added = |axis: Axis| axes.and_then(|axes| axes.offsets_nt.as_ref()?.get(axis)).is_some();
    let mut by = By::new();
    let single = |place: usize, value: f64| one(place, NINE).iter().map(|one| one * value).collect();
    for axis in Axis::ALL {
        let k = axis.index();
        by.push((uncertainty::sensitivity(axis, unit.suffix()), single(k, 1.0 / scales.sensitivity[k])));
        // What axescal adds stands for the sum, where it is there.
        let path =
            if added(axis) { uncertainty::added_offset(axis) } else { uncertainty::sensor_offset(axis) };
        by.push((path, single(3 + k, 1.0 / scales.magnitude_nt)));
    }
    // The paths run over the cosines column by column: of column c, row r.
    for (number, path) in uncertainty::directions("sensors").into_iter().enumerate() {
        let (row, column) = (number % 3, number / 3);
        let mut moved = vec![0.0; NINE];
        for (place, [a, b]) in PAIRS.iter().enumerate() {
            if *a == column {
                moved[6 + place] += basic.mu[(row, *b)];
            }
            if *b == column {
                moved[6 + place] += basic.mu[(row, *a)];
            }
        }
        by.push((path, moved));
    }
    by
}
