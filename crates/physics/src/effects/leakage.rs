use super::prelude::*;
use crate::memory::{Before, Signal};

/// ΔB = g ∘ L in GEO, τ dL/dt = U − L, U the station's variation about its mean.
pub struct NullingLeakage;

impl Effect for NullingLeakage {
    const ABOUT: About = About {
        name: "nulling_leakage",
        title: "natural variations leak through the nulling",
        physics: "The loop that cancels Earth's field senses it elsewhere and late, and a share of each variation is \
            left at the sensors.",
        equation: "dB_geo = g U_lag 1e-6, tau dU_lag/dt = U - U_lag, U = outside - its mean, per axis",
        source: "NASA CR-156638, test of the Earth field nulling system",
        place: Place::Facility,
        stage: Stage::Geo,
        acts: Acts::Everything,
        parameters: &[
            ParameterInfo::amplitude("north_ppm", 100.0, 200_000.0),
            ParameterInfo::amplitude("east_ppm", 100.0, 200_000.0),
            ParameterInfo::amplitude("down_ppm", 100.0, 200_000.0),
            ParameterInfo::shape("lag_s", 0.01, 1000.0),
        ],
        needs: &["time_s", "outside_x_nt, outside_y_nt or outside_z_nt"],
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let context = around.context;
        let time = context.times(Self::ABOUT.name)?;
        let mut found = false;
        for axis in common::Axis::ALL {
            let Some(outside) = context.recording.axis_column("outside", axis, "nt") else { continue };
            found = true;
            let known = outside.iter().filter(|value| value.is_finite());
            let (sum, count) = known.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
            let mean = if count > 0.0 { sum / count } else { 0.0 };
            let variation = Signal::new(time, outside.iter().map(|value| T::from(value - mean)).collect());
            for (field, leaked) in signal.iter_mut().zip(variation.lagged(parameters[3], Before::Moving)) {
                field[axis.index()] += leaked * parameters[axis.index()] * 1e-6;
            }
        }
        if found { Ok(()) } else { Err(context.missing(Self::ABOUT.name, "a column `outside_{x,y,z}_nt`")) }
    }
}
