use super::prelude::*;
use crate::Basic;
use common::Axis;

/// A coil's field changes linearly away from its centre. Along the coil's axis n by g, across it by −g/2 (the
/// field of an axisymmetric coil has no sources): ΔB(p) = B_c g (3 n (n·p) − p)/2, p in GEO, g in ppm/m.
fn gradient_field<T: Real>(n: &Vector3<T>, p: &Vector3<T>) -> Vector3<T> {
    let along = n[0] * p[0] + n[1] * p[1] + n[2] * p[2];
    (n * (along * 3.0) - p) * T::from(0.5)
}

/// m·R ΔB: what the sensor at the place p (SEN, m) sees of it, for a coil field of one.
fn seen<T: Real>(
    basic: &Basic<T>,
    context: &Context<'_>,
    row: usize,
    coil: Axis,
    sensor: Axis,
    p: &Vector3<T>,
) -> T {
    let rotation = context.rotation(row).map(T::from);
    let n = basic.eta.column(coil.index()).into_owned();
    let added = rotation * gradient_field(&n, &(rotation.transpose() * p));
    let m = basic.mu.column(sensor.index());
    m[0] * added[0] + m[1] * added[1] + m[2] * added[2]
}

/// The same for every row: worked out once where the block does not turn within the recording.
fn seen_by_row<T: Real>(
    basic: &Basic<T>,
    context: &Context<'_>,
    coil: Axis,
    sensor: Axis,
    p: &Vector3<T>,
) -> impl Fn(usize) -> T {
    let at = move |row| seen(basic, context, row, coil, sensor, p);
    let throughout = context.attitude.is_empty().then(|| at(0));
    move |row| throughout.unwrap_or_else(|| at(row))
}

/// The sensors are not at one point, and one coil has a gradient; the positions are `instrument.positions_m`
/// (SEN).
pub struct CoilGradient;

impl Effect for CoilGradient {
    const ABOUT: About = About {
        name: "coil_gradient",
        title: "coil field differs between the sensors' positions",
        physics: "The coil's field changes across the test volume, and the sensors are not all at its centre; what \
            each sees turns with the block.",
        equation: "dB = m . R (3 n (n.p) - p) B_c g 1e-6 / 2, p = R^T position of the sensor",
        source: "NASA CR-156638, minimise calibration coil gradients; divergence-free field of an axisymmetric coil",
        place: Place::Facility,
        stage: Stage::Sensor,
        acts: Acts::OneCoil,
        parameters: &[ParameterInfo::amplitude("gradient_ppm_per_m", 1.0, 5000.0)],
        needs: &["instrument.positions_m"],
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let context = around.context;
        let positions = context.positions_m.ok_or_else(|| {
            context.missing(Self::ABOUT.name, "the sensors' places, `instrument.positions_m`")
        })?;
        for sensor in Axis::ALL {
            let p = positions[sensor.index()].map(T::from);
            let seen = seen_by_row(around.basic, context, around.axis, sensor, &p);
            for (row, (value, coil)) in signal.iter_mut().zip(around.coil_nt).enumerate() {
                let strength = coil[around.axis.index()] * parameters[0] * 1e-6;
                value[sensor.index()] += seen(row) * strength;
            }
        }
        Ok(())
    }
}

/// The block's centre is off the coils' centre by p (SEN, m); the coils' gradients are
/// `facility.coils.*.gradient_nt_per_m_a`.
pub struct OffCentre;

impl Effect for OffCentre {
    const ABOUT: About = About {
        name: "off_centre",
        title: "sensor block is off the coils' centre",
        physics: "The block's centre is not where the fixture turns about, so that the coils' known gradients give it \
            another field in each orientation.",
        equation: "dB = m . R (3 n (n.p) - p) G I / 2, p = R^T displacement, for each coil",
        source: "NASA CR-156638, procedure for the sensor assembly (the cube's centre must not move)",
        place: Place::Facility,
        stage: Stage::Sensor,
        acts: Acts::Everything,
        parameters: &[
            ParameterInfo::amplitude("x_m", 0.001, 0.5),
            ParameterInfo::amplitude("y_m", 0.001, 0.5),
            ParameterInfo::amplitude("z_m", 0.001, 0.5),
        ],
        needs: &["facility.coils.*.gradient_nt_per_m_a"],
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let context = around.context;
        let gradient = context.gradient_nt_per_m_a;
        if gradient == Vector3::zeros() {
            let what = "a coil's gradient, `facility.coils.x.gradient_nt_per_m_a` or that of another coil";
            return Err(context.missing(Self::ABOUT.name, what));
        }
        let p = Vector3::from_column_slice(parameters);
        for coil in Axis::ALL {
            for sensor in Axis::ALL {
                let seen = seen_by_row(around.basic, context, coil, sensor, &p);
                for (row, value) in signal.iter_mut().enumerate() {
                    let strength = gradient[coil.index()] * context.current_a[row][coil.index()];
                    if strength != 0.0 {
                        value[sensor.index()] += seen(row) * strength;
                    }
                }
            }
        }
        Ok(())
    }
}

/// What is known of the coils' gradients (`facility.coils.*.gradient_nt_per_m_a`) at the sensors' known
/// places (`instrument.positions_m`): a part of the basic chain, in nT along each sensor.
pub fn add_known_gradient<T: Real>(basic: &Basic<T>, context: &Context<'_>, signal: &mut [Vector3<T>]) {
    let Some(positions) = &context.positions_m else { return };
    for coil in Axis::ALL {
        let gradient = context.gradient_nt_per_m_a[coil.index()];
        for sensor in Axis::ALL.into_iter().filter(|_| gradient != 0.0) {
            let p = positions[sensor.index()].map(T::from);
            let seen = seen_by_row(basic, context, coil, sensor, &p);
            for (row, value) in signal.iter_mut().enumerate() {
                value[sensor.index()] += seen(row) * (gradient * context.current_a[row][coil.index()]);
            }
        }
    }
}
