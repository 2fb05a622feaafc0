use super::prelude::*;
use crate::memory::Signal;
use std::f64::consts::TAU;

impl Effect for StrayCurrent {
    const ABOUT: About = About {
        name: "stray_current",
        title: "field of a current on board",
        physics: "The current of a solar array, a battery or a torquer flows in a loop and makes a field in \
            proportion, fixed to the spacecraft.",
        equation: "dB_sen = c I",
        source: "Olsen et al. 2020, Magnetic observations from CryoSat-2: calibration and processing of satellite platform magnetometer data, Earth Planets Space 72, 48",
        parameters: amplitudes!(0.1 to 10_000.0: "x_nt_per_a", "y_nt_per_a", "z_nt_per_a"),
        needs: &["a housekeeping column in A"],
        ..About::of(Family::FollowsColumn, Place::Spacecraft, Stage::Block, Acts::WithColumn("_a"))
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let current = around.column(around.column)?;
        let vector = Vector3::from_column_slice(parameters);
        for (field, current) in signal.iter_mut().zip(current.iter()) {
            *field += vector * T::from(*current);
        }
        Ok(())
    }
}

/// Waves of a rotor: ΔB = s sin φ + c cos φ in SEN, dφ/dt = 2π n f, f a housekeeping column in Hz.
macro_rules! rotor {
    (
        $effect:ident = $name:literal, $multiple:literal f,
        title: $title:literal,
        equation: $equation:literal,
    ) => {
        impl Effect for $effect {
            const ABOUT: About = About {
                name: $name,
                title: $title,
                physics: "A magnetised rotor turns with the wheel and makes a field at its speed and its harmonics, fixed to \
                    the spacecraft.",
                equation: $equation,
                source: "Pope et al. 2011, Exploring planetary magnetic environments using magnetically unclean spacecraft: a \
                    systems approach to VEX MAG data analysis, Ann. Geophys. 29, 639",
                parameters: amplitudes!(
                    0.01 to 100.0: "x_sine_nt", "x_cosine_nt", "y_sine_nt", "y_cosine_nt", "z_sine_nt",
                                   "z_cosine_nt"
                ),
                needs: &["time_s", "a housekeeping column in Hz"],
                ..About::of(Family::Lines, Place::Spacecraft, Stage::Block, Acts::WithColumn("_hz"))
            };

            fn apply<T: Real>(
                parameters: &[T],
                signal: &mut [Vector3<T>],
                around: &Surroundings<'_, T>,
            ) -> Result {
                let time = around.times()?;
                let rate = around.column(around.column)?;
                let turns = Signal::new(time, rate.to_vec()).integral();
                for (row, field) in signal.iter_mut().enumerate() {
                    let share: f64 = around.context.averaged($multiple * rate[row]);
                    let (sine, cosine) = (($multiple * turns[row]).fract() * TAU).sin_cos();
                    for axis in 0..3 {
                        field[axis] +=
                            (parameters[2 * axis] * sine + parameters[2 * axis + 1] * cosine) * share;
                    }
                }
                Ok(())
            }
        }
    };
}

rotor! {
    ReactionWheel = "reaction_wheel", 1.0 f,
    title: "field of a reaction wheel",
    equation: "dB_sen = s sin(phi) + c cos(phi), d phi/dt = 2 pi f",
}

rotor! {
    ReactionWheelHarmonic = "reaction_wheel_harmonic", 2.0 f,
    title: "second harmonic of a reaction wheel",
    equation: "dB_sen = s sin(phi) + c cos(phi), d phi/dt = 4 pi f",
}
