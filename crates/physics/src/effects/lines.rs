use super::prelude::*;
use std::f64::consts::TAU;

const SOURCE: &str =
    "Jankowski and Sucksdorff 1996, IAGA Guide for Magnetic Measurements and Observatory Practice";

/// One line in GEO: ΔB = s sin φ + c cos φ, φ = 2πf (t + (ρ − 1)(t − t₀)²/2T), t on the campaign's clock: over a
/// recording that begins at t₀ and lasts T the frequency goes from f to ρ f. Samples are instantaneous, so
/// that a line above the Nyquist frequency appears at its alias by itself; where `conditions.integration_s`
/// says that they are means over w, the line is smaller by sin(πfw)/(πfw).
macro_rules! line {
    ($effect:ident, $name:literal, $doc:literal, $title:literal, $physics:literal, $low:literal, $high:literal) => {
        #[doc = $doc]
        pub struct $effect;

        impl Effect for $effect {
            const ABOUT: About = About {
                name: $name,
                title: $title,
                physics: $physics,
                equation: "dB_geo = s sin(2 pi f u) + c cos(2 pi f u), u = t + (rho - 1) (t - t_0)^2/2T, rho the end_ratio (1 where it is 0)",
                source: SOURCE,
                family: Family::Lines,
                place: Place::Environment,
                stage: Stage::Geo,
                acts: Acts::Everything,
                parameters: &[
                    ParameterInfo::amplitude("north_sine_nt", 0.01, 100.0),
                    ParameterInfo::amplitude("north_cosine_nt", 0.01, 100.0),
                    ParameterInfo::amplitude("east_sine_nt", 0.01, 100.0),
                    ParameterInfo::amplitude("east_cosine_nt", 0.01, 100.0),
                    ParameterInfo::amplitude("down_sine_nt", 0.01, 100.0),
                    ParameterInfo::amplitude("down_cosine_nt", 0.01, 100.0),
                    ParameterInfo::shape("frequency_hz", $low, $high),
                    ParameterInfo::shape("end_ratio", 0.5, 2.0).or_zero(),
                ],
                needs: &["time_s"],
            };

            fn apply<T: Real>(
                parameters: &[T],
                signal: &mut [Vector3<T>],
                around: &Surroundings<'_, T>,
            ) -> Result {
                let clock = around.context.clock($name)?;
                let share = around.context.averaged(parameters[6]);
                let (first, last) = (clock.first().copied(), clock.last().copied());
                let twice_s = first.zip(last).map_or(0.0, |(first, last)| 2.0 * (last - first));
                let wanders = twice_s > 0.0 && parameters[7].re() > 0.0;
                let more = if wanders { (parameters[7] - 1.0) / twice_s } else { T::from(0.0) };
                for (field, t) in signal.iter_mut().zip(clock) {
                    let since = t - first.unwrap_or(t);
                    let phase = parameters[6] * (more * (since * since) + t) * TAU;
                    let (sine, cosine) = phase.sin_cos();
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

line!(
    Mains,
    "mains",
    "Field of the mains at 50 or 60 Hz, or at a harmonic.",
    "mains field",
    "Currents of the power supply make a field at the mains' frequency and its harmonics, seen at an alias by a slow logger.",
    40.0,
    400.0
);

line!(
    TractionPower,
    "traction_power",
    "Field of railway power at 16.7 Hz.",
    "field of railway power",
    "Currents of an electric railway flow in the rails and in the ground and make a field at the railway's frequency.",
    15.0,
    18.0
);

line!(
    PeriodicField,
    "periodic_field",
    "Field of one frequency, whatever makes it.",
    "periodic field of an unknown source",
    "A machine, a power supply or a converter nearby makes a field of one frequency; a slow logger shows it at an alias, which does not say which.",
    1e-6,
    1e4
);
