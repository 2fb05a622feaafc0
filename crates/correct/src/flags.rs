//! What is to be known of a corrected row besides its uncertainty, as a sum of bits in the column
//! `field_flags`.

use common::{Axis, Document};
use nalgebra::Vector3;
use physics::{Context, References, Thermometer};

/// A reading is missing; there is no field.
pub const MISSING: u32 = 1;
/// The chain cannot be run backwards, or no baseline is adopted; there is no field.
pub const NOT_INVERTIBLE: u32 = 2;
/// A temperature is outside those at which the sensors were calibrated.
pub const TEMPERATURE: u32 = 4;
/// The field along a sensor is beyond those at which it was calibrated.
pub const RANGE: u32 = 8;
/// An effect of the model is not taken out: the recording lacks what it follows.
pub const EFFECT_LEFT: u32 = 16;

/// Every flag with what it says.
pub const MEANINGS: [(u32, &str); 5] = [
    (MISSING, "a reading is missing"),
    (NOT_INVERTIBLE, "the model cannot be inverted, or no baseline is adopted"),
    (TEMPERATURE, "a temperature is outside the calibrated range"),
    (RANGE, "the field is outside the calibrated range"),
    (EFFECT_LEFT, "an effect of the model could not be corrected"),
];

/// Without a temperature run a calibration is taken to hold so far around its reference temperature, K: the
/// smallest step of NASA's temperature runs.
const WITHOUT_RUN_K: f64 = 5.0;
/// What a span of calibrated fields may be exceeded by, as a share of it.
const RANGE_MARGIN: f64 = 0.01;
/// What a span of calibrated temperatures may be exceeded by, K.
const TEMPERATURE_MARGIN_K: f64 = 0.5;

/// Where a calibration holds.
#[derive(Clone, Debug)]
pub struct Limits {
    /// Lowest and highest field along each sensor, nT.
    fields_nt: [Option<[f64; 2]>; 3],
    /// Lowest and highest temperature of sensors and electronics, degC.
    temperatures_c: [(Thermometer, Option<[f64; 2]>); 2],
}

impl Limits {
    /// As a document says: the fields of each sensor's `sensitivity`, in their absence `instrument.range_nt`;
    /// the temperatures of their `temperature`, in their absence those around the reference.
    pub fn of(document: &Document, references: &References) -> Self {
        let sensor = |axis| document.calibration.as_ref().and_then(|calibration| calibration.sensor(axis));
        let nominal = document.instrument.as_ref().and_then(|i| i.range_nt).map(|range| [-range, range]);
        let fields_nt = Axis::ALL.map(|axis| {
            let fit = sensor(axis).and_then(|sensor| sensor.sensitivity.as_ref());
            fit.and_then(|fit| span(&fit.residuals.field_nt)).or(nominal)
        });
        let run = |which: Thermometer| {
            let spans = Axis::ALL.into_iter().filter_map(|axis| {
                let run = sensor(axis)?.temperature.as_ref()?;
                let part = if which == Thermometer::Sensor { &run.sensor } else { &run.electronics };
                Some(part.as_ref()?.range_c)
            });
            // All three sensors hold where each of them does.
            spans.reduce(|a, b| [a[0].max(b[0]), a[1].min(b[1])])
        };
        let around = |reference: Option<f64>| reference.map(|t| [t - WITHOUT_RUN_K, t + WITHOUT_RUN_K]);
        let temperatures_c = [
            (Thermometer::Sensor, run(Thermometer::Sensor).or(around(references.sensor_c))),
            (Thermometer::Electronics, run(Thermometer::Electronics).or(around(references.electronics_c))),
        ];
        Self { fields_nt, temperatures_c }
    }

    /// The flags of temperature for each row of a recording.
    pub fn temperatures(&self, context: &Context<'_>) -> Vec<u32> {
        let mut flags = vec![0; context.rows];
        for (which, span) in &self.temperatures_c {
            let (Some([low, high]), Some(column)) = (span, context.optional(which.column())) else {
                continue;
            };
            for (flags, t) in flags.iter_mut().zip(column.iter()) {
                if *t < low - TEMPERATURE_MARGIN_K || *t > high + TEMPERATURE_MARGIN_K {
                    *flags |= TEMPERATURE;
                }
            }
        }
        flags
    }

    /// The flag of a field along the sensors, nT.
    pub fn field(&self, along_nt: &Vector3<f64>) -> u32 {
        let beyond = |(value, span): (&f64, &Option<[f64; 2]>)| {
            span.is_some_and(|[low, high]| {
                let margin = RANGE_MARGIN * (high - low) / 2.0;
                *value < low - margin || *value > high + margin
            })
        };
        if along_nt.iter().zip(&self.fields_nt).any(beyond) { RANGE } else { 0 }
    }
}

fn span(series: &[f64]) -> Option<[f64; 2]> {
    let known = series.iter().copied().filter(|value| value.is_finite());
    known.fold(None, |span: Option<[f64; 2]>, value| {
        let [low, high] = span.unwrap_or([value, value]);
        Some([low.min(value), high.max(value)])
    })
}
