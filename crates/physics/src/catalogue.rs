//! The catalogue: every effect by name. A new effect is one type and one line here.

use common::{AdoptedEffect, Document, procedure};
use nalgebra::Vector3;

use crate::effects::*;
use crate::{About, Acts, Effect, EffectInstance, Error, ParameterInfo, Place, Real, Role, Surroundings};

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

    /// Its parameters.
    pub fn parameters(self) -> &'static [ParameterInfo] {
        self.about().parameters
    }
}

/// The effects that a document's model has adopted.
pub fn adopt(document: &Document) -> Result<Vec<EffectInstance>, Error> {
    let adopted = document.model.iter().flat_map(|model| &model.effects);
    adopted.enumerate().map(|(index, effect)| instance(index, effect)).collect()
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
    Ok(EffectInstance { kind, axis, column, recording: adopted.recording.clone(), parameters })
}
