use super::prelude::*;
use crate::memory::Signal;
use std::f64::consts::TAU;

/// ΔB = c I in SEN, I a housekeeping column in A.
pub struct StrayCurrent;

impl Effect for StrayCurrent {
    const ABOUT: About = About {
        name: "stray_current",
        title: "field of a current on board",
        physics: "The current of a solar array, a battery or a torquer flows in a loop and makes a field in \
            proportion, fixed to the spacecraft.",
        equation: "dB_sen = c I",
        source: "Olsen et al. 2020, Magnetic field observations from CryoSat-2, Earth Planets Space 72, 48",
        place: Place::Spacecraft,
        stage: Stage::Block,
        acts: Acts::WithColumn,
        parameters: &[
            ParameterInfo::amplitude("x_nt_per_a", 0.1, 10_000.0),
            ParameterInfo::amplitude("y_nt_per_a", 0.1, 10_000.0),
            ParameterInfo::amplitude("z_nt_per_a", 0.1, 10_000.0),
        ],
        needs: &["a housekeeping column in A"],
        invertible: true,
    };

    fn apply<T: Real>(
        parameters: &[T],
        signal: &mut [Vector3<T>],
        around: &Surroundings<'_, T>,
    ) -> Result<(), Error> {
        let current = around.context.column(around.column, Self::ABOUT.name)?;
        let vector = Vector3::from_column_slice(parameters);
        for (field, current) in signal.iter_mut().zip(current.iter()) {
            *field += vector * T::from(*current);
        }
        Ok(())
    }
}

/// ΔB = s sin φ + c cos φ in SEN, dφ/dt = 2π f, f a housekeeping column in Hz.
pub struct ReactionWheel;

impl Effect for ReactionWheel {
    const ABOUT: About = About {
        name: "reaction_wheel",
        title: "field of a reaction wheel",
        physics: "A magnetised rotor turns with the wheel and makes a field at its speed, fixed to the spacecraft.",
        equation: "dB_sen = s sin(phi) + c cos(phi), d phi/dt = 2 pi f",
        source: "Pope et al. 2011, Exploring planetary magnetic environments using magnetically unclean spacecraft, Ann. \
            Geophys. 29, 639",
        place: Place::Spacecraft,
        stage: Stage::Block,
        acts: Acts::WithColumn,
        parameters: &[
            ParameterInfo::amplitude("x_sine_nt", 0.01, 100.0),
            ParameterInfo::amplitude("x_cosine_nt", 0.01, 100.0),
            ParameterInfo::amplitude("y_sine_nt", 0.01, 100.0),
            ParameterInfo::amplitude("y_cosine_nt", 0.01, 100.0),
            ParameterInfo::amplitude("z_sine_nt", 0.01, 100.0),
            ParameterInfo::amplitude("z_cosine_nt", 0.01, 100.0),
        ],
        needs: &["time_s", "a housekeeping column in Hz"],
        invertible: true,
    };

    fn apply<T: Real>(
        parameters: &[T],
        signal: &mut [Vector3<T>],
        around: &Surroundings<'_, T>,
    ) -> Result<(), Error> {
        let time = around.context.times(Self::ABOUT.name)?;
        let rate = around.context.column(around.column, Self::ABOUT.name)?.into_owned();
        let turns = Signal::new(time, rate).integral();
        for (field, turns) in signal.iter_mut().zip(turns) {
            let (sine, cosine) = (turns.fract() * TAU).sin_cos();
            for axis in 0..3 {
                field[axis] += parameters[2 * axis] * sine + parameters[2 * axis + 1] * cosine;
            }
        }
        Ok(())
    }
}

/// ΔB = lit cos(el) (c cos(az) + s sin(az)) in SEN, from `sun_azimuth_rad`; `sun_elevation_rad` and `sunlit` (1 in the
/// Sun, 0 in eclipse) where there are such columns.
pub struct SunThermoelectric;

impl Effect for SunThermoelectric {
    const ABOUT: About = About {
        name: "sun_thermoelectric",
        title: "thermoelectric currents driven by the Sun",
        physics: "Sunlight warms one side of a metal structure, and currents between unlike metals flow that depend on \
            the direction of the Sun and vanish in eclipse.",
        equation: "dB_sen = sunlit cos(el) (c cos(az) + s sin(az))",
        source: "Tøffner-Clausen et al. 2016, In-flight scalar calibration and characterisation of the Swarm magnetometry package, Earth \
            Planets Space 68, 129",
        place: Place::Spacecraft,
        stage: Stage::Block,
        acts: Acts::Everything,
        parameters: &[
            ParameterInfo::amplitude("x_cosine_nt", 0.05, 20.0),
            ParameterInfo::amplitude("x_sine_nt", 0.05, 20.0),
            ParameterInfo::amplitude("y_cosine_nt", 0.05, 20.0),
            ParameterInfo::amplitude("y_sine_nt", 0.05, 20.0),
            ParameterInfo::amplitude("z_cosine_nt", 0.05, 20.0),
            ParameterInfo::amplitude("z_sine_nt", 0.05, 20.0),
        ],
        needs: &["sun_azimuth_rad"],
        invertible: true,
    };

    fn apply<T: Real>(
        parameters: &[T],
        signal: &mut [Vector3<T>],
        around: &Surroundings<'_, T>,
    ) -> Result<(), Error> {
        let azimuth = around.context.column("sun_azimuth_rad", Self::ABOUT.name)?;
        let elevation = around.context.optional("sun_elevation_rad");
        let sunlit = around.context.optional("sunlit");
        for (row, field) in signal.iter_mut().enumerate() {
            let light = sunlit.as_ref().map_or(1.0, |lit| lit[row])
                * elevation.as_ref().map_or(1.0, |angle| angle[row].cos());
            let (sine, cosine) = azimuth[row].sin_cos();
            for axis in 0..3 {
                field[axis] +=
                    parameters[2 * axis] * (light * cosine) + parameters[2 * axis + 1] * (light * sine);
            }
        }
        Ok(())
    }
}
