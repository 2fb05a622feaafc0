use super::prelude::*;
use crate::context::Thermometer;
use crate::memory::{Before, Signal};

/// What the temperature moves.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Of {
    Offset,
    Sensitivity,
}

/// ΔB of an effect of temperature: c ΔT + q ΔT², or c ΔT_lag; for the sensitivity in ppm of the field B.
pub(super) fn add<T: Real>(
    of: Of,
    change: impl Fn(usize) -> T,
    signal: &mut [Vector3<T>],
    around: &Surroundings<'_, T>,
) {
    let own = around.own(signal).enumerate();
    match of {
        Of::Offset => own.for_each(|(row, own)| *own += change(row)),
        Of::Sensitivity => own.for_each(|(row, own)| *own += *own * change(row) * 1e-6),
    }
}

/// What a thermometer reads above its reference, through a first-order lag in equilibrium at the first row,
/// K.
pub(super) fn late_warmth<T: Real>(
    context: &Context<'_>,
    which: Thermometer,
    who: &str,
    lag_s: T,
) -> Result<Vec<T>> {
    let time = context.times(who)?;
    let (column, reference) = context.temperature(which, who)?;
    let warmer = column.iter().map(|t| T::from(t - reference)).collect();
    Ok(Signal::new(time, warmer).lagged(lag_s, Before::Equilibrium))
}

const OFFSET: ParameterInfo = ParameterInfo::amplitude("coefficient_nt_per_k", 0.005, 5.0);
const OFFSET_CURVATURE: ParameterInfo = ParameterInfo::amplitude("curvature_nt_per_k2", 0.0001, 0.1);
const SENSITIVITY: ParameterInfo = ParameterInfo::amplitude("coefficient_ppm_per_k", 0.2, 200.0);
const SENSITIVITY_CURVATURE: ParameterInfo = ParameterInfo::amplitude("curvature_ppm_per_k2", 0.002, 2.0);
const LAG: ParameterInfo = ParameterInfo::shape("lag_s", 10.0, 10_000.0);

/// A temperature that the sensitivity or the offset follows.
struct Followed {
    effect: &'static str,
    thermometer: Thermometer,
    of: Of,
}

impl Followed {
    /// At once, with a curvature.
    fn at_once<T: Real>(
        self,
        parameters: &[T],
        signal: &mut [Vector3<T>],
        around: &Surroundings<'_, T>,
    ) -> Result {
        let (column, reference) = around.context.temperature(self.thermometer, self.effect)?;
        let change = |row: usize| {
            let warmer = column[row] - reference;
            (parameters[0] + parameters[1] * warmer) * warmer
        };
        add(self.of, change, signal, around);
        Ok(())
    }

    /// Through a first-order lag.
    fn late<T: Real>(
        self,
        parameters: &[T],
        signal: &mut [Vector3<T>],
        around: &Surroundings<'_, T>,
    ) -> Result {
        let warmer = late_warmth(around.context, self.thermometer, self.effect, parameters[1])?;
        add(self.of, |row| parameters[0] * warmer[row], signal, around);
        Ok(())
    }
}

