use super::prelude::*;

/// Demagnetised (z = 0) at the first row; the field is taken as monotonic between rows.
impl Effect for Hysteresis {
    const ABOUT: About = About {
        name: "hysteresis",
        title: "reading depends on the field's history (hysteresis)",
        physics: "Domains in the core follow the field only after it has turned by a coercive field, so that the way \
            up and the way down differ by the same amount everywhere but near the turning points.",
        equation: "dB = -h z, dz/ds = (sign(dB/ds) - z) / B_c, s the way that the field has gone",
        source: "Coleman and Hodgdon 1986, A constitutive relation for rate-independent hysteresis, Int. J. Eng. Sci. \
            24, 897; Ripka 2001, Magnetic Sensors and Magnetometers",
        parameters: &[
            ParameterInfo::amplitude("amplitude_nt", 0.05, 20.0),
            ParameterInfo::shape("coercivity_nt", 10.0, 10_000.0),
        ],
        needs: &["rows in the order taken"],
        ..About::of(Family::OwnField, Place::Sensor, Stage::Sensor, Acts::OneSensor)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let (mut last, mut z): (Option<T>, T) = (None, T::from(0.0));
        for own in around.own(signal) {
            if !own.re().is_finite() {
                continue;
            }
            let change = *own - last.unwrap_or(*own);
            last = Some(*own);
            let end = if change.re() > 0.0 { 1.0 } else { -1.0 };
            let (left, towards) = if change.re() > 0.0 { (-change, end) } else { (change, end) };
            z = (z - towards) * (left / parameters[1]).exp() + towards;
            *own -= parameters[0] * z;
        }
        Ok(())
    }
}

/// The play p moves only when pushed. A recording begins demagnetised (s = 0), or at rest in its first field (s = 1).
impl Effect for Perming {
    const ABOUT: About = About {
        name: "perming",
        title: "offset steps after a large field",
        physics: "A field beyond a threshold magnetises the core or parts near it, and a share of the excess stays \
            when the field has gone.",
        equation: "dB = r p, p = min(max(p, B - B_t), B + B_t), p = s B_1 at first",
        source: "Krasnosel'skii and Pokrovskii 1989, Systems with Hysteresis (play); Primdahl 1979, The fluxgate \
            magnetometer, J. Phys. E 12, 241 (perming)",
        parameters: &[
            ParameterInfo::amplitude("remanence_ppm", 1.0, 1000.0),
            ParameterInfo::shape("threshold_nt", 1000.0, 200_000.0),
            ParameterInfo::span("start_share", 0.1, 1.0),
        ],
        ..Hysteresis::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let mut before = None;
        for own in around.own(signal) {
            if !own.re().is_finite() {
                continue;
            }
            let mut play = before.unwrap_or(*own * parameters[2]);
            let (low, high) = (*own - parameters[1], *own + parameters[1]);
            if play.re() < low.re() {
                play = low;
            } else if play.re() > high.re() {
                play = high;
            }
            *own += parameters[0] * play * 1e-6;
            before = Some(play);
        }
        Ok(())
    }
}
