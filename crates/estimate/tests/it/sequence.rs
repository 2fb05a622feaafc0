//! Random numbers that are the same in every run.

/// Knuth's 64-bit linear congruential sequence; its upper bits are good enough for noise.
pub struct Sequence(pub u64);

impl Sequence {
    /// Uniform in 0 … 1, neither end included.
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
    }

    /// Normal numbers with standard deviation `std` (Box and Muller).
    pub fn white(&mut self, count: usize, std: f64) -> Vec<f64> {
        (0..count)
            .map(|_| {
                let size = (-2.0 * self.uniform().ln()).sqrt();
                std * size * (std::f64::consts::TAU * self.uniform()).cos()
            })
            .collect()
    }
}
