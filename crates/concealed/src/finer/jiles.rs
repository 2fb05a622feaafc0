//! Hysteresis of a core whose domain walls are pinned.

/// Jiles and Atherton's model: pinned walls hold the magnetisation back from the anhysteretic curve, and a
/// share of it bows back and forth without loss:
///
/// ```text
/// A(B) = coth(B / a) − a / B,   dW/dB = (A − W) / (± k),   M = (1 − c) W + c A
/// ```
///
/// in −1 to 1, B in nT, + where the field rises; W stands still while it is beyond A on the way there. The
/// domains' own field is left out. Source: Jiles and Atherton 1986, Theory of ferromagnetic hysteresis, J.
/// Magn. Magn. Mater. 61, 48.
#[derive(Clone, Debug)]
pub struct Jiles {
    shape_nt: f64,
    pinning_nt: f64,
    reversible: f64,
    field_nt: f64,
    walls: f64,
}

impl Jiles {
    /// A core with the shape a of its anhysteretic curve, the pinning k, nT, and the share c that bows back;
    /// demagnetised.
    pub fn new(shape_nt: f64, pinning_nt: f64, reversible: f64) -> Self {
        Self { shape_nt, pinning_nt, reversible, field_nt: 0.0, walls: 0.0 }
    }

    /// The magnetisation after the field has gone to `field_nt`, −1 to 1.
    pub fn go(&mut self, field_nt: f64) -> f64 {
        let way = field_nt - self.field_nt;
        // Steps of a twentieth of the pinning, in each of which the solution of a constant A is exact.
        let count = (20.0 * way.abs() / self.pinning_nt).ceil().max(1.0);
        let step = way / count;
        for number in 0..count as usize {
            let target = self.anhysteretic(self.field_nt + step * (number as f64 + 0.5));
            let behind = target - self.walls;
            if behind * way > 0.0 {
                self.walls += behind * -(-step.abs() / self.pinning_nt).exp_m1();
            }
        }
        self.field_nt = field_nt;
        (1.0 - self.reversible) * self.walls + self.reversible * self.anhysteretic(field_nt)
    }

    /// The magnetisation without pinning, Langevin's function.
    pub fn anhysteretic(&self, field_nt: f64) -> f64 {
        let x = field_nt / self.shape_nt;
        if x.abs() < 1e-3 { x / 3.0 } else { 1.0 / x.tanh() - 1.0 / x }
    }

    /// What the magnetisation lags behind that without pinning.
    pub fn lag(&mut self, field_nt: f64) -> f64 {
        self.go(field_nt) - self.anhysteretic(field_nt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_pinning_it_is_the_anhysteretic_curve() {
        let mut core = Jiles::new(30_000.0, 1.0, 0.1);
        for field in [20_000.0, -35_000.0, 4_000.0, 500.0] {
            assert!(core.lag(field).abs() < 1e-4, "{field}");
        }
    }

    /// In small fields A = B / 3a, and a demagnetised core in a rising field has M = (B − k + k exp(−B / k))
    /// / 3a.
    #[test]
    fn the_initial_curve_is_its_closed_form() {
        let (shape, pinning) = (1e6, 2000.0);
        let mut core = Jiles::new(shape, pinning, 0.0);
        for field in [500.0, 1500.0, 4000.0, 9000.0] {
            let exact = (field - pinning + pinning * (-field / pinning).exp()) / (3.0 * shape);
            let found = core.go(field);
            assert!((found / exact - 1.0).abs() < 1e-2, "{field}: {found} for {exact}");
        }
    }

    /// Cycles between two fields close after the first, and lose energy.
    #[test]
    fn a_loop_closes_and_encloses_an_area() {
        let mut core = Jiles::new(30_000.0, 3000.0, 0.2);
        let round = |core: &mut Jiles| -> Vec<f64> {
            (0..400)
                .map(|k| core.go(50_000.0 * (std::f64::consts::TAU * f64::from(k) / 400.0).cos()))
                .collect()
        };
        (0..3).for_each(|_| drop(round(&mut core)));
        let (one, next) = (round(&mut core), round(&mut core));
        assert!(one.iter().zip(&next).all(|(a, b)| (a - b).abs() < 1e-9));
        // Falling through zero field it is still magnetised upwards, rising downwards.
        assert!(one[100] > 1e-3 && one[300] < -1e-3, "{} {}", one[100], one[300]);
        assert!((one[100] + one[300]).abs() < 1e-6);
    }
}
