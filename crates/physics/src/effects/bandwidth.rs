use super::prelude::*;
use crate::memory::Signal;

/// y follows B at the first row. With r = 0 a first-order lag; ΔB ≈ −(1 + r) τ dB/dt.
impl Effect for LoopBandwidth {
    const ABOUT: About = About {
        name: "loop_bandwidth",
        title: "reading follows the field with the loop's lag",
        physics: "The feedback loop needs a time to balance the field, so that a changing field is read too late and, \
            above the loop's bandwidth, too small.",
        equation: "dB = y - B, (1 + tau d/dt)(1 + r tau d/dt) y = B",
        source: "Primdahl 1979, The fluxgate magnetometer, J. Phys. E 12, 241 (feedback loop); Auster et al. \
            2008, The THEMIS fluxgate magnetometer, Space Sci. Rev. 141, 235",
        parameters: &[
            ParameterInfo::shape("lag_s", 1e-4, 10.0),
            ParameterInfo::shape("second_lag_ratio", 0.05, 0.9).or_zero(),
        ],
        needs: &["time_s"],
        ..About::of(Family::LateResponse, Place::Electronics, Stage::Electronics, Acts::OneSensor)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let time = around.times()?;
        let own = around.axis.index();
        let field = Signal::of(time, signal, own).holding(&around.context.held);
        replace(own, field.lagged_twice(parameters[0], parameters[1]), signal);
        Ok(())
    }
}

impl Effect for Delay {
    const ABOUT: About = About {
        name: "delay",
        title: "one channel is sampled late",
        physics: "A filter or a converter hands one channel's value on a fixed time after it was true.",
        equation: "dB = B(t - d) - B(t)",
        parameters: &[ParameterInfo::shape("delay_s", 1e-4, 10.0)],
        ..LoopBandwidth::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let time = around.times()?;
        let own = around.axis.index();
        let field = Signal::of(time, signal, own).holding(&around.context.held);
        replace(own, field.delayed(|_| parameters[0]), signal);
        Ok(())
    }
}

/// Puts a series in place of one component; what is missing stays missing.
pub(super) fn replace<T: Real>(component: usize, series: Vec<T>, signal: &mut [Vector3<T>]) {
    for (value, new) in signal.iter_mut().zip(series) {
        if value[component].re().is_finite() {
            value[component] = new;
        }
    }
}
