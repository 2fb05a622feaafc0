use super::prelude::*;

/// A part linear in u and v is a turned axis, which belongs to μ.
impl Effect for CrossField {
    const ABOUT: About = About {
        name: "cross_field",
        title: "offset depends on the square of the transverse field",
        physics: "A field across the core saturates parts of it and shifts the balance of the sensor, whatever the \
            field along its axis.",
        equation: "dB = (a u^2 + b v^2 + c u v) / (50000 nT)^2, u and v the SEN fields across the sensor in cyclic order",
        source: "Brauer et al. 1997, Transverse field effect in fluxgate sensors, Sens. Actuators A 59, 70; \
            NASA CR-156638, orthogonal field effects",
        parameters: amplitudes!(0.1 to 50.0: "first_nt", "second_nt", "mixed_nt"),
        ..About::of(Family::OwnField, Place::Sensor, Stage::Sensor, Acts::OneSensor)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let axis = around.axis;
        for (value, field) in signal.iter_mut().zip(around.field_sen) {
            let [u, v] = across(axis).map(|k| field[k] / FULL_NT);
            value[axis.index()] += parameters[0] * u * u + parameters[1] * v * v + parameters[2] * u * v;
        }
        Ok(())
    }
}

impl Effect for CrossFieldSensitivity {
    const ABOUT: About = About {
        name: "cross_field_sensitivity",
        title: "sensitivity depends on the transverse field",
        physics: "A field across the core changes its permeability, and with it the share of the field that the \
            sensor sees.",
        equation: "dB = B (a u + b v) / (50000 nT)^2, u and v the SEN fields across the sensor in cyclic order",
        parameters: amplitudes!(0.1 to 50.0: "first_nt", "second_nt"),
        ..CrossField::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let axis = around.axis;
        for (value, field) in signal.iter_mut().zip(around.field_sen) {
            let [u, v] = across(axis).map(|k| field[k] / FULL_NT);
            let own = &mut value[axis.index()];
            *own += *own / FULL_NT * (parameters[0] * u + parameters[1] * v);
        }
        Ok(())
    }
}
