//! One piece of physics that is concealed, ready to act in a campaign.

use nalgebra::Vector3;
use std::sync::Arc;

use crate::scene::{AXES, Campaign, Readings, Run};

/// What an effect adds to the readings, nT: of the campaign, of what the converters get without it (B − O,
/// nT), and of a size.
pub type Act = Arc<dyn Fn(&Campaign, &Readings, f64) -> Readings + Send + Sync>;

/// Parameters in the catalogue's names at a size.
pub type Parameters = Arc<dyn Fn(f64) -> Vec<(&'static str, f64)> + Send + Sync>;

/// One effect.
#[derive(Clone)]
pub struct Effect {
    /// The finer physics in words.
    pub physics: &'static str,
    /// The catalogue's names for it, with what it acts on: each of them is right. Empty where the catalogue
    /// has none.
    pub accepted: Vec<String>,
    /// The sensors that show it; empty where it is in the field and all may.
    pub sensors: Vec<usize>,
    /// What it adds.
    pub act: Act,
    /// What the catalogue's parameters should come out as, where the finer physics has a counterpart.
    pub parameters: Parameters,
    /// Whether it is the converter's, and acts on readings that have their noise.
    pub on_codes: bool,
}

impl Effect {
    /// Physics with the catalogue's names for it.
    pub fn new(physics: &'static str, accepted: Vec<String>, act: Act) -> Self {
        Self {
            physics,
            accepted,
            sensors: Vec::new(),
            act,
            parameters: Arc::new(|_| Vec::new()),
            on_codes: false,
        }
    }

    /// In one sensor.
    pub fn in_sensor(mut self, sensor: usize) -> Self {
        self.sensors = vec![sensor];
        self
    }

    /// With parameters.
    pub fn with(mut self, of: impl Fn(f64) -> Vec<(&'static str, f64)> + Send + Sync + 'static) -> Self {
        self.parameters = Arc::new(of);
        self
    }

    /// In the converter.
    pub fn of_codes(mut self) -> Self {
        self.on_codes = true;
        self
    }
}

/// A name with what it acts on.
pub fn named(effect: &str, axis: usize) -> String {
    format!("{effect} {}", AXES[axis])
}

/// Something that one sensor's readings get: of the run, the sensor's plain readings and the size, for each
/// row.
pub fn on_sensor(
    sensor: usize,
    of: impl Fn(&Campaign, &Run, &[f64], f64) -> Vec<f64> + Send + Sync + 'static,
) -> Act {
    Arc::new(move |campaign, plain, size| {
        let one = |(run, plain): (&Run, &[Vec<f64>; 3])| {
            let mut readings = [0; 3].map(|_| vec![0.0; run.times.len()]);
            readings[sensor] = of(campaign, run, &plain[sensor], size);
            readings
        };
        campaign.runs.iter().zip(plain).map(one).collect()
    })
}

/// A field in GEO at each row (of a pair: in the reference's frame).
pub fn in_geo(of: impl Fn(&Campaign, &Run, f64) -> Vec<Vector3<f64>> + Send + Sync + 'static) -> Act {
    Arc::new(move |campaign, _, size| {
        let one = |run: &Run| {
            let mut readings = [0; 3].map(|_| Vec::with_capacity(run.times.len()));
            for (field, t) in of(campaign, run, size).iter().zip(&run.times) {
                let felt = run.geo_to_sensors(&campaign.bench, *t, field);
                readings.iter_mut().zip(felt).for_each(|(column, value)| column.push(value));
            }
            readings
        };
        campaign.runs.iter().map(one).collect()
    })
}

/// A field in SEN at each row.
pub fn in_block(of: impl Fn(&Campaign, &Run, f64) -> Vec<Vector3<f64>> + Send + Sync + 'static) -> Act {
    Arc::new(move |campaign, _, size| {
        let one = |run: &Run| {
            let mut readings = [0; 3].map(|_| Vec::with_capacity(run.times.len()));
            for field in of(campaign, run, size) {
                for (sensor, column) in readings.iter_mut().enumerate() {
                    column.push(run.sensor_axis(&campaign.bench, sensor).dot(&field));
                }
            }
            readings
        };
        campaign.runs.iter().map(one).collect()
    })
}
