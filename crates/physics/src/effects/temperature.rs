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
    let own = signal.iter_mut().map(|value| &mut value[around.axis.index()]).enumerate();
    match of {
        Of::Offset => own.for_each(|(row, own)| *own += change(row)),
        Of::Sensitivity => own.for_each(|(row, own)| *own += *own * change(row) * 1e-6),
    }
}

/// A temperature that the sensitivity or the offset follows.
struct Followed {
    effect: &'static str,
    thermometer: Thermometer,
    of: Of,
}

impl Followed {
    /// At once, with a curvature.
    fn instant<T: Real>(
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

    /// Through a first-order lag, in equilibrium at the first row.
    fn lagged<T: Real>(
        self,
        parameters: &[T],
        signal: &mut [Vector3<T>],
        around: &Surroundings<'_, T>,
    ) -> Result {
        let time = around.context.times(self.effect)?;
        let (column, reference) = around.context.temperature(self.thermometer, self.effect)?;
        let warmer = column.iter().map(|t| T::from(t - reference)).collect();
        let warmer = Signal::new(time, warmer).lagged(parameters[1], Before::Equilibrium);
        add(self.of, |row| parameters[0] * warmer[row], signal, around);
        Ok(())
    }
}

/// An effect that follows the temperature of `$place`.
macro_rules! follows {
    ($effect:ident, $name:literal, $doc:literal, $title:literal, $physics:literal, $equation:literal, $source:literal,
        $place:ident, $of:ident, $how:ident, [$($parameter:expr),+], [$($time:literal)?]) => {
        #[doc = $doc]
        pub struct $effect;

        impl Effect for $effect {
            const ABOUT: About = About {
                name: $name,
                title: $title,
                physics: $physics,
                equation: $equation,
                source: $source,
                family: Family::FollowsColumn,
                place: Place::$place,
                stage: Stage::$place,
                acts: Acts::OneSensor,
                parameters: &[$($parameter),+],
                needs: &[$($time,)? Thermometer::$place.column()],
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

follows!(
    OffsetTemperature,
    "offset_temperature",
    "ΔB = c (T_S − T_ref) + q (T_S − T_ref)², nT along the sensor (NASA eq. 29, with curvature).",
    "offset follows sensor temperature",
    "Warming changes the stress in the core and the balance of the windings, and the sensor's offset moves.",
    "dB = c (T_S - T_ref) + q (T_S - T_ref)^2",
    "NASA CR-156638, eq. 29; Primdahl 1979, The fluxgate magnetometer, J. Phys. E 12, 241",
    Sensor,
    Offset,
    instant,
    [
        ParameterInfo::amplitude("coefficient_nt_per_k", 0.005, 5.0),
        ParameterInfo::amplitude("curvature_nt_per_k2", 0.0001, 0.1)
    ],
    []
);

follows!(
    OffsetTemperatureLag,
    "offset_temperature_lag",
    "ΔB = c (T_lag − T_ref), τ dT_lag/dt = T_S − T_lag, in equilibrium at the first row; nT along the sensor.",
    "offset follows sensor temperature with a lag",
    "The core or its support warms later than the thermometer beside it, and the sensor's offset moves with the \
        core's temperature.",
    "dB = c (T_lag - T_ref), tau dT_lag/dt = T_S - T_lag",
    "Primdahl 1979, The fluxgate magnetometer, J. Phys. E 12, 241",
    Sensor,
    Offset,
    lagged,
    [
        ParameterInfo::amplitude("coefficient_nt_per_k", 0.005, 5.0),
        ParameterInfo::shape("lag_s", 10.0, 10_000.0)
    ],
    ["time_s"]
);

follows!(
    SensitivityTemperature,
    "sensitivity_temperature",
    "ΔB = B (c (T_S − T_ref) + q (T_S − T_ref)²), c in ppm/K, q in ppm/K².",
    "sensitivity follows sensor temperature",
    "The feedback coil and its former expand, and the same feedback current balances another field.",
    "dB = B (c (T_S - T_ref) + q (T_S - T_ref)^2) 1e-6",
    "NASA CR-156638, eq. 29; Tøffner-Clausen et al. 2016, In-flight scalar calibration and characterisation of the Swarm magnetometry package, Earth Planets Space 68, 129",
    Sensor,
    Sensitivity,
    instant,
    [
        ParameterInfo::amplitude("coefficient_ppm_per_k", 0.2, 200.0),
        ParameterInfo::amplitude("curvature_ppm_per_k2", 0.002, 2.0)
    ],
    []
);

follows!(
    SensitivityTemperatureLag,
    "sensitivity_temperature_lag",
    "ΔB = B c (T_lag − T_ref), τ dT_lag/dt = T_S − T_lag, in equilibrium at the first row; c in ppm/K.",
    "sensitivity follows sensor temperature with a lag",
    "The feedback coil warms later than the thermometer beside it, and the sensitivity moves with its size.",
    "dB = B c (T_lag - T_ref) 1e-6, tau dT_lag/dt = T_S - T_lag",
    "NASA CR-156638, eq. 29; Acuña 2002, Space-based magnetometers, Rev. Sci. Instrum. 73, 3717",
    Sensor,
    Sensitivity,
    lagged,
    [
        ParameterInfo::amplitude("coefficient_ppm_per_k", 0.2, 200.0),
        ParameterInfo::shape("lag_s", 10.0, 10_000.0)
    ],
    ["time_s"]
);

follows!(
    OffsetElectronicsTemperature,
    "offset_electronics_temperature",
    "ΔB = c (T_E − T_ref) + q (T_E − T_ref)², nT along the sensor (NASA eq. 29, with curvature).",
    "offset follows electronics temperature",
    "Offsets of amplifiers and the symmetry of the excitation drift with the temperature of the electronics.",
    "dB = c (T_E - T_ref) + q (T_E - T_ref)^2",
    "NASA CR-156638, eq. 29; Acuña 2002, Space-based magnetometers, Rev. Sci. Instrum. 73, 3717",
    Electronics,
    Offset,
    instant,
    [
        ParameterInfo::amplitude("coefficient_nt_per_k", 0.005, 5.0),
        ParameterInfo::amplitude("curvature_nt_per_k2", 0.0001, 0.1)
    ],
    []
);

follows!(
    OffsetElectronicsTemperatureLag,
    "offset_electronics_temperature_lag",
    "ΔB = c (T_lag − T_ref), τ dT_lag/dt = T_E − T_lag, in equilibrium at the first row; nT along the sensor.",
    "offset follows electronics temperature with a lag",
    "The part that drifts warms later than the thermometer on the board.",
    "dB = c (T_lag - T_ref), tau dT_lag/dt = T_E - T_lag",
    "Acuña 2002, Space-based magnetometers, Rev. Sci. Instrum. 73, 3717",
    Electronics,
    Offset,
    lagged,
    [
        ParameterInfo::amplitude("coefficient_nt_per_k", 0.005, 5.0),
        ParameterInfo::shape("lag_s", 10.0, 10_000.0)
    ],
    ["time_s"]
);

follows!(
    SensitivityElectronicsTemperature,
    "sensitivity_electronics_temperature",
    "ΔB = B (c (T_E − T_ref) + q (T_E − T_ref)²), c in ppm/K, q in ppm/K².",
    "sensitivity follows electronics temperature",
    "The voltage reference and the resistors that turn the feedback into the output drift with temperature.",
    "dB = B (c (T_E - T_ref) + q (T_E - T_ref)^2) 1e-6",
    "NASA CR-156638, eq. 29; Acuña 2002, Space-based magnetometers, Rev. Sci. Instrum. 73, 3717",
    Electronics,
    Sensitivity,
    instant,
    [
        ParameterInfo::amplitude("coefficient_ppm_per_k", 0.2, 200.0),
        ParameterInfo::amplitude("curvature_ppm_per_k2", 0.002, 2.0)
    ],
    []
);

follows!(
    SensitivityElectronicsTemperatureLag,
    "sensitivity_electronics_temperature_lag",
    "ΔB = B c (T_lag − T_ref), τ dT_lag/dt = T_E − T_lag, in equilibrium at the first row; c in ppm/K.",
    "sensitivity follows electronics temperature with a lag",
    "The voltage reference warms later than the thermometer on the board.",
    "dB = B c (T_lag - T_ref) 1e-6, tau dT_lag/dt = T_E - T_lag",
    "Acuña 2002, Space-based magnetometers, Rev. Sci. Instrum. 73, 3717",
    Electronics,
    Sensitivity,
    lagged,
    [
        ParameterInfo::amplitude("coefficient_ppm_per_k", 0.2, 200.0),
        ParameterInfo::shape("lag_s", 10.0, 10_000.0)
    ],
    ["time_s"]
);
