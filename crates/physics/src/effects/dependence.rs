use super::prelude::*;
use crate::memory::{Before, Signal};

/// u_lag is in equilibrium at the first row and where there are no times; with τ = 0 it is u.
impl Effect for Dependence {
    const ABOUT: About = About {
        name: "dependence",
        title: "the sensors follow a recorded column",
        physics: "Something that is recorded moves the sensors' offsets or makes a field fixed to them: a heater, a pressure, \
            a moving part. What it is only the column's name says.",
        equation: "dB = c (u_lag - u_0), tau du_lag/dt = u - u_lag, u_0 the reference",
        source: "Olsen et al. 2020, Magnetic observations from CryoSat-2: calibration and processing of satellite platform magnetometer data, Earth Planets Space 72, 48",
        parameters: amplitudes!(
            1e-6 to 1e6: "x_nt_per_unit", "y_nt_per_unit", "z_nt_per_unit";
            ParameterInfo::shape("lag_s", 0.1, 100_000.0).or_zero(),
            ParameterInfo::span("reference", 1e-3, 1e6)
        ),
        needs: &["a recorded column", "rows in the order taken"],
        ..About::of(Family::FollowsColumn, Place::Sensor, Stage::Sensor, Acts::WithColumn(""))
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let column = around.column(around.column)?;
        let mut values: Vec<T> = column.iter().map(|value| -parameters[4] + *value).collect();
        let lag_s = parameters[3];
        if let (true, Ok(time)) = (lag_s.re() > 0.0, around.times()) {
            values = Signal::new(time, values).lagged(lag_s, Before::Equilibrium);
        }
        let coefficients = Vector3::from_column_slice(&parameters[..3]);
        signal.iter_mut().zip(values).for_each(|(field, value)| *field += coefficients * value);
        Ok(())
    }
}
