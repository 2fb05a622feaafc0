//! The clock of a logger.

/// A quartz whose rate bends with its temperature.
#[derive(Clone, Copy, Debug)]
pub struct Quartz {
    /// Time error where the campaign's clock is zero, s.
    pub offset_s: f64,
    /// Rate at 25 degC, s per s.
    pub rate: f64,
    /// Parabola of a tuning fork, per K²; −0.035e-6 is common.
    pub parabola_per_k2: f64,
}

impl Quartz {
    /// By how much the readings stamped with given times are too old, s:
    ///
    /// ```text
    /// δ = δ_0 + ∫ (r + p (T − 25)²) dt
    /// ```
    ///
    /// from the campaign's zero, with the temperature as it was at the first of the times before them
    /// (trapezoids between the times). Source: makers' data of 32 kHz tuning-fork crystals; Vig, Quartz
    /// Crystal Resonators and Oscillators.
    pub fn late(&self, times: &[f64], temperature_c: impl Fn(f64) -> f64) -> Vec<f64> {
        let rate = |t: f64| self.rate + self.parabola_per_k2 * (temperature_c(t) - 25.0).powi(2);
        let Some(&first) = times.first() else { return Vec::new() };
        let mut late = self.offset_s + rate(first) * first;
        let mut at = first;
        times
            .iter()
            .map(|&time| {
                late += 0.5 * (rate(at) + rate(time)) * (time - at);
                at = time;
                late
            })
            .collect()
    }
}

/// A quartz of the cut AT: its rate is a cubic of the temperature about an inflection.
#[derive(Clone, Copy, Debug)]
pub struct Cubic {
    /// Rate at the inflection, s per s.
    pub rate: f64,
    /// Slope there, per K.
    pub slope_per_k: f64,
    /// Of the third power, per K³; 1e-10 is common.
    pub cubic_per_k3: f64,
}

/// Temperature of the inflection, degC.
const INFLECTION_C: f64 = 27.0;

impl Cubic {
    /// Its rate at a temperature, s per s: r + a (T − 27) + c (T − 27)³. Source: Bechmann 1956,
    /// Frequency-temperature-angle characteristics of AT-type resonators, Proc. IRE 44, 1600.
    pub fn rate_at(&self, temperature_c: f64) -> f64 {
        let warm = temperature_c - INFLECTION_C;
        self.rate + self.slope_per_k * warm + self.cubic_per_k3 * warm.powi(3)
    }

    /// By how much the readings stamped with given times are too old, s, from the campaign's zero: ∫ rate dt
    /// by trapezoids, before the first of the times with the temperature that it has.
    pub fn late(&self, times: &[f64], temperature_c: impl Fn(f64) -> f64) -> Vec<f64> {
        let rate = |t: f64| self.rate_at(temperature_c(t));
        let Some(&first) = times.first() else { return Vec::new() };
        let (mut late, mut at) = (rate(first) * first, first);
        let next = |&time: &f64| {
            late += 0.5 * (rate(at) + rate(time)) * (time - at);
            at = time;
            late
        };
        times.iter().map(next).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_its_temperature_it_only_gains() {
        let quartz = Quartz { offset_s: 0.5, rate: 2e-6, parabola_per_k2: -3.5e-8 };
        let late = quartz.late(&[100.0, 1100.0], |_| 25.0);
        assert!((late[0] - 0.5002).abs() < 1e-12 && (late[1] - 0.5022).abs() < 1e-12);
    }

    /// A ramp of 1 K in 100 s from 25 degC: ∫ p (t/100)² dt = p t³/3e4.
    #[test]
    fn a_ramp_adds_the_cube_of_time() {
        let quartz = Quartz { offset_s: 0.0, rate: 0.0, parabola_per_k2: -3.5e-8 };
        let times: Vec<f64> = (0..=1000).map(f64::from).collect();
        let late = quartz.late(&times, |t| 25.0 + t / 100.0);
        let exact = -3.5e-8 * 1e9 / 3e4;
        assert!((late[1000] / exact - 1.0).abs() < 1e-5, "{}", late[1000]);
    }

    /// Alike on both sides of the inflection; a ramp adds the integral of the cubic.
    #[test]
    fn a_cubic_is_integrated() {
        let quartz = Cubic { rate: 1e-6, slope_per_k: -2e-8, cubic_per_k3: 1e-10 };
        assert!((quartz.rate_at(32.0) + quartz.rate_at(22.0) - 2e-6).abs() < 1e-18);
        let times: Vec<f64> = (0..=1000).map(f64::from).collect();
        let late = quartz.late(&times, |t| 27.0 + t / 100.0);
        let exact = 1e-6 * 1e3 - 2e-8 * 1e6 / 200.0 + 1e-10 * 1e12 / 4e6;
        assert!((late[1000] / exact - 1.0).abs() < 1e-5, "{} for {exact}", late[1000]);
    }
}
