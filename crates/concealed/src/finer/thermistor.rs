//! A thermistor that is read along a straight line.

/// Zero of the Celsius scale, K.
const ZERO_C: f64 = 273.15;

/// A thermistor of R = R_0 exp(β (1/T − 1/T_0)) in a divider with a resistor of r R_0, whose voltage is read
/// along its tangent at T_0.
#[derive(Clone, Copy, Debug)]
pub struct Thermistor {
    /// β, K.
    pub beta_k: f64,
    /// The divider's resistor over the thermistor at T_0.
    pub ratio: f64,
    /// T_0, degC.
    pub tangent_c: f64,
}

impl Thermistor {
    /// Share of the voltage on the divider's resistor at a temperature.
    fn share(&self, temperature_c: f64) -> f64 {
        let inverse = 1.0 / (temperature_c + ZERO_C) - 1.0 / (self.tangent_c + ZERO_C);
        self.ratio / (self.ratio + (self.beta_k * inverse).exp())
    }

    fn slope(&self) -> f64 {
        let share = self.share(self.tangent_c);
        share * (1.0 - share) * self.beta_k / (self.tangent_c + ZERO_C).powi(2)
    }

    /// What is read at a temperature, degC.
    pub fn read(&self, temperature_c: f64) -> f64 {
        self.tangent_c + (self.share(temperature_c) - self.share(self.tangent_c)) / self.slope()
    }

    /// The temperature at which something is read, degC:
    ///
    /// ```text
    /// 1/T = 1/T_0 + ln(r (1/s − 1)) / β,   s = s_0 + s_0' (reading − T_0)
    /// ```
    ///
    /// Source: Steinhart and Hart 1968, Calibration curves for thermistors, Deep-Sea Res. 15, 497 (of which
    /// this is the first term).
    pub fn temperature(&self, read_c: f64) -> f64 {
        let share = self.share(self.tangent_c) + self.slope() * (read_c - self.tangent_c);
        let resistance = self.ratio * (1.0 / share.clamp(1e-6, 1.0 - 1e-6) - 1.0);
        1.0 / (1.0 / (self.tangent_c + ZERO_C) + resistance.ln() / self.beta_k) - ZERO_C
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_gives_back_the_temperature() {
        let thermistor = Thermistor { beta_k: 3900.0, ratio: 0.4, tangent_c: 26.0 };
        for t in [5.0, 18.0, 26.0, 33.0, 45.0] {
            assert!((thermistor.temperature(thermistor.read(t)) - t).abs() < 1e-9, "{t}");
        }
    }

    /// At its temperature the line touches: right, and with the right slope.
    #[test]
    fn the_line_is_a_tangent() {
        let thermistor = Thermistor { beta_k: 3500.0, ratio: 2.0, tangent_c: 20.0 };
        assert!((thermistor.read(20.0) - 20.0).abs() < 1e-12);
        assert!((thermistor.read(20.01) - thermistor.read(19.99) - 0.02).abs() < 1e-6);
        assert!((thermistor.read(30.0) - 30.0).abs() > 0.1);
    }
}
