//! Effects with the values of their parameters, and those that a document's model has adopted.

use common::{AdoptedEffect, Axis, Document, Recording};
use std::fmt;

use crate::catalogue::Kind;
use crate::effect::{Acts, ParameterInfo, Role};
use crate::{Error, References, Thermometer};

/// When an effect acts, on the campaign's clock.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Within {
    /// From then on, s; absent: from the beginning.
    pub from_s: Option<f64>,
    /// Until then, this moment left out, s; absent: to the end.
    pub to_s: Option<f64>,
}

impl Within {
    /// Whether it acts at all times.
    pub fn is_always(&self) -> bool {
        *self == Self::default()
    }

    /// Whether it acts at a time.
    pub fn holds(&self, time_s: f64) -> bool {
        self.from_s.is_none_or(|from| time_s >= from) && self.to_s.is_none_or(|to| time_s < to)
    }
}

/// An effect with the values of its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectInstance {
    /// Which effect.
    pub kind: Kind,
    /// The coil or sensor that it acts on, for an effect of one.
    pub axis: Option<Axis>,
    /// The housekeeping column that it follows, for an effect that does.
    pub column: Option<String>,
    /// The recording in which it acts; absent: all.
    pub recording: Option<String>,
    /// When it acts there.
    pub within: Within,
    /// Values, in the order of the effect's parameters.
    pub parameters: Vec<f64>,
}

impl EffectInstance {
    /// What it acts on: a sensor or coil, the column that it follows, a recording.
    pub fn target(&self) -> (Option<Axis>, Option<&str>, Option<&str>) {
        (self.axis, self.column.as_deref(), self.recording.as_deref())
    }

    /// Whether another is the same effect, its amplitudes, shapes and moments apart.
    pub fn is_same(&self, other: &Self) -> bool {
        let fixed = |info: &ParameterInfo| info.role == Role::Epoch && !info.is_moment();
        let infos = self.kind.parameters().iter().zip(self.parameters.iter().zip(&other.parameters));
        self.kind == other.kind
            && self.target() == other.target()
            && infos.filter(|(info, _)| fixed(info)).all(|(_, (own, theirs))| own == theirs)
    }

    /// An effect in all recordings at all times, of one coil or sensor or of everything.
    pub fn new(kind: Kind, axis: Option<Axis>, parameters: Vec<f64>) -> Self {
        Self { kind, axis, column: None, recording: None, within: Within::default(), parameters }
    }

    /// The effect that it is at a special value of its parameters, with fewer of them.
    pub fn simpler(&self) -> Option<Kind> {
        let is_current = || self.column.as_ref().is_some_and(|column| Kind::StrayCurrent.takes(column));
        match self.kind {
            Kind::OffsetTemperatureLag | Kind::OffsetTemperatureInflection => Some(Kind::OffsetTemperature),
            Kind::SensitivityTemperatureLag => Some(Kind::SensitivityTemperature),
            Kind::AxisCreep => Some(Kind::AxisTemperature),
            Kind::OffsetElectronicsTemperatureLag => Some(Kind::OffsetElectronicsTemperature),
            Kind::SensitivityElectronicsTemperatureLag => Some(Kind::SensitivityElectronicsTemperature),
            Kind::NullingLeakageAcross => Some(Kind::NullingLeakage),
            Kind::SunThermoelectricHarmonics => Some(Kind::SunThermoelectric),
            Kind::Dependence if is_current() => Some(Kind::StrayCurrent),
            _ => None,
        }
    }

    /// Whether it acts in a recording.
    pub fn acts(&self, recording: &Recording) -> bool {
        self.recording.as_ref().is_none_or(|only| *only == recording.id)
            && self.kind.acts_in(&recording.procedure)
    }
}

impl fmt::Display for EffectInstance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let about = self.kind.about();
        f.write_str(about.title)?;
        let part = match about.acts {
            Acts::OneCoil => self.axis.map(|axis| format!("coil {axis}")),
            _ => self.axis.map(|axis| format!("sensor {axis}")).or_else(|| self.column.clone()),
        };
        let values = about.parameters.iter().zip(&self.parameters);
        let values: Vec<String> = values.map(|(info, value)| format!("{} = {value}", info.name)).collect();
        match part {
            Some(part) => write!(f, " ({part}: {})", values.join(", ")),
            None => write!(f, " ({})", values.join(", ")),
        }
    }
}

