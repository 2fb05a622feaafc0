use super::prelude::*;

impl Effect for QuadraticNonlinearity {
    const ABOUT: About = About {
        name: "quadratic_nonlinearity",
        title: "response has a term in the square of the field along the sensor",
        physics: "The loop's gain or the core's permeability differs for the two directions of the field, so that \
            the reading has a part that is even in the field.",
        equation: "dB = a (B / 50000 nT)^2",
        source: "NASA CR-156638, sensor sensitivity and nonlinearity; Auster et al. 2008, The THEMIS \
            fluxgate magnetometer, Space Sci. Rev. 141, 235",
        parameters: &[ParameterInfo::amplitude("departure_nt", 0.1, 100.0)],
        ..About::of(Family::OwnField, Place::Sensor, Stage::Sensor, Acts::OneSensor)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        power(parameters[0], 2, signal, around);
        Ok(())
    }
}

impl Effect for CubicNonlinearity {
    const ABOUT: About = About {
        name: "cubic_nonlinearity",
        title: "response has a term in the cube of the field along the sensor",
        physics: "The feedback current or the core falls short towards the ends of the range, alike in both \
            directions of the field.",
        equation: "dB = a (B / 50000 nT)^3",
        ..QuadraticNonlinearity::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        power(parameters[0], 3, signal, around);
        Ok(())
    }
}

fn power<T: Real>(departure: T, exponent: i32, signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) {
    for own in around.own(signal) {
        *own += departure * (*own / FULL_NT).powi(exponent);
    }
}
