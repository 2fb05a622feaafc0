use super::prelude::*;
use crate::context::Thermometer;
use crate::memory::{Before, Signal};

impl Effect for CoilTemperature {
    const ABOUT: About = About {
        name: "coil_temperature",
        title: "coil constant follows coil temperature",
        physics: "The coil's former expands as it warms, and the same current makes less field.",
        equation: "B = k (1 + a (T_C - T_ref) 1e-6) I",
        source: "NASA CR-156638, description of test facility (a second winding on each coil against its temperature \
            dependence)",
        parameters: &[ParameterInfo::amplitude("coefficient_ppm_per_k", 0.1, 100.0)],
        needs: &[Thermometer::Coil.column()],
        ..About::of(Family::FollowsColumn, Place::Facility, Stage::Coil, Acts::OneCoil)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let (column, reference) = around.temperature(Thermometer::Coil)?;
        for (own, temperature) in around.own(signal).zip(column.iter()) {
            *own += *own * parameters[0] * ((temperature - reference) * 1e-6);
        }
        Ok(())
    }
}

/// P is the warmth that the recording brings, W what the coil had of the current that flowed before: b = 0 if it was
/// cold, b = a if the first current had flowed for long.
impl Effect for CoilHeating {
    const ABOUT: About = About {
        name: "coil_heating",
        title: "coil constant falls as the coil heats itself",
        physics: "The current warms the winding, its former expands, and the same current makes less field; the \
            warmth comes and goes with the coil's thermal time constant.",
        equation: "B = k (1 - (a P + b W) 1e-6) I, tau dP/dt = I^2 - P, tau dW/dt = -W, P = 0 and W = I^2 at the first row",
        source: "NASA CR-156638, description of test facility (temperature dependence of the main winding)",
        parameters: &[
            ParameterInfo::amplitude("fall_ppm_per_a2", 1.0, 2000.0),
            ParameterInfo::amplitude("fall_at_start_ppm_per_a2", 1.0, 2000.0).or_zero(),
            ParameterInfo::shape("lag_s", 30.0, 20_000.0),
        ],
        needs: &["time_s", "drive of the coil"],
        ..CoilTemperature::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let context = around.context;
        let time = around.times()?;
        let (brought, before, lag_s) = (parameters[0], parameters[1], parameters[2]);
        let squared = |current: &Vector3<f64>| T::from(current[around.axis.index()].powi(2));
        let squared: Vec<T> = context.current_a.iter().map(squared).collect();
        let Some(&first) = squared.first() else { return Ok(()) };
        let warmth =
            Signal::new(time, squared).holding(&context.held).lagged(lag_s, Before::At(T::from(0.0)));
        for ((own, warmth), t) in around.own(signal).zip(warmth).zip(time) {
            let left = first * (lag_s.recip() * (time[0] - t)).exp();
            *own -= *own * (warmth * brought + left * before) * 1e-6;
        }
        Ok(())
    }
}

/// The fast ones of the currents in many bodies, or of the modes of a plate, die so many times as fast.
const FAST: f64 = 5.0;

/// L follows the drive at the first row. In one body q = 0.
impl Effect for EddyCurrents {
    const ABOUT: About = About {
        name: "eddy_currents",
        title: "eddy currents near the coil oppose its changes",
        physics: "A changing coil field induces currents in nearby metal, whose own field opposes the change and \
            decays with the metal's time constant.",
        equation: "dB = -s (B_c - L + q (B_c - L_5)) 1e-6, tau dL/dt = B_c - L, L_5 with tau / 5",
        source: "Leliak 1961, Identification and evaluation of magnetic-field sources of MAD equipped aircraft, IRE \
            Trans. ANE-8, 95",
        parameters: &[
            ParameterInfo::amplitude("share_ppm", 1.0, 50_000.0),
            ParameterInfo::shape("time_constant_s", 1e-3, 1000.0),
            ParameterInfo::shape("fast_ratio", 0.05, 5.0).or_zero(),
        ],
        needs: &["time_s", "drive of the coil"],
        ..About::of(Family::LateResponse, Place::Facility, Stage::Coil, Acts::OneCoil)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let time = around.times()?;
        let drive = Signal::of(time, signal, around.axis.index()).holding(&around.context.held);
        let slow = drive.lagged(parameters[1], Before::Moving);
        let fast = drive.lagged(parameters[1] / FAST, Before::Moving);
        for ((own, slow), fast) in around.own(signal).zip(slow).zip(fast) {
            *own -= (*own - slow + (*own - fast) * parameters[2]) * parameters[0] * 1e-6;
        }
        Ok(())
    }
}
