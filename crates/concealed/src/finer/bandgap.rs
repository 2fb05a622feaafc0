//! A voltage reference of a semiconductor's band gap.

/// Curvature of the reference, per K: η k / (e V) with η = 3 and V = 1.2 V.
const CURVATURE: f64 = 2.15e-4;

/// What a reference that is level at `level_c` departs by, relative:
///
/// ```text
/// V/V_0 − 1 = κ (T − T_0 − T ln(T/T_0)),   T in K
/// ```
///
/// Source: Tsividis 1980, Accurate analysis of temperature effects in I_C-V_BE characteristics, IEEE J.
/// Solid-State Circuits 15, 1076.
pub fn departure(temperature_c: f64, level_c: f64) -> f64 {
    let (t, level) = (temperature_c + 273.15, level_c + 273.15);
    CURVATURE * (t - level - t * (t / level).ln())
}

/// Its slope at a temperature, per K.
pub fn slope(temperature_c: f64, level_c: f64) -> f64 {
    -CURVATURE * ((temperature_c + 273.15) / (level_c + 273.15)).ln()
}

/// Half of its second derivative, per K²: the curvature of a parabola through it.
pub fn curvature(temperature_c: f64) -> f64 {
    -0.5 * CURVATURE / (temperature_c + 273.15)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Level at its temperature, with the stated slope and curvature elsewhere.
    #[test]
    fn it_has_its_slope_and_curvature() {
        assert!(departure(40.0, 40.0).abs() < 1e-15 && slope(40.0, 40.0).abs() < 1e-15);
        for t in [5.0, 26.0, 60.0] {
            let of = |dt: f64| departure(t + dt, 40.0);
            assert!(((of(0.1) - of(-0.1)) / 0.2 - slope(t, 40.0)).abs() < 1e-9);
            assert!((0.5 * (of(1.0) + of(-1.0)) - of(0.0) - curvature(t)).abs() < 1e-10);
        }
    }
}
