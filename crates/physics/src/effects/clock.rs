use super::bandwidth::replace;
use super::prelude::*;
use crate::memory::Signal;

impl Effect for ClockOffset {
    const ABOUT: About = About {
        name: "clock_offset",
        title: "readings carry a wrong time",
        physics: "The logger's clock differs from the clock of the drive by a fixed time, so that all sensors err in \
            proportion to the rate of the field.",
        equation: "dB = B(t - dt) - B(t), all sensors",
        source: "INTERMAGNET Technical Reference Manual (time-stamp accuracy); ΔB = Δt dB/dt to first order",
        parameters: &[ParameterInfo::amplitude("offset_s", 1e-3, 60.0)],
        needs: &["time_s"],
        ..About::of(Family::LateResponse, Place::Logger, Stage::Sampling, Acts::Everything)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let time = around.times()?;
        shift(around.context, time, |_| parameters[0], signal);
        Ok(())
    }
}

/// t counts from the campaign's beginning.
impl Effect for ClockRate {
    const ABOUT: About = About {
        name: "clock_rate",
        title: "the logger's clock gains or loses",
        physics: "The logger's quartz runs at another rate than the clock of the drive, so that the time error grows \
            through the campaign.",
        equation: "dB = B(t - r t) - B(t), all sensors",
        parameters: &[ParameterInfo::amplitude("rate_ppm", 0.1, 1000.0)],
        ..ClockOffset::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let time = around.times()?;
        let clock = around.clock()?;
        shift(around.context, time, |row| parameters[0] * (clock[row] * 1e-6), signal);
        Ok(())
    }
}

fn shift<T: Real>(
    context: &Context<'_>,
    time: &[f64],
    delay: impl Fn(usize) -> T,
    signal: &mut [Vector3<T>],
) {
    for component in 0..3 {
        let field = Signal::of(time, signal, component).holding(&context.held);
        replace(component, field.delayed(&delay), signal);
    }
}
