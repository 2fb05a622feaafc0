use common::covariance::between;
use common::{Axis, Document, Quantity, TemperatureFit, TemperatureOfPart};
use faer::Mat;

use crate::conformity::joint::{Joint, sensor, temperature_paths};
use crate::conformity::spec::{Requirement, Temperatures};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    Sensor,
    Electronics,
}

impl Part {
    pub const BOTH: [Self; 2] = [Part::Sensor, Part::Electronics];

    pub fn required(self, requirement: &Requirement) -> Option<Temperatures> {
        match self {
            Part::Sensor => requirement.sensor_temperature_c,
            Part::Electronics => requirement.electronics_temperature_c,
        }
    }

    pub fn word(self) -> &'static str {
        match self {
            Part::Sensor => "sensor",
            Part::Electronics => "electronics",
        }
    }

    /// The beginnings of the names of its parameters in `temperature.covariance_order`: of the sensitivity,
    /// of the offset.
    pub fn effects(self) -> [&'static str; 2] {
        match self {
            Part::Sensor => ["sensitivity_temperature", "offset_temperature"],
            Part::Electronics => ["sensitivity_electronics_temperature", "offset_electronics_temperature"],
        }
    }
}

/// A range of temperatures that a requirement asks for, as far as the calibration covers it.
pub struct Range {
    /// Lowest and highest less the temperature at which the constants hold, K.
    pub warmer: [f64; 2],
    pub gap: Option<String>,
}

/// What the temperature run of a sensor shows of a part.
fn run(fit: &TemperatureFit, part: Part) -> Option<&TemperatureOfPart> {
    match part {
        Part::Sensor => fit.sensor.as_ref(),
        Part::Electronics => fit.electronics.as_ref(),
    }
}

/// The temperatures that are asked for, cut to those of the sensor's temperature run where there is one. What
/// is missing otherwise, in words.
pub fn asked(document: &Document, axis: Axis, part: Part, asked: &Requirement) -> Result<Range, String> {
    let word = part.word();
    let fit = sensor(document, axis).and_then(|sensor| sensor.temperature.as_deref());
    let stated = document.calibration.as_ref().and_then(|found| found.reference_conditions.as_ref());
    let stated = stated.map(|stated| [stated.sensor_temperature_c, stated.electronics_temperature_c]);
    let of = |pair: [Option<f64>; 2]| pair[part as usize];
    let reference = fit.and_then(|fit| of(fit.reference_c)).or(stated.and_then(of));
    let reference_c = reference.ok_or_else(|| {
        format!("the document does not say at which temperature of the {word} its constants hold (`calibration.reference_conditions`)")
    })?;
    let covered = fit.and_then(|fit| run(fit, part)).map(|part| part.range_c);
    let (range_c, gap) = match (part.required(asked), covered) {
        (Some(Temperatures::Range(range)), None) => (range, None),
        (Some(Temperatures::Range([low, high])), Some([coldest, warmest])) => {
            let gap = (low < coldest || high > warmest).then(|| {
                format!(
                    "the {word} was calibrated from {coldest} to {warmest} degC and not from {low} to {high} degC (a \
                     `temperature_run` as wide would show the rest)"
                )
            });
            ([low.clamp(coldest, warmest), high.clamp(coldest, warmest)], gap)
        }
        (_, Some(range)) => (range, None),
        (_, None) => {
            return Err(format!(
                "there is no calibrated range of the {word}'s temperature; sensorcal finds it from a `temperature_run`"
            ));
        }
    };
    Ok(Range { warmer: range_c.map(|end| end - reference_c), gap })
}

/// What the temperatures do to a sensor's constants, as the document has it.
pub struct Coefficients {
    values: Vec<f64>,
    /// Their names, as `offset_temperature.coefficient_nt_per_k`.
    names: Vec<String>,
    pub paths: Vec<String>,
    covariance: Mat<f64>,
}

impl Coefficients {
    pub fn of(document: &Document, joint: &Joint, axis: Axis) -> Option<Self> {
        let fit = sensor(document, axis)?.temperature.as_deref()?;
        let value = |name: &String| {
            let (effect, parameter) = name.split_once('.')?;
            let of =
                |part: Part| Some((run(fit, part), part.effects().iter().position(|own| *own == effect)?));
            let (found, of) = Part::BOTH.into_iter().find_map(of)?;
            let found = found?;
            let slope = [&found.sensitivity_ppm_per_k, &found.offset_nt_per_k][of];
            let curvature = [&found.sensitivity_ppm_per_k2, &found.offset_nt_per_k2][of];
            let is_curved = parameter.starts_with("curvature");
            if is_curved { curvature.as_ref() } else { Some(slope) }.map(Quantity::value)
        };
        let values: Option<Vec<f64>> = fit.covariance_order.iter().map(value).collect();
        let paths = temperature_paths(axis, fit)?;
        let covariance = joint.covariance(&paths);
        Some(Self { values: values?, names: fit.covariance_order.clone(), paths, covariance })
    }

    pub fn has(&self, part: Part) -> bool {
        self.effects().any(|effect| part.effects().contains(&effect))
    }

    /// The catalogue's names of the effects, once for each parameter.
    pub fn effects(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(|name| name.split_once('.').map_or(name.as_str(), |(effect, _)| effect))
    }

    /// What reading `field_nt` changes by when the parts are so much warmer (K), with its standard
    /// uncertainty, nT: ΔB = Σ_parts (B 10⁻⁶ (c ΔT + q ΔT²) + c' ΔT + q' ΔT²), u² = gᵀ C g.
    pub fn change(&self, field_nt: f64, warmer: &[(Part, f64)]) -> (f64, f64) {
        let by = self.weights(field_nt, warmer);
        let value = by.iter().zip(&self.values).map(|(by, value)| by * value).sum();
        (value, between(&self.covariance, &by, &by).max(0.0).sqrt())
    }

    /// The derivative of that change by each parameter.
    pub fn weights(&self, field_nt: f64, warmer: &[(Part, f64)]) -> Vec<f64> {
        let weight = |name: &String| {
            let (effect, parameter) = name.split_once('.').unwrap_or((name, ""));
            let found = warmer.iter().find(|(part, _)| part.effects().contains(&effect));
            let Some((_, kelvin)) = found else { return 0.0 };
            let scale = if effect.starts_with("sensitivity") { field_nt * 1e-6 } else { 1.0 };
            scale * if parameter.starts_with("curvature") { kelvin * kelvin } else { *kelvin }
        };
        self.names.iter().map(weight).collect()
    }

    /// Temperature less reference at which an offset stands still within a range, K, by the part's own curve.
    pub fn turning(&self, part: Part) -> Option<f64> {
        let of = |parameter: &str| {
            let name = format!("{}.{parameter}_nt_per_k", part.effects()[1]);
            let squared = format!("{name}2");
            let place = self.names.iter().position(|own| *own == name || *own == squared)?;
            Some(self.values[place])
        };
        let (slope, curvature) = (of("coefficient")?, of("curvature")?);
        (curvature != 0.0).then(|| -0.5 * slope / curvature)
    }
}
