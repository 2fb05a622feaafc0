use super::prelude::*;
use crate::memory::Signal;

/// ΔB = g ∘ L + f ∘ (U − L) in GEO, (1 + τ d/dt)(1 + r τ d/dt) L = U, U the station's variation about its mean: g leaks
/// of slow variations, f of fast ones, through a loop of one pole (r = 0) or of two.
pub struct NullingLeakage;

impl Effect for NullingLeakage {
    const ABOUT: About = About {
        name: "nulling_leakage",
        title: "natural variations leak through the nulling",
        physics: "The loop that cancels Earth's field senses it elsewhere and late, and a share of each variation is \
            left at the sensors.",
        equation: "dB_geo = (g L + f (U - L)) 1e-6, (1 + tau d/dt)(1 + r tau d/dt) L = U = outside - its mean, per axis",
        source: "NASA CR-156638, test of the Earth field nulling system",
        family: Family::OutsideField,
        place: Place::Facility,
        stage: Stage::Geo,
        acts: Acts::Everything,
        parameters: &[
            ParameterInfo::amplitude("north_ppm", 100.0, 200_000.0),
            ParameterInfo::amplitude("east_ppm", 100.0, 200_000.0),
            ParameterInfo::amplitude("down_ppm", 100.0, 200_000.0),
            ParameterInfo::shape("lag_s", 0.01, 1000.0),
            ParameterInfo::amplitude("fast_north_ppm", 100.0, 200_000.0).or_zero(),
            ParameterInfo::amplitude("fast_east_ppm", 100.0, 200_000.0).or_zero(),
            ParameterInfo::amplitude("fast_down_ppm", 100.0, 200_000.0).or_zero(),
            ParameterInfo::shape("second_lag_ratio", 0.05, 0.9).or_zero(),
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
            let variation: Vec<T> = outside.iter().map(|value| T::from(value - mean)).collect();
            let slow = Signal::new(time, variation.clone()).lagged_twice(parameters[3], parameters[7]);
            let [of_slow, of_fast] = [parameters[axis.index()], parameters[4 + axis.index()]];
            for ((field, all), slow) in signal.iter_mut().zip(variation).zip(slow) {
                let fast = if all.re().is_finite() { all - slow } else { T::from(0.0) };
                field[axis.index()] += (slow * of_slow + fast * of_fast) * 1e-6;
            }
        }
        if found { Ok(()) } else { Err(context.missing(Self::ABOUT.name, "a column `outside_{x,y,z}_nt`")) }
    }
}
