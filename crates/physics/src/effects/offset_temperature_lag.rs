use common::Axis;
use nalgebra::Vector3;

use crate::memory::first_order_lag;
use crate::{Effect, Error, ParameterInfo, Place, Real, Surroundings};

/// An offset that follows the sensor's temperature through a first-order lag:
/// ΔB = c (T_lag − T_ref), τ dT_lag/dt = T_S − T_lag, in equilibrium at the first row. nT along the sensor.
pub struct OffsetTemperatureLag;

impl Effect for OffsetTemperatureLag {
    const NAME: &'static str = "offset_temperature_lag";
    const TITLE: &'static str = "offset follows sensor temperature with a lag";
    const PHYSICS: &'static str = "The core or its support warms later than the thermometer beside it, and \
        the sensor's offset moves with the core's temperature.";
    const EQUATION: &'static str = "dB = c (T_lag - T_ref), tau dT_lag/dt = T_S - T_lag";
    const SOURCE: &'static str = "Primdahl 1979, The fluxgate magnetometer, J. Phys. E 12, 241";
    const PLACE: Place = Place::Sensor;
    const PARAMETERS: &'static [ParameterInfo] = &[
        ParameterInfo { name: "coefficient_nt_per_k", low: 0.005, high: 5.0, positive: false },
        ParameterInfo { name: "lag_s", low: 10.0, high: 10_000.0, positive: true },
    ];

    fn apply<T: Real>(
        parameters: &[T],
        axis: Axis,
        signal: &mut [Vector3<T>],
        around: &Surroundings<'_, T>,
    ) -> Result<(), Error> {
        let context = around.context;
        let time = context.times(Self::NAME)?;
        let temperature = context.column("sensor_temperature_c", Self::NAME)?;
        let reference = context
            .references
            .sensor_c
            .ok_or_else(|| context.missing(Self::NAME, "a reference temperature"))?;
        let lagged = first_order_lag(time, temperature, parameters[1], None);
        for (value, temperature) in signal.iter_mut().zip(lagged) {
            value[axis.index()] += parameters[0] * (temperature - reference);
        }
        Ok(())
    }
}
