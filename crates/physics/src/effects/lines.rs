use super::prelude::*;
use std::f64::consts::TAU;

/// One line in GEO: over a recording that begins at t₀ on the campaign's clock and lasts T the frequency goes from f to
/// ρ f. Where `conditions.integration_s` says that samples are means over w, it is smaller by sin(πfw)/(πfw); else a
/// line above the Nyquist frequency appears at its alias by itself.
macro_rules! line {
    (
        $effect:ident = $name:literal, $low:literal to $high:literal Hz,
        title: $title:literal,
        physics: $physics:literal,
    ) => {
        impl Effect for $effect {
            const ABOUT: About = About {
                name: $name,
                title: $title,
                physics: $physics,
                equation: "dB_geo = s sin(2 pi f u) + c cos(2 pi f u), u = t + (rho - 1) (t - t_0)^2/2T, rho the end_ratio (1 where it is 0)",
                source: "Jankowski and Sucksdorff 1996, IAGA Guide for Magnetic Measurements and Observatory Practice",
                parameters: amplitudes!(
                    0.01 to 100.0: "north_sine_nt", "north_cosine_nt", "east_sine_nt", "east_cosine_nt",
                                   "down_sine_nt", "down_cosine_nt";
                    ParameterInfo::shape("frequency_hz", $low, $high),
                    ParameterInfo::shape("end_ratio", 0.5, 2.0).or_zero()
                ),
                needs: &["time_s"],
                ..About::of(Family::Lines, Place::Environment, Stage::Geo, Acts::Everything)
            };

            fn apply<T: Real>(
                parameters: &[T],
                signal: &mut [Vector3<T>],
                around: &Surroundings<'_, T>,
            ) -> Result {
                let clock = around.clock()?;
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

line! {
    Mains = "mains", 40.0 to 400.0 Hz,
    title: "mains field",
    physics: "Currents of the power supply make a field at the mains' frequency and its harmonics, seen at an alias by a slow logger.",
}

line! {
    TractionPower = "traction_power", 15.0 to 18.0 Hz,
    title: "field of railway power",
    physics: "Currents of an electric railway flow in the rails and in the ground and make a field at the railway's frequency.",
}

line! {
    PeriodicField = "periodic_field", 1e-6 to 1e4 Hz,
    title: "periodic field of an unknown source",
    physics: "A machine, a power supply or a converter nearby makes a field of one frequency; a slow logger shows it at an alias, which does not say which.",
}
