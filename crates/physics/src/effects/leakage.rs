use super::prelude::*;
use crate::context::finite_mean;
use crate::memory::Signal;
use common::Axis;
use nalgebra::Matrix3;

const fn share(name: &'static str) -> ParameterInfo {
    ParameterInfo::amplitude(name, 100.0, 200_000.0)
}

/// Those of a loop whose sensors and coils are parallel, then what leaks into other axes.
const PARAMETERS: &[ParameterInfo] = &[
    share("north_ppm"),
    share("east_ppm"),
    share("down_ppm"),
    ParameterInfo::shape("lag_s", 0.01, 1000.0),
    share("fast_north_ppm").or_zero(),
    share("fast_east_ppm").or_zero(),
    share("fast_down_ppm").or_zero(),
    ParameterInfo::shape("second_lag_ratio", 0.05, 0.9).or_zero(),
    share("north_from_east_ppm"),
    share("north_from_down_ppm"),
    share("east_from_north_ppm"),
    share("east_from_down_ppm"),
    share("down_from_north_ppm"),
    share("down_from_east_ppm"),
];
const PARALLEL: usize = 8;

/// Where no reference is stated, U is about the mean of the recording.
impl Effect for NullingLeakage {
    const ABOUT: About = About {
        name: "nulling_leakage",
        title: "natural variations leak through the nulling",
        physics: "The loop that cancels Earth's field senses it elsewhere and late, and a share of each variation is \
            left at the sensors.",
        equation: "dB_geo = (g L + f (U - L)) 1e-6, (1 + tau d/dt)(1 + r tau d/dt) L = U = outside - its reference, per axis",
        source: "NASA CR-156638, test of the Earth field nulling system",
        parameters: PARAMETERS.split_at(PARALLEL).0,
        needs: &["time_s", "outside_x_nt, outside_y_nt or outside_z_nt"],
        ..About::of(Family::OutsideField, Place::Facility, Stage::Geo, Acts::Everything)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        leak(parameters, signal, around)
    }
}

impl Effect for NullingLeakageAcross {
    const ABOUT: About = About {
        name: "nulling_leakage_across",
        title: "natural variations leak through the nulling, into other axes too",
        physics: "Sensors and coils of the loop that cancels Earth's field are not parallel, and a variation along one \
            axis is left along the others too.",
        equation: "dB_geo = (G L + f (U - L)) 1e-6, L and U as for nulling_leakage, G a matrix",
        parameters: PARAMETERS,
        ..NullingLeakage::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        leak(parameters, signal, around)
    }
}

/// Adds what leaks of the outside field.
fn leak<T: Real>(p: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
    let context = around.context;
    let time = around.times()?;
    let mut of_slow = Matrix3::from_diagonal(&Vector3::new(p[0], p[1], p[2]));
    if let [a, b, c, d, e, f] = p[PARALLEL..] {
        of_slow = Matrix3::new(p[0], a, b, c, p[1], d, e, f, p[2]);
    }
    let mut found = false;
    for axis in Axis::ALL {
        let Some(outside) = context.recording.axis_column("outside", axis, "nt") else { continue };
        found = true;
        let reference = context.references.outside_nt[axis.index()];
        let reference = reference.or_else(|| finite_mean(outside.iter().copied())).unwrap_or(0.0);
        let variation: Vec<T> = outside.iter().map(|value| T::from(value - reference)).collect();
        let slow = Signal::new(time, variation.clone()).lagged_twice(p[3], p[7]);
        let (of_slow, of_fast) = (of_slow.column(axis.index()), p[4 + axis.index()]);
        for ((field, all), slow) in signal.iter_mut().zip(variation).zip(slow) {
            let fast = if all.re().is_finite() { all - slow } else { T::from(0.0) };
            let mut leaked = of_slow * slow;
            leaked[axis.index()] += fast * of_fast;
            *field += leaked * T::from(1e-6);
        }
    }
    if found { Ok(()) } else { Err(around.missing("a column `outside_{x,y,z}_nt`")) }
}
