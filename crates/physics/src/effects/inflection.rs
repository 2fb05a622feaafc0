use super::prelude::*;
use super::temperature::{Of, add};
use crate::context::{KELVIN, Thermometer};

/// The coefficient goes from c − h, far below T_i, to c + h, over a range w.
impl Effect for OffsetTemperatureInflection {
    const ABOUT: About = About {
        name: "offset_temperature_inflection",
        title: "offset follows sensor temperature, with a coefficient that changes at an inflection",
        physics: "Parts of unlike expansion, or a compensation that works to one side only, let the coefficient of the offset go from \
            one value to another about a temperature, often through zero.",
        equation: "dB = c (T_S - T_ref) + h w (g((T_S - T_i)/w) - g((T_ref - T_i)/w)), g(u) = ln cosh u, T_i in K",
        source: "Jankowski and Sucksdorff 1996, IAGA Guide for Magnetic Measurements and Observatory Practice (temperature \
            coefficients of variometers)",
        parameters: amplitudes!(
            0.005 to 5.0: "coefficient_nt_per_k", "half_change_nt_per_k";
            ParameterInfo::shape("inflection_k", 245.0, 350.0),
            ParameterInfo::shape("width_k", 0.3, 10.0)
        ),
        needs: &[Thermometer::Sensor.column()],
        ..About::of(Family::FollowsColumn, Place::Sensor, Stage::Sensor, Acts::OneSensor)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let (coefficient, half_change) = (parameters[0], parameters[1]);
        let (inflection_k, width_k) = (parameters[2], parameters[3]);
        let (column, reference) = around.temperature(Thermometer::Sensor)?;
        let bent = |celsius: f64| width_k * log_cosh((-inflection_k + KELVIN + celsius) / width_k);
        let at_reference = bent(reference);
        let change = |t: &f64| coefficient * (t - reference) + half_change * (bent(*t) - at_reference);
        add(Of::Offset, column.iter().map(change).collect(), signal, around);
        Ok(())
    }
}

/// ln cosh u = |u| + ln(1 + e^(−2|u|)) − ln 2, without overflow.
fn log_cosh<T: Real>(u: T) -> T {
    let size = if u.re() < 0.0 { -u } else { u };
    size + (size * -2.0).exp().ln_1p() - std::f64::consts::LN_2
}
