use super::prelude::*;

impl Effect for WarmUp {
    const ABOUT: About = About {
        name: "warm_up",
        title: "offset settles after switch-on",
        physics: "The instrument warms itself after it is switched on, at the campaign's beginning, and its offset \
            goes to its final value exponentially.",
        equation: "dB = a exp(-t / tau)",
        source: "Jankowski and Sucksdorff 1996, IAGA Guide for Magnetic Measurements and Observatory Practice",
        parameters: &[
            ParameterInfo::amplitude("amplitude_nt", 0.1, 100.0),
            ParameterInfo::shape("time_constant_s", 60.0, 100_000.0),
        ],
        needs: &["time_s"],
        ..About::of(Family::Time, Place::Sensor, Stage::Sensor, Acts::OneSensor)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let clock = around.clock()?;
        let decayed = |t: f64| parameters[0] * (-parameters[1].recip() * t).exp();
        around.own(signal).zip(clock).for_each(|(own, t)| *own += decayed(t));
        Ok(())
    }
}

impl Effect for Ageing {
    const ABOUT: About = About {
        name: "ageing",
        title: "offset drifts with time",
        physics: "Stress in the core relaxes and parts of the electronics age, at a rate that is constant over a \
            campaign.",
        equation: "dB = b t",
        source: "NASA CR-156638, temporal drift in sensor offset",
        parameters: &[ParameterInfo::amplitude("rate_nt_per_day", 0.0005, 5.0)],
        ..WarmUp::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let clock = around.clock()?;
        around.own(signal).zip(clock).for_each(|(own, t)| *own += parameters[0] * (t / DAY_S));
        Ok(())
    }
}

impl Effect for SensitivityAgeing {
    const ABOUT: About = About {
        name: "sensitivity_ageing",
        title: "sensitivity drifts with time",
        physics: "The voltage reference and the feedback coil age, and the scale of the readings goes with them.",
        equation: "dB = B b t 1e-6",
        source: "Tøffner-Clausen et al. 2016, In-flight scalar calibration and characterisation of the Swarm magnetometry package, Earth \
            Planets Space 68, 129",
        parameters: &[ParameterInfo::amplitude("rate_ppm_per_day", 0.001, 100.0)],
        ..WarmUp::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let clock = around.clock()?;
        let grown = |own: T, t: f64| own * parameters[0] * (t / DAY_S * 1e-6);
        around.own(signal).zip(clock).for_each(|(own, t)| *own += grown(*own, t));
        Ok(())
    }
}
