use super::prelude::*;
use crate::context::Thermometer;
use crate::memory::{Before, Signal};

/// What the temperature moves.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Of {
    Offset,
    Sensitivity,
}

/// Adds a change of the offset in nT, or of the sensitivity in ppm of the field, to each row.
pub(super) fn add<T: Real>(of: Of, change: Vec<T>, signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) {
    let own = around.own(signal).zip(change);
    match of {
        Of::Offset => own.for_each(|(own, change)| *own += change),
        Of::Sensitivity => own.for_each(|(own, change)| *own += *own * change * 1e-6),
    }
}

/// What a thermometer reads above its reference, lagged, in equilibrium at the first row, K.
pub(super) fn late_warmth<T: Real>(
    of: Thermometer,
    lag_s: T,
    around: &Surroundings<'_, T>,
) -> Result<Vec<T>> {
    let time = around.times()?;
    let (column, reference) = around.temperature(of)?;
    let warmer = column.iter().map(|t| T::from(t - reference)).collect();
    Ok(Signal::new(time, warmer).lagged(lag_s, Before::Equilibrium))
}

/// c ΔT + q ΔT².
fn at_once<T: Real>(of: Thermometer, parameters: &[T], around: &Surroundings<'_, T>) -> Result<Vec<T>> {
    let (column, reference) = around.temperature(of)?;
    let warmer = column.iter().map(|t| t - reference);
    Ok(warmer.map(|warmer| (parameters[0] + parameters[1] * warmer) * warmer).collect())
}

/// c ΔT_lag.
fn late<T: Real>(of: Thermometer, parameters: &[T], around: &Surroundings<'_, T>) -> Result<Vec<T>> {
    let warmer = late_warmth(of, parameters[1], around)?;
    Ok(warmer.into_iter().map(|warmer| parameters[0] * warmer).collect())
}

const OFFSET: ParameterInfo = ParameterInfo::amplitude("coefficient_nt_per_k", 0.005, 5.0);
const OFFSET_CURVATURE: ParameterInfo = ParameterInfo::amplitude("curvature_nt_per_k2", 0.0001, 0.1);
const SENSITIVITY: ParameterInfo = ParameterInfo::amplitude("coefficient_ppm_per_k", 0.2, 200.0);
const SENSITIVITY_CURVATURE: ParameterInfo = ParameterInfo::amplitude("curvature_ppm_per_k2", 0.002, 2.0);
const LAG: ParameterInfo = ParameterInfo::shape("lag_s", 10.0, 10_000.0);

/// An effect that follows the temperature of `$place`.
macro_rules! follows {
    (
        $effect:ident = $name:literal,
        $of:ident of $place:ident $how:ident, [$($parameter:expr),+], needs [$($time:literal)?],
        title: $title:literal,
        physics: $physics:literal,
        equation: $equation:literal,
        source: $source:literal,
    ) => {
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
                add(Of::$of, $how(Thermometer::$place, parameters, around)?, signal, around);
                Ok(())
            }
        }
    };
}

follows! {
    OffsetTemperature = "offset_temperature",
    Offset of Sensor at_once, [OFFSET, OFFSET_CURVATURE], needs [],
    title: "offset follows sensor temperature",
    physics: "Warming changes the stress in the core and the balance of the windings, and the sensor's offset moves.",
    equation: "dB = c (T_S - T_ref) + q (T_S - T_ref)^2",
    source: "NASA CR-156638, eq. 29; Primdahl 1979, The fluxgate magnetometer, J. Phys. E 12, 241",
}

follows! {
    OffsetTemperatureLag = "offset_temperature_lag",
    Offset of Sensor late, [OFFSET, LAG], needs ["time_s"],
    title: "offset follows sensor temperature with a lag",
    physics: "The core or its support warms later than the thermometer beside it, and the sensor's offset moves with the \
        core's temperature.",
    equation: "dB = c (T_lag - T_ref), tau dT_lag/dt = T_S - T_lag",
    source: "Primdahl 1979, The fluxgate magnetometer, J. Phys. E 12, 241",
}

follows! {
    SensitivityTemperature = "sensitivity_temperature",
    Sensitivity of Sensor at_once, [SENSITIVITY, SENSITIVITY_CURVATURE], needs [],
    title: "sensitivity follows sensor temperature",
    physics: "The feedback coil and its former expand, and the same feedback current balances another field.",
    equation: "dB = B (c (T_S - T_ref) + q (T_S - T_ref)^2) 1e-6",
    source: "NASA CR-156638, eq. 29; Tøffner-Clausen et al. 2016, In-flight scalar calibration and characterisation of the Swarm magnetometry package, Earth Planets Space 68, 129",
}

follows! {
    SensitivityTemperatureLag = "sensitivity_temperature_lag",
    Sensitivity of Sensor late, [SENSITIVITY, LAG], needs ["time_s"],
    title: "sensitivity follows sensor temperature with a lag",
    physics: "The feedback coil warms later than the thermometer beside it, and the sensitivity moves with its size.",
    equation: "dB = B c (T_lag - T_ref) 1e-6, tau dT_lag/dt = T_S - T_lag",
    source: "NASA CR-156638, eq. 29; Acuña 2002, Space-based magnetometers, Rev. Sci. Instrum. 73, 3717",
}

follows! {
    OffsetElectronicsTemperature = "offset_electronics_temperature",
    Offset of Electronics at_once, [OFFSET, OFFSET_CURVATURE], needs [],
    title: "offset follows electronics temperature",
    physics: "Offsets of amplifiers and the symmetry of the excitation drift with the temperature of the electronics.",
    equation: "dB = c (T_E - T_ref) + q (T_E - T_ref)^2",
    source: "NASA CR-156638, eq. 29; Acuña 2002, Space-based magnetometers, Rev. Sci. Instrum. 73, 3717",
}

follows! {
    OffsetElectronicsTemperatureLag = "offset_electronics_temperature_lag",
    Offset of Electronics late, [OFFSET, LAG], needs ["time_s"],
    title: "offset follows electronics temperature with a lag",
    physics: "The part that drifts warms later than the thermometer on the board.",
    equation: "dB = c (T_lag - T_ref), tau dT_lag/dt = T_E - T_lag",
    source: "Acuña 2002, Space-based magnetometers, Rev. Sci. Instrum. 73, 3717",
}

follows! {
    SensitivityElectronicsTemperature = "sensitivity_electronics_temperature",
    Sensitivity of Electronics at_once, [SENSITIVITY, SENSITIVITY_CURVATURE], needs [],
    title: "sensitivity follows electronics temperature",
    physics: "The voltage reference and the resistors that turn the feedback into the output drift with temperature.",
    equation: "dB = B (c (T_E - T_ref) + q (T_E - T_ref)^2) 1e-6",
    source: "NASA CR-156638, eq. 29; Acuña 2002, Space-based magnetometers, Rev. Sci. Instrum. 73, 3717",
}

follows! {
    SensitivityElectronicsTemperatureLag = "sensitivity_electronics_temperature_lag",
    Sensitivity of Electronics late, [SENSITIVITY, LAG], needs ["time_s"],
    title: "sensitivity follows electronics temperature with a lag",
    physics: "The voltage reference warms later than the thermometer on the board.",
    equation: "dB = B c (T_lag - T_ref) 1e-6, tau dT_lag/dt = T_E - T_lag",
    source: "Acuña 2002, Space-based magnetometers, Rev. Sci. Instrum. 73, 3717",
}
