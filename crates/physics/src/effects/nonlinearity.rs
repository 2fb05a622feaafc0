use super::prelude::*;

const SOURCE: &str = "NASA CR-156638, sensor sensitivity and nonlinearity; Auster et al. 2008, The THEMIS \
    fluxgate magnetometer, Space Sci. Rev. 141, 235";

/// ΔB = a (B / 50 000 nT)², nT along the sensor.
pub struct QuadraticNonlinearity;

impl Effect for QuadraticNonlinearity {
    const ABOUT: About = About {
        name: "quadratic_nonlinearity",
        title: "response has a term in the square of the field along the sensor",
        physics: "The loop's gain or the core's permeability differs for the two directions of the field, so that \
            the reading has a part that is even in the field.",
        equation: "dB = a (B / 50000 nT)^2",
        source: SOURCE,
        family: Family::OwnField,
        place: Place::Sensor,
        stage: Stage::Sensor,
        acts: Acts::OneSensor,
        parameters: &[ParameterInfo::amplitude("departure_nt", 0.1, 100.0)],
        needs: &[],
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        power(parameters[0], 2, signal, around);
        Ok(())
    }
}

/// ΔB = a (B / 50 000 nT)³, nT along the sensor.
pub struct CubicNonlinearity;

impl Effect for CubicNonlinearity {
    const ABOUT: About = About {
        name: "cubic_nonlinearity",
        title: "response has a term in the cube of the field along the sensor",
        physics: "The feedback current or the core falls short towards the ends of the range, alike in both \
            directions of the field.",
        equation: "dB = a (B / 50000 nT)^3",
        source: SOURCE,
        family: Family::OwnField,
        place: Place::Sensor,
        stage: Stage::Sensor,
        acts: Acts::OneSensor,
        parameters: &[ParameterInfo::amplitude("departure_nt", 0.1, 100.0)],
        needs: &[],
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        power(parameters[0], 3, signal, around);
        Ok(())
    }
}

fn power<T: Real>(departure: T, exponent: i32, signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) {
    for value in signal {
        let own = &mut value[around.axis.index()];
        *own += departure * (*own / FULL_NT).powi(exponent);
    }
}
