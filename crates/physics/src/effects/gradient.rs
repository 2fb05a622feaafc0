use super::prelude::*;
use crate::Basic;
use common::Axis;

/// Components of the gradient of a coil that is the same all around its axis.
const AXISYMMETRIC: [f64; 5] = [1.0, 0.0, 0.0, 0.0, 0.0];

/// A coil's field of one changes linearly away from its centre, without sources and curl: by five components
/// g, with n the coil's axis and u, v across it (from the nominal axes that follow it),
///
/// ```text
/// ΔB(p) = g₁ (3 n (n·p) − p)/2 + g₂ (n (u·p) + u (n·p)) + g₃ (n (v·p) + v (n·p))
///         + g₄ (u (u·p) − v (v·p)) + g₅ (u (v·p) + v (u·p)),
/// ```
///
/// p in GEO. The first alone is that of a coil that is the same all around its axis.
fn gradient_field<T: Real>(n: &Vector3<T>, coil: Axis, g: &[T], p: &Vector3<T>) -> Vector3<T> {
    let along = n.dot(p);
    let next = (coil.index() + 1) % 3;
    let across = Vector3::from_fn(|k, _| T::from(f64::from(u8::from(k == next))) - n[k] * n[next]);
    let u = across * across.dot(&across).sqrt().recip();
    let v = n.cross(&u);
    let (first, second) = (u.dot(p), v.dot(p));
    (n * (along * 3.0) - p) * (g[0] * 0.5)
        + (n * first + u * along) * g[1]
        + (n * second + v * along) * g[2]
        + (u * first - v * second) * g[3]
        + (u * second + v * first) * g[4]
}

/// m·R ΔB: what the sensor at the place p (SEN, m) sees in each row of a gradient g, for a coil field of one; worked out
/// once where the block does not turn within the recording.
fn seen<T: Real>(
    basic: &Basic<T>,
    context: &Context<'_>,
    (coil, g): (Axis, &[T]),
    sensor: Axis,
    p: &Vector3<T>,
) -> impl Fn(usize) -> T {
    let at = move |row| {
        let rotation = context.rotation(row).map(T::from);
        let n = basic.eta.column(coil.index()).into_owned();
        let added = rotation * gradient_field(&n, coil, g, &(rotation.transpose() * p));
        basic.mu.column(sensor.index()).dot(&added)
    };
    let throughout = context.attitude.is_empty().then(|| at(0));
    move |row| throughout.unwrap_or_else(|| at(row))
}

impl Effect for CoilGradient {
    const ABOUT: About = About {
        name: "coil_gradient",
        title: "coil field differs between the sensors' positions",
        physics: "The coil's field changes across the test volume, and the sensors are not all at its centre; what \
            each sees turns with the block.",
        equation: "dB = m . R G p B_c 1e-6, p = R^T position of the sensor, G = g (3 n n^T - 1) / 2 \
            + g_nu (n u^T + u n^T) + g_nv (n v^T + v n^T) + g_uu (u u^T - v v^T) + g_uv (u v^T + v u^T), u and v the \
            axes that follow n",
        source: "NASA CR-156638, minimise calibration coil gradients; field of a coil without sources and curl, to first order",
        parameters: &[
            ParameterInfo::amplitude("gradient_ppm_per_m", 1.0, 5000.0),
            ParameterInfo::amplitude("gradient_nu_ppm_per_m", 1.0, 5000.0).or_zero(),
            ParameterInfo::amplitude("gradient_nv_ppm_per_m", 1.0, 5000.0).or_zero(),
            ParameterInfo::amplitude("gradient_uu_ppm_per_m", 1.0, 5000.0).or_zero(),
            ParameterInfo::amplitude("gradient_uv_ppm_per_m", 1.0, 5000.0).or_zero(),
        ],
        needs: &["instrument.positions_m"],
        ..About::of(Family::Position, Place::Facility, Stage::Sensor, Acts::OneCoil)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let context = around.context;
        let positions = context
            .positions_m
            .ok_or_else(|| around.missing("the sensors' places, `instrument.positions_m`"))?;
        for sensor in Axis::ALL {
            let p = positions[sensor.index()].map(T::from);
            let seen = seen(around.basic, context, (around.axis, parameters), sensor, &p);
            for (row, (value, coil)) in signal.iter_mut().zip(around.coil_nt).enumerate() {
                let strength = coil[around.axis.index()] * 1e-6;
                value[sensor.index()] += seen(row) * strength;
            }
        }
        Ok(())
    }
}

impl Effect for OffCentre {
    const ABOUT: About = About {
        name: "off_centre",
        title: "sensor block is off the coils' centre",
        physics: "The block's centre is not where the fixture turns about, so that the coils' known gradients give it \
            another field in each orientation.",
        equation: "dB = m . R (3 n (n.p) - p) G I / 2, p = R^T displacement, for each coil",
        source: "NASA CR-156638, procedure for the sensor assembly (the cube's centre must not move)",
        parameters: amplitudes!(0.001 to 0.5: "x_m", "y_m", "z_m"),
        needs: &["facility.coils.*.gradient_nt_per_m_a"],
        ..About::of(Family::Position, Place::Facility, Stage::Sensor, Acts::Everything)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let context = around.context;
        if context.gradient_nt_per_m_a == Vector3::zeros() {
            let what = "a coil's gradient, `facility.coils.x.gradient_nt_per_m_a` or that of another coil";
            return Err(around.missing(what));
        }
        add_gradients(around.basic, context, &[Vector3::from_column_slice(parameters); 3], signal);
        Ok(())
    }
}

/// What is known of the coils' gradients (`facility.coils.*.gradient_nt_per_m_a`) at the sensors' known
/// places (`instrument.positions_m`): a part of the basic chain, in nT along each sensor.
pub fn add_known_gradient<T: Real>(basic: &Basic<T>, context: &Context<'_>, signal: &mut [Vector3<T>]) {
    if let Some(positions) = &context.positions_m {
        add_gradients(basic, context, &positions.map(|p| p.map(T::from)), signal);
    }
}

/// What the coils' gradients along their axes make at the places of the sensors (SEN, m).
fn add_gradients<T: Real>(
    basic: &Basic<T>,
    context: &Context<'_>,
    places: &[Vector3<T>; 3],
    signal: &mut [Vector3<T>],
) {
    let g = AXISYMMETRIC.map(T::from);
    let mut all = Vec::new();
    for coil in Axis::ALL {
        let gradient = context.gradient_nt_per_m_a[coil.index()];
        for sensor in Axis::ALL.into_iter().filter(|_| gradient != 0.0) {
            let seen = seen(basic, context, (coil, &g), sensor, &places[sensor.index()]);
            all.push((coil.index(), sensor.index(), gradient, seen));
        }
    }
    for (row, value) in signal.iter_mut().enumerate().filter(|_| !all.is_empty()) {
        for (coil, sensor, gradient, seen) in &all {
            let strength = *gradient * context.current_a[row][*coil];
            if strength != 0.0 {
                value[*sensor] += seen(row) * strength;
            }
        }
    }
}
