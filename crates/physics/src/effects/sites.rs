use super::iron::{MATRIX, add_matrix};
use super::prelude::*;
use super::temperature::late_warmth;
use crate::context::Thermometer;
use crate::frames::ARCSEC;
use crate::memory::{Before, Signal};

const FOUNDATIONS: &str = "Rasmussen and Kring Lauridsen 1990, Improving baseline drift in fluxgate magnetometers caused by \
    foundation movements, Phys. Earth Planet. Inter. 59, 78";

impl Effect for PillarGradient {
    const ABOUT: About = About {
        name: "pillar_gradient",
        title: "field differs between the pillars in proportion",
        physics: "Rock or iron near one pillar is magnetised by the field, so that the test instrument sees a slightly \
            other field than the reference. A constant matrix is the same as other axes and scales.",
        equation: "dB_test = G B_reference 1e-6, G[row][column], row = component added",
        source: "Jankowski and Sucksdorff 1996, IAGA Guide for Magnetic Measurements and Observatory Practice (pillar \
            differences)",
        parameters: MATRIX,
        needs: &["a differential recording"],
        ..About::of(Family::Position, Place::Sites, Stage::Block, Acts::Everything)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], _: &Surroundings<'_, T>) -> Result {
        add_matrix(parameters, signal);
        Ok(())
    }
}

impl Effect for InductionDifference {
    const ABOUT: About = About {
        name: "induction_difference",
        title: "induced currents differ between the sites",
        physics: "Rapid variations induce currents in the ground; where it conducts differently below the two pillars, \
            the field there differs in proportion to its faster part, the vertical component most: hardly between \
            pillars of one house, by tenths of it where a coast or a fault lies between.",
        equation: "dB = C (B - L) 1e-6, tau dL/dt = B - L, C[row][column], row = component added",
        source: "Parkinson 1959, Directions of rapid geomagnetic fluctuations, Geophys. J. 2, 1",
        parameters: amplitudes!(
            1.0 to 100_000.0: "xx_ppm", "xy_ppm", "xz_ppm", "yx_ppm", "yy_ppm", "yz_ppm", "zx_ppm", "zy_ppm",
                              "zz_ppm";
            ParameterInfo::shape("time_constant_s", 1.0, 100_000.0)
        ),
        needs: &["time_s", "a differential recording"],
        ..About::of(Family::LateResponse, Place::Sites, Stage::Block, Acts::Everything)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let time = around.times()?;
        let matrix = nalgebra::Matrix3::from_row_slice(&parameters[..9]);
        let lagged =
            [0, 1, 2].map(|axis| Signal::of(time, signal, axis).lagged(parameters[9], Before::Moving));
        for (row, field) in signal.iter_mut().enumerate() {
            let faster = *field - Vector3::new(lagged[0][row], lagged[1][row], lagged[2][row]);
            *field += matrix * faster * T::from(1e-6);
        }
        Ok(())
    }
}

impl Effect for PillarTilt {
    const ABOUT: About = About {
        name: "pillar_tilt",
        title: "pillar tilts with temperature",
        physics: "The pillar or its foundation warms unevenly and tilts, and the horizontal sensors take in a part of \
            the vertical field.",
        equation: "dB = -omega x B, omega = (a, b, 0) (T_lag - T_ref), tau dT_lag/dt = T_S - T_lag",
        source: FOUNDATIONS,
        parameters: amplitudes!(
            0.05 to 50.0: "about_x_arcsec_per_k", "about_y_arcsec_per_k";
            ParameterInfo::shape("lag_s", 10.0, 1_000_000.0)
        ),
        needs: &["time_s", Thermometer::Sensor.column()],
        ..About::of(Family::Time, Place::Sites, Stage::Block, Acts::Everything)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let warmer = late_warmth(Thermometer::Sensor, parameters[2], around)?;
        tilt(parameters, |row| warmer[row], signal);
        Ok(())
    }
}

impl Effect for PillarSettling {
    const ABOUT: About = About {
        name: "pillar_settling",
        title: "pillar settles",
        physics: "The foundation gives way slowly and the pillar tilts more each day.",
        equation: "dB = -omega x B, omega = (a, b, 0) t",
        parameters: amplitudes!(0.01 to 20.0: "about_x_arcsec_per_day", "about_y_arcsec_per_day"),
        needs: &["time_s"],
        ..PillarTilt::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let clock = around.clock()?;
        tilt(parameters, |row| T::from(clock[row] / DAY_S), signal);
        Ok(())
    }
}

/// The gain is a million where the tiltmeters are right.
impl Effect for MeasuredTilt {
    const ABOUT: About = About {
        name: "measured_tilt",
        title: "block tilts as the tiltmeters record",
        physics: "The ground or the pillar tilts, the tiltmeters beside the sensors see it, and the horizontal sensors take in \
            a part of the vertical field.",
        equation: "dB = -g 1e-6 omega x B, omega = (tilt_x, tilt_y, 0)",
        source: FOUNDATIONS,
        parameters: &[ParameterInfo::amplitude("gain_ppm", 100_000.0, 2_000_000.0)],
        needs: &["tilt_x_rad", "tilt_y_rad"],
        ..About::of(Family::FollowsColumn, Place::Environment, Stage::Block, Acts::Everything)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let about_x = around.column("tilt_x_rad")?;
        let about_y = around.column("tilt_y_rad")?;
        let gain = parameters[0] * 1e-6;
        for (row, field) in signal.iter_mut().enumerate() {
            *field = tilted(field, gain * about_x[row], gain * about_y[row]);
        }
        Ok(())
    }
}

/// B − ω × B with ω = (a, b, 0) grown by `by(row)`, a and b in arcsec.
fn tilt<T: Real>(parameters: &[T], by: impl Fn(usize) -> T, signal: &mut [Vector3<T>]) {
    for (row, field) in signal.iter_mut().enumerate() {
        let grown = by(row) * ARCSEC;
        *field = tilted(field, parameters[0] * grown, parameters[1] * grown);
    }
}

/// B − ω × B with ω = (a, b, 0), rad.
fn tilted<T: Real>(field: &Vector3<T>, a: T, b: T) -> Vector3<T> {
    let [x, y, z] = [field[0], field[1], field[2]];
    field - Vector3::new(b * z, -a * z, a * y - b * x)
}