/// An effect that follows the temperature of `$place`.
macro_rules! follows {
    (
        $(#[$doc:meta])*
        $effect:ident = $name:literal,
        $of:ident of $place:ident $how:ident, [$($parameter:expr),+], needs [$($time:literal)?],
        title: $title:literal,
        physics: $physics:literal,
        equation: $equation:literal,
        source: $source:literal,
    ) => {
        $(#[$doc])*
        pub struct $effect;

        impl Effect for $effect {
            const ABOUT: About = About {
                name: $name,
                title: $title,
                physics: $physics,
                equation: $equation,
                source: $source,
                parameters: &[$($parameter),+],
                needs: &[$($time,)? Thermometer::$place.column()],
                ..About::of(Family::FollowsColumn, Place::$place, Stage::$place, Acts::OneSensor)
            };

            fn apply<T: Real>(
                parameters: &[T],
                signal: &mut [Vector3<T>],
                around: &Surroundings<'_, T>,
            ) -> Result {
                let followed = Followed { effect: $name, thermometer: Thermometer::$place, of: Of::$of };
                followed.$how(parameters, signal, around)
            }
        }
    };
}

follows! {
    /// ΔB = c (T_S − T_ref) + q (T_S − T_ref)², nT along the sensor (NASA eq. 29, with curvature).
    OffsetTemperature = "offset_temperature",
    Offset of Sensor at_once, [OFFSET, OFFSET_CURVATURE], needs [],
    title: "offset follows sensor temperature",
    physics: "Warming changes the stress in the core and the balance of the windings, and the sensor's offset moves.",
    equation: "dB = c (T_S - T_ref) + q (T_S - T_ref)^2",
    source: "NASA CR-156638, eq. 29; Primdahl 1979, The fluxgate magnetometer, J. Phys. E 12, 241",
}

follows! {
    /// ΔB = c (T_lag − T_ref), τ dT_lag/dt = T_S − T_lag, in equilibrium at the first row; nT along the
    /// sensor.
    OffsetTemperatureLag = "offset_temperature_lag",
    Offset of Sensor late, [OFFSET, LAG], needs ["time_s"],
    title: "offset follows sensor temperature with a lag",
    physics: "The core or its support warms later than the thermometer beside it, and the sensor's offset moves with the \
        core's temperature.",
    equation: "dB = c (T_lag - T_ref), tau dT_lag/dt = T_S - T_lag",
    source: "Primdahl 1979, The fluxgate magnetometer, J. Phys. E 12, 241",
}

follows! {
    /// ΔB = B (c (T_S − T_ref) + q (T_S − T_ref)²), c in ppm/K, q in ppm/K².
    SensitivityTemperature = "sensitivity_temperature",
    Sensitivity of Sensor at_once, [SENSITIVITY, SENSITIVITY_CURVATURE], needs [],
    title: "sensitivity follows sensor temperature",
    physics: "The feedback coil and its former expand, and the same feedback current balances another field.",
    equation: "dB = B (c (T_S - T_ref) + q (T_S - T_ref)^2) 1e-6",
    source: "NASA CR-156638, eq. 29; Tøffner-Clausen et al. 2016, In-flight scalar calibration and characterisation of the Swarm magnetometry package, Earth Planets Space 68, 129",
}

follows! {
    /// ΔB = B c (T_lag − T_ref), τ dT_lag/dt = T_S − T_lag, in equilibrium at the first row; c in ppm/K.
    SensitivityTemperatureLag = "sensitivity_temperature_lag",
    Sensitivity of Sensor late, [SENSITIVITY, LAG], needs ["time_s"],
    title: "sensitivity follows sensor temperature with a lag",
    physics: "The feedback coil warms later than the thermometer beside it, and the sensitivity moves with its size.",
    equation: "dB = B c (T_lag - T_ref) 1e-6, tau dT_lag/dt = T_S - T_lag",
    source: "NASA CR-156638, eq. 29; Acuña 2002, Space-based magnetometers, Rev. Sci. Instrum. 73, 3717",
}

follows! {
    /// ΔB = c (T_E − T_ref) + q (T_E − T_ref)², nT along the sensor (NASA eq. 29, with curvature).
    OffsetElectronicsTemperature = "offset_electronics_temperature",
    Offset of Electronics at_once, [OFFSET, OFFSET_CURVATURE], needs [],
    title: "offset follows electronics temperature",
    physics: "Offsets of amplifiers and the symmetry of the excitation drift with the temperature of the electronics.",
    equation: "dB = c (T_E - T_ref) + q (T_E - T_ref)^2",
    source: "NASA CR-156638, eq. 29; Acuña 2002, Space-based magnetometers, Rev. Sci. Instrum. 73, 3717",
}

follows! {
    /// ΔB = c (T_lag − T_ref), τ dT_lag/dt = T_E − T_lag, in equilibrium at the first row; nT along the
    /// sensor.
    OffsetElectronicsTemperatureLag = "offset_electronics_temperature_lag",
    Offset of Electronics late, [OFFSET, LAG], needs ["time_s"],
    title: "offset follows electronics temperature with a lag",
    physics: "The part that drifts warms later than the thermometer on the board.",
    equation: "dB = c (T_lag - T_ref), tau dT_lag/dt = T_E - T_lag",
    source: "Acuña 2002, Space-based magnetometers, Rev. Sci. Instrum. 73, 3717",
}

follows! {
    /// ΔB = B (c (T_E − T_ref) + q (T_E − T_ref)²), c in ppm/K, q in ppm/K².
    SensitivityElectronicsTemperature = "sensitivity_electronics_temperature",
    Sensitivity of Electronics at_once, [SENSITIVITY, SENSITIVITY_CURVATURE], needs [],
    title: "sensitivity follows electronics temperature",
    physics: "The voltage reference and the resistors that turn the feedback into the output drift with temperature.",
    equation: "dB = B (c (T_E - T_ref) + q (T_E - T_ref)^2) 1e-6",
    source: "NASA CR-156638, eq. 29; Acuña 2002, Space-based magnetometers, Rev. Sci. Instrum. 73, 3717",
}

follows! {
    /// ΔB = B c (T_lag − T_ref), τ dT_lag/dt = T_E − T_lag, in equilibrium at the first row; c in ppm/K.
    SensitivityElectronicsTemperatureLag = "sensitivity_electronics_temperature_lag",
    Sensitivity of Electronics late, [SENSITIVITY, LAG], needs ["time_s"],
    title: "sensitivity follows electronics temperature with a lag",
    physics: "The voltage reference warms later than the thermometer on the board.",
    equation: "dB = B c (T_lag - T_ref) 1e-6, tau dT_lag/dt = T_E - T_lag",
    source: "Acuña 2002, Space-based magnetometers, Rev. Sci. Instrum. 73, 3717",
}