/// The effects that a document's model has adopted.
///
/// Errors: an effect that is not as the catalogue says, or that is relative to a temperature which the
/// document does not state.
pub fn adopt(document: &Document) -> Result<Vec<EffectInstance>, Error> {
    let references = References::stated(document);
    let adopted = document.model.iter().flat_map(|model| &model.effects);
    let one = |(index, effect)| {
        let instance = instance(index, effect)?;
        match instance.kind.follows().find(|which| references.temperature_c(*which).is_none()) {
            Some(which) => Err(Error::Unknown {
                index,
                found: format!(
                    "{} without calibration.reference_conditions.{}",
                    instance.kind.name(),
                    which.column()
                ),
                expected: "the temperature in degC to which it is relative".into(),
            }),
            None => Ok(instance),
        }
    };
    adopted.enumerate().map(one).collect()
}

/// Writes to `calibration.reference_conditions` what the effects of the document's model are relative to and
/// it does not state yet: what was found from recordings no longer depends on them then.
pub fn state_references(document: &mut Document, references: &References) {
    let listed = document.model.iter().flat_map(|model| &model.effects);
    let listed: Vec<Kind> = listed.filter_map(|effect| Kind::named(&effect.effect)).collect();
    for which in listed.iter().copied().flat_map(Kind::follows) {
        if let Some(temperature_c) = references.temperature_c(which) {
            let calibration = document.calibration.get_or_insert_default();
            let stated = calibration.reference_conditions.get_or_insert_default();
            let place = match which {
                Thermometer::Sensor => &mut stated.sensor_temperature_c,
                Thermometer::Electronics => &mut stated.electronics_temperature_c,
                Thermometer::Coil => &mut stated.coil_temperature_c,
            };
            place.get_or_insert(temperature_c);
        }
    }
    if listed.into_iter().any(Kind::follows_outside) {
        let calibration = document.calibration.get_or_insert_default();
        let stated = calibration.reference_conditions.get_or_insert_default();
        let places = [&mut stated.outside_x_nt, &mut stated.outside_y_nt, &mut stated.outside_z_nt];
        for (place, field) in places.into_iter().zip(references.outside_nt) {
            *place = place.or(field);
        }
    }
}

fn instance(index: usize, adopted: &AdoptedEffect) -> Result<EffectInstance, Error> {
    let refuse = |found: String, expected: String| Error::Unknown { index, found, expected };
    let unknown =
        || refuse(format!("the effect \"{}\"", adopted.effect), format!("one of {}", Kind::names()));
    let kind = Kind::named(&adopted.effect).ok_or_else(unknown)?;
    let without = |key: &str, expected: &str| {
        refuse(format!("{} without \"{key}\"", kind.name()), format!("\"{key}\": {expected}"))
    };
    let one = "\"x\", \"y\" or \"z\"";
    let (axis, column) = match kind.about().acts {
        Acts::OneCoil => (Some(adopted.coil.ok_or_else(|| without("coil", one))?), None),
        Acts::OneSensor => (Some(adopted.sensor.ok_or_else(|| without("sensor", one))?), None),
        Acts::Everything => (None, None),
        Acts::WithColumn(_) => {
            let column = adopted.column.clone();
            (None, Some(column.ok_or_else(|| without("column", "the name of a housekeeping column"))?))
        }
    };
    if let Some(name) =
        adopted.parameters.keys().find(|name| !kind.parameters().iter().any(|p| p.name == **name))
    {
        let names: Vec<&str> = kind.parameters().iter().map(|info| info.name).collect();
        return Err(refuse(format!("the parameter {name} of {}", kind.name()), names.join(", ")));
    }
    let parameters = kind
        .parameters()
        .iter()
        .map(|info| {
            let found = adopted.parameters.get(info.name).map(common::Quantity::value);
            let value = found.or(info.absent).ok_or_else(|| {
                refuse(
                    format!("{} without the parameter {}", kind.name(), info.name),
                    format!("a number for {}", info.name),
                )
            })?;
            if info.role == Role::Shape && value <= 0.0 && info.absent != Some(value) {
                return Err(refuse(format!("{} = {value}", info.name), "a positive number".into()));
            }
            Ok(value)
        })
        .collect::<Result<_, _>>()?;
    if let (Some(from), Some(to)) = (adopted.from_s, adopted.to_s)
        && from >= to
    {
        let found = format!("{} from {from} s to {to} s", kind.name());
        return Err(refuse(found, "\"from_s\" before \"to_s\"".into()));
    }
    let within = Within { from_s: adopted.from_s, to_s: adopted.to_s };
    Ok(EffectInstance { kind, axis, column, recording: adopted.recording.clone(), within, parameters })
}
