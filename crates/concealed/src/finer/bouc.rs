//! Hysteresis that wears off along the way of the field.

/// Bouc and Wen's model with an exponent of 1: what holds the magnetisation back saturates along the way that
/// the field has gone, at one rate where it is loaded and at another where it is unloaded,
///
/// ```text
/// w dz/dB = 1 − (β sign(z dB) + γ) |z|,   β + γ = 1
/// ```
///
/// for a rising field, its mirror image for a falling one; z in −1 to 1, B and w in nT. Source: Wen 1976,
/// Method for random vibration of hysteretic systems, J. Eng. Mech. Div. 102, 249.
#[derive(Clone, Debug)]
pub struct Bouc {
    width_nt: f64,
    /// β − γ: the rate at which it is unloaded, over that at which it is loaded.
    unloading: f64,
    field_nt: f64,
    held: f64,
}

impl Bouc {
    /// A core of a width w, nT, and of a share γ; at rest at zero.
    pub fn new(width_nt: f64, share: f64) -> Self {
        Self { width_nt, unloading: 1.0 - 2.0 * share, field_nt: 0.0, held: 0.0 }
    }

    /// z after the field has gone to `field_nt` without turning.
    pub fn go(&mut self, field_nt: f64) -> f64 {
        let way = (field_nt - self.field_nt) / self.width_nt;
        self.field_nt = field_nt;
        // In the direction of the way z rises.
        let (mut z, mut left) = (self.held * way.signum(), way.abs());
        if z < 0.0 {
            // Unloaded, z comes to zero after so much of the way.
            let to_zero = (1.0 - self.unloading * z).ln() / self.unloading;
            let gone = left.min(to_zero);
            z = ((self.unloading * z - 1.0) * (-self.unloading * gone).exp() + 1.0) / self.unloading;
            left -= gone;
        }
        if left > 0.0 {
            z = 1.0 - (1.0 - z) * (-left).exp();
        }
        self.held = z * way.signum();
        self.held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From rest z = 1 − exp(−B/w), in one go or in many.
    #[test]
    fn the_initial_curve_is_exponential() {
        let (mut once, mut often) = (Bouc::new(2000.0, 0.3), Bouc::new(2000.0, 0.3));
        for k in 1..=40 {
            let field = 150.0 * f64::from(k);
            let exact = -(-field / 2000.0_f64).exp_m1();
            assert!((often.go(field) - exact).abs() < 1e-12);
        }
        assert!((once.go(6000.0) - often.go(6000.0)).abs() < 1e-12);
    }

    /// Whatever its past, z obeys its differential equation.
    #[test]
    fn it_obeys_its_equation() {
        let (width, share) = (1500.0, 0.35);
        for target in [9000.0, 4000.0, -7000.0] {
            let mut core = Bouc::new(width, share);
            core.go(5000.0);
            let sign: f64 = if target > 5000.0 { 1.0 } else { -1.0 };
            let before = core.go(target);
            let after = core.go(target + 0.01 * sign);
            let loaded = (1.0 - share) * (before * sign).signum() + share;
            let slope = sign * (1.0 - loaded * before.abs()) / width * 0.01;
            assert!((after - before - slope).abs() < 1e-9, "{target}");
        }
    }
}
