//! The catalogue: every effect by name. A new effect is one type and one line here.

use common::{AdoptedEffect, Document, procedure};
use nalgebra::Vector3;

use crate::effects::*;
use crate::{
    About, Acts, Effect, EffectInstance, Error, ParameterInfo, Place, Real, References, Role, Surroundings,
    Thermometer, Within,
};

macro_rules! catalogue {
    ($($effect:ident),+ $(,)?) => {
        /// The effects that fluxcal knows.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Kind {
            $(#[doc = concat!("See the effect `", stringify!($effect), "`.")] $effect,)+
        }

        impl Kind {
            /// All of them, by place.
            pub const ALL: &'static [Kind] = &[$(Kind::$effect),+];

            /// What it says of itself.
            pub fn about(self) -> &'static About {
                match self { $(Kind::$effect => const { &$effect::ABOUT }),+ }
            }

            /// Adds its contribution to a signal; see [`Effect::apply`].
            pub fn apply<T: Real>(
                self,
                parameters: &[T],
                signal: &mut [Vector3<T>],
                around: &Surroundings<'_, T>,
            ) -> Result<(), Error> {
                match self { $(Kind::$effect => $effect::apply(parameters, signal, around)),+ }
            }
        }
    };
}

catalogue![
    QuadraticNonlinearity,
    CubicNonlinearity,
    CrossField,
    CrossFieldSensitivity,
    OffsetTemperature,
    OffsetTemperatureLag,
    OffsetTemperatureInflection,
    SensitivityTemperature,
    SensitivityTemperatureLag,
    AxisTemperature,
    AxisCreep,
    Hysteresis,
    Perming,
    WarmUp,
    Ageing,
    SensitivityAgeing,
    OffsetElectronicsTemperature,
    OffsetElectronicsTemperatureLag,
    SensitivityElectronicsTemperature,
    SensitivityElectronicsTemperatureLag,
    LoopBandwidth,
    Delay,
    Quantisation,
    DifferentialNonlinearity,
    Saturation,
    Clipping,
    ClockOffset,
    ClockRate,
    ReadingStep,
    Spike,
    Dropout,
    CoilTemperature,
    CoilHeating,
    EddyCurrents,
    HardIron,
    SoftIron,
    NullingLeakage,
    CoilGradient,
    OffCentre,
    Mains,
    TractionPower,
    VehiclePass,
    WorkingHours,
    MeasuredTilt,
    StrayCurrent,
    ReactionWheel,
    ReactionWheelHarmonic,
    SunThermoelectric,
    SunThermoelectricHarmonics,
    PillarGradient,
    InductionDifference,
    PillarTilt,
    PillarSettling,
];

impl Kind {
    /// The effect of that name.
    pub fn named(name: &str) -> Option<Kind> {
        Kind::ALL.iter().copied().find(|kind| kind.name() == name)
    }

    /// The same; where there is none, a sentence that lists what there is.
    pub fn known(name: &str) -> Result<Kind, String> {
        Kind::named(name).ok_or_else(|| {
            let names: Vec<&str> = Kind::ALL.iter().map(|kind| kind.name()).collect();
            format!("there is no effect \"{name}\"; expected one of {}", names.join(", "))
        })
    }

    /// Name in documents.
    pub fn name(self) -> &'static str {
        self.about().name
    }

    /// What it belongs to.
    pub fn place(self) -> Place {
        self.about().place
    }

    /// Whether it can act in recordings of a procedure: two sites in differential ones only, nothing of the facility there,
    /// and neither facility nor environment in a shield.
    pub fn acts_in(self, recorded: &str) -> bool {
        let shield = [procedure::SENSOR_NOISE, procedure::SENSOR_OFFSET_REVERSAL, procedure::OFFSET_DRIFT]
            .contains(&recorded);
        let differential = recorded == procedure::DIFFERENTIAL;
        match self.place() {
            Place::Sites => differential,
            Place::Facility => !shield && !differential,
            Place::Environment => !shield,
            _ => true,
        }
    }

    /// Whether what it does to a row follows from that row alone, so that a long series may be cut into pieces.
    pub fn row_by_row(self) -> bool {
        let by_time = [Kind::Ageing, Kind::SensitivityAgeing, Kind::WarmUp, Kind::ReadingStep];
        let ordered = |need: &&str| ["time_s", "rows in the order taken"].contains(need);
        by_time.contains(&self) || !self.about().needs.iter().any(ordered)
    }

    /// The thermometers it follows; it is relative to the reference temperature of each.
    pub fn follows(self) -> impl Iterator<Item = Thermometer> {
        Thermometer::ALL.into_iter().filter(move |which| self.about().needs.contains(&which.column()))
    }

    /// The effect that it is at a special value of its parameters, with fewer of them.
    pub fn simpler(self) -> Option<Kind> {
        match self {
            Kind::OffsetTemperatureLag | Kind::OffsetTemperatureInflection => Some(Kind::OffsetTemperature),
            Kind::SensitivityTemperatureLag => Some(Kind::SensitivityTemperature),
            Kind::AxisCreep => Some(Kind::AxisTemperature),
            Kind::OffsetElectronicsTemperatureLag => Some(Kind::OffsetElectronicsTemperature),
            Kind::SensitivityElectronicsTemperatureLag => Some(Kind::SensitivityElectronicsTemperature),
            Kind::SunThermoelectricHarmonics => Some(Kind::SunThermoelectric),
            _ => None,
        }
    }

    /// Its parameters.
    pub fn parameters(self) -> &'static [ParameterInfo] {
        self.about().parameters
    }
}

/// The effects that a document's model has adopted.
///
/// # Errors
///
/// An effect that is not as the catalogue says, or that is relative to a temperature which the document does not state.
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

/// Writes to `calibration.reference_conditions` what the effects of the document's model are relative to and it does not state
/// yet: what was found from recordings no longer depends on them then.
pub fn state_references(document: &mut Document, references: &References) {
    let listed = document.model.iter().flat_map(|model| &model.effects);
    let followed: Vec<Thermometer> =
        listed.filter_map(|effect| Kind::named(&effect.effect)).flat_map(Kind::follows).collect();
    for which in followed {
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
}

fn instance(index: usize, adopted: &AdoptedEffect) -> Result<EffectInstance, Error> {
    let refuse = |found: String, expected: String| Error::Unknown { index, found, expected };
    let kind = Kind::named(&adopted.effect).ok_or_else(|| {
        let names: Vec<&str> = Kind::ALL.iter().map(|kind| kind.name()).collect();
        refuse(format!("the effect \"{}\"", adopted.effect), format!("one of {}", names.join(", ")))
    })?;
    let without = |key: &str, expected: &str| {
        refuse(format!("{} without \"{key}\"", kind.name()), format!("\"{key}\": {expected}"))
    };
    let one = "\"x\", \"y\" or \"z\"";
    let (axis, column) = match kind.about().acts {
        Acts::OneCoil => (Some(adopted.coil.ok_or_else(|| without("coil", one))?), None),
        Acts::OneSensor => (Some(adopted.sensor.ok_or_else(|| without("sensor", one))?), None),
        Acts::Everything => (None, None),
        Acts::WithColumn => {
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
            if info.role == Role::Shape && value <= 0.0 {
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
