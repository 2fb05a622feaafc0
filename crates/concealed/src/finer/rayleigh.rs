//! Hysteresis of a core in weak fields.

/// Rayleigh's law with a memory of turning points: from the demagnetised state M = B |B| / 2, from a turning
/// point (B_t, M_t)
///
/// ```text
/// M = M_t ± (B − B_t)² / 4
/// ```
///
/// and where a branch meets the one that it left, the two are forgotten (Madelung's rules). In units of the
/// constant; the reversible part, which is proportional to the field, is left out. Source: Bozorth 1951,
/// Ferromagnetism, chapter 11 (Rayleigh's law).
#[derive(Clone, Debug, Default)]
pub struct Rayleigh {
    /// Turning points in their order, each within those before it.
    turns: Vec<f64>,
    field: f64,
}

impl Rayleigh {
    /// The magnetisation after the field has gone to `field` without turning.
    pub fn go(&mut self, field: f64) -> f64 {
        let way = field - self.field;
        let came_from = self.turns.last().copied().unwrap_or(0.0);
        if way * (self.field - came_from) < 0.0 {
            self.turns.push(self.field);
        }
        self.field = field;
        loop {
            match self.turns[..] {
                [.., before, _] if (field - before) * way >= 0.0 => self.turns.truncate(self.turns.len() - 2),
                [first] if way * first < 0.0 && field.abs() >= first.abs() => self.turns.clear(),
                _ => break,
            }
        }
        self.now()
    }

    fn now(&self) -> f64 {
        let Some(first) = self.turns.first() else { return 0.5 * self.field * self.field.abs() };
        let (mut at, mut sum) = (*first, 0.5 * first * first.abs());
        for next in self.turns[1..].iter().chain([&self.field]) {
            sum += 0.25 * (next - at) * (next - at).abs();
            at = *next;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between ± B_m a loop is M = (B_m B ± (B_m² − B²) / 2) / 2, with a remanence of B_m² / 4.
    #[test]
    fn a_loop_is_two_parabolas() {
        let mut core = Rayleigh::default();
        core.go(3.0);
        for k in 0..=12 {
            let b = 3.0 - 0.5 * f64::from(k);
            let down = 0.5 * (3.0 * b + 0.5 * (9.0 - b * b));
            assert!((core.go(b) - down).abs() < 1e-12, "{b}");
        }
        for k in 0..=12 {
            let b = -3.0 + 0.5 * f64::from(k);
            let up = 0.5 * (3.0 * b - 0.5 * (9.0 - b * b));
            assert!((core.go(b) - up).abs() < 1e-12, "{b}");
        }
    }

    /// A smaller loop closes where it began, and beyond it the larger one goes on as if nothing had been.
    #[test]
    fn a_smaller_loop_is_forgotten() {
        let end = |between: &[f64]| {
            let mut core = Rayleigh::default();
            core.go(5.0);
            core.go(-2.0);
            between.iter().for_each(|b| {
                core.go(*b);
            });
            core.go(4.0)
        };
        assert!((end(&[]) - end(&[1.0, -1.0, 0.5, -0.5, 1.5])).abs() < 1e-12);
        assert!((end(&[]) - end(&[1.0, 0.0, 0.5, 0.2])).abs() < 1e-12);
    }

    /// Beyond every earlier field the initial curve goes on.
    #[test]
    fn the_initial_curve_comes_back() {
        let mut core = Rayleigh::default();
        [2.0, -1.0, 1.5].into_iter().for_each(|b| {
            core.go(b);
        });
        assert!((core.go(-4.0) + 8.0).abs() < 1e-12);
        assert!((core.go(6.0) - 18.0).abs() < 1e-12);
    }
}
