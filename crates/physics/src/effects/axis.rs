use super::prelude::*;
use super::temperature::late_warmth;
use crate::context::Thermometer;
use crate::frames::ARCSEC;

impl Effect for AxisTemperature {
    const ABOUT: About = About {
        name: "axis_temperature",
        title: "sensor axis turns with temperature",
        physics: "The block that holds the sensor bends as it warms, and the sensor takes in a part of the field \
            across it.",
        equation: "dB = (a u + b v) (T_S - T_ref), u and v the SEN fields across the sensor in cyclic order",
        source: "NASA CR-156638, specifications (axes stable to 5 arcsec); Acuña 2002, Space-based magnetometers, \
            Rev. Sci. Instrum. 73, 3717",
        parameters: amplitudes!(0.01 to 10.0: "first_arcsec_per_k", "second_arcsec_per_k"),
        needs: &[Thermometer::Sensor.column()],
        ..About::of(Family::FollowsColumn, Place::Sensor, Stage::Sensor, Acts::OneSensor)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let (column, reference) = around.temperature(Thermometer::Sensor)?;
        turn(parameters, |row| T::from(column[row] - reference), signal, around);
        Ok(())
    }
}

/// T_lag is in equilibrium at the first row.
impl Effect for AxisCreep {
    const ABOUT: About = About {
        name: "axis_creep",
        title: "sensor axis creeps after temperature",
        physics: "Glue and fixings give way slowly after a change of temperature, and the sensor's axis turns with \
            them.",
        equation: "dB = (a u + b v) (T_lag - T_ref), tau dT_lag/dt = T_S - T_lag",
        parameters: amplitudes!(
            0.01 to 10.0: "first_arcsec_per_k", "second_arcsec_per_k";
            ParameterInfo::shape("lag_s", 10.0, 100_000.0)
        ),
        needs: &["time_s", Thermometer::Sensor.column()],
        ..AxisTemperature::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let warmer = late_warmth(Thermometer::Sensor, parameters[2], around)?;
        turn(parameters, |row| warmer[row], signal, around);
        Ok(())
    }
}

fn turn<T: Real>(
    parameters: &[T],
    warmer: impl Fn(usize) -> T,
    signal: &mut [Vector3<T>],
    around: &Surroundings<'_, T>,
) {
    let [first, second] = across(around.axis);
    for (row, (value, field)) in signal.iter_mut().zip(around.field_sen).enumerate() {
        let turned = parameters[0] * field[first] + parameters[1] * field[second];
        value[around.axis.index()] += turned * warmer(row) * ARCSEC;
    }
}
