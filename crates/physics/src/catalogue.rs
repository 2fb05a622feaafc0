//! The catalogue: every effect by name. A new effect is its name here and what it does in `effects`.

use common::procedure;
use nalgebra::Vector3;

use crate::effect::{Effect, Surroundings};
use crate::{About, Acts, ParameterInfo, Place, Real, Result, Thermometer};

macro_rules! catalogue {
    ($($effect:ident),+ $(,)?) => {
        /// The effects that fluxcal knows.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Kind {
            $(#[doc = concat!("See the effect `", stringify!($effect), "`.")] $effect,)+
        }

        $(
            #[doc = concat!("The effect `", stringify!($effect), "`.")]
            pub(crate) struct $effect;
        )+

        impl Kind {
            /// All of them, by place.
            pub const ALL: &'static [Kind] = &[$(Kind::$effect),+];

            /// What it says of itself.
            pub fn about(self) -> &'static About {
                match self { $(Kind::$effect => const { &$effect::ABOUT }),+ }
            }

            /// Whether the chain can be run backwards through it.
            pub fn invertible(self) -> bool {
                match self { $(Kind::$effect => $effect::INVERTIBLE),+ }
            }

            /// Adds its contribution to a signal; see [`Effect::apply`].
            pub(crate) fn apply<T: Real>(
                self,
                parameters: &[T],
                signal: &mut [Vector3<T>],
                around: &Surroundings<'_, T>,
            ) -> Result {
                match self { $(Kind::$effect => $effect::apply(parameters, signal, around)),+ }
            }
        }
    };
}

catalogue! {
    // The sensors.
    QuadraticNonlinearity, CubicNonlinearity, CrossField, CrossFieldSensitivity, OffsetTemperature,
    OffsetTemperatureLag, OffsetTemperatureInflection, SensitivityTemperature, SensitivityTemperatureLag,
    AxisTemperature, AxisCreep, Hysteresis, Perming, WarmUp, Ageing, SensitivityAgeing, Dependence,
    Empirical,
    // Their electronics.
    OffsetElectronicsTemperature, OffsetElectronicsTemperatureLag, SensitivityElectronicsTemperature,
    SensitivityElectronicsTemperatureLag, LoopBandwidth, Delay, Quantisation, DifferentialNonlinearity,
    Saturation, Clipping,
    // The logger.
    ClockOffset, ClockRate, ReadingStep, Spike, Dropout,
    // The facility.
    CoilTemperature, CoilHeating, EddyCurrents, HardIron, SoftIron, NullingLeakage, NullingLeakageAcross,
    CoilGradient, OffCentre,
    // What surrounds it.
    Mains, TractionPower, PeriodicField, VehiclePass, WorkingHours, MeasuredTilt,
    // The spacecraft.
    StrayCurrent, ReactionWheel, ReactionWheelHarmonic, SunThermoelectric, SunThermoelectricHarmonics,
    // The sites of two instruments.
    PillarGradient, InductionDifference, PillarTilt, PillarSettling,
}

impl Kind {
    /// The effect of that name.
    pub fn named(name: &str) -> Option<Kind> {
        Kind::ALL.iter().copied().find(|kind| kind.name() == name)
    }

    /// The same; where there is none, a sentence that lists what there is.
    pub fn known(name: &str) -> Result<Kind, String> {
        let expected = || format!("there is no effect \"{name}\"; expected one of {}", Kind::names());
        Kind::named(name).ok_or_else(expected)
    }

    /// The names of all.
    pub(crate) fn names() -> String {
        Kind::ALL.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", ")
    }

    /// Name in documents.
    pub fn name(self) -> &'static str {
        self.about().name
    }

    /// What it belongs to.
    pub fn place(self) -> Place {
        self.about().place
    }

    /// Whether it can act in recordings of a procedure: two sites in differential ones only, nothing of the
    /// facility there, and neither facility nor environment in a shield.
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

    /// Whether what it does to a row follows from that row alone, so that series may be cut.
    pub fn row_by_row(self) -> bool {
        let by_time = [Kind::Ageing, Kind::SensitivityAgeing, Kind::WarmUp, Kind::ReadingStep];
        let ordered = |need: &&str| ["time_s", "rows in the order taken"].contains(need);
        by_time.contains(&self) || !self.about().needs.iter().any(ordered)
    }

    /// Whether it can follow a column: one of its unit that no other effect and no chain knows.
    pub fn takes(self, column: &str) -> bool {
        matches!(self.about().acts, Acts::WithColumn(ending) if column.ends_with(ending)) && !is_known(column)
    }

    /// The thermometers it follows; it is relative to the reference temperature of each.
    pub fn follows(self) -> impl Iterator<Item = Thermometer> {
        Thermometer::ALL.into_iter().filter(move |which| self.about().needs.contains(&which.column()))
    }

    /// Whether it follows the field outside.
    pub fn follows_outside(self) -> bool {
        self.about().needs.iter().any(|need| need.starts_with("outside_"))
    }

    /// Its parameters.
    pub fn parameters(self) -> &'static [ParameterInfo] {
        self.about().parameters
    }
}

/// Whether a column is a quantity of the chain or of effects that name it.
fn is_known(column: &str) -> bool {
    const KNOWN: [&str; 11] = [
        "coil_",
        "sensor_",
        "reference_",
        "test_",
        "outside_",
        "ambient_",
        "attitude_",
        "tilt_",
        "sun",
        "eclipse",
        "field_",
    ];
    KNOWN.iter().any(|prefix| column.starts_with(prefix))
        || ["time_s", "position", "position_m", "electronics_temperature_c"].contains(&column)
}
