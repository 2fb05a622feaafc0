//! Currents between unlike metals that the Sun warms.

use super::ode;

/// One plate of a spacecraft: where it looks, and the field that its warmth makes at the sensors.
#[derive(Clone, Copy, Debug)]
pub struct Plate {
    /// Unit normal, body frame.
    pub normal: [f64; 3],
    /// Field of the full Sun, body frame, nT.
    pub field_nt: [f64; 3],
}

/// Field of all plates, body frame, nT, at given times. A plate takes in what Lambert's law gives it, and
/// warms late:
///
/// ```text
/// τ dw/dt = lit max(0, n · s) − w,   dB = Σ w b
/// ```
///
/// `sun` is the unit vector to the Sun in the body frame, zero in eclipse. Source: Tøffner-Clausen et al.
/// 2016, Earth Planets Space 68, 129, for the cause; Wertz 1978, Spacecraft Attitude Determination and
/// Control, section 17.2, for plates in the Sun.
pub fn field(
    plates: &[Plate],
    sun: impl Fn(f64) -> [f64; 3],
    times: &[f64],
    tau_s: f64,
    before_s: f64,
) -> Vec<[f64; 3]> {
    let Some(first) = times.first() else { return Vec::new() };
    let mut sum = vec![[0.0; 3]; times.len()];
    for plate in plates {
        let taken = |t: f64| {
            let s = sun(t);
            (0..3).map(|k| s[k] * plate.normal[k]).sum::<f64>().max(0.0)
        };
        let from = first - before_s;
        let warm = ode::march(from, [taken(from)], times, 0.2 * tau_s, |t, w| [(taken(t) - w[0]) / tau_s]);
        for (field, w) in sum.iter_mut().zip(warm) {
            (0..3).for_each(|k| field[k] += w[0] * plate.field_nt[k]);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six plates of a cube whose fields are n, 0, 0 for ±n give back the Sun's direction; in eclipse nothing
    /// is left.
    #[test]
    fn a_cube_in_the_sun() {
        let axis = |k: usize, sign: f64| std::array::from_fn(|j| if j == k { sign } else { 0.0 });
        let plates: Vec<Plate> = (0..3)
            .flat_map(|k| [1.0, -1.0].map(|sign| Plate { normal: axis(k, sign), field_nt: axis(k, sign) }))
            .collect();
        let s = [0.36, -0.48, 0.8];
        let found = field(&plates, |t| if t < 100.0 { s } else { [0.0; 3] }, &[90.0, 400.0], 5.0, 100.0);
        assert!((0..3).all(|k| (found[0][k] - s[k]).abs() < 1e-6 && found[1][k].abs() < 1e-6), "{found:?}");
    }
}
