//! Hysteresis as a sum of play operators.

/// Prandtl and Ishlinskii's model: each operator follows the field with a play of its own half-width r,
///
/// ```text
/// P_r = min(max(P_r, B − r), B + r),   z = Σ_r w_r P_r
/// ```
///
/// in nT where the weights have no unit. Source: Krasnosel'skii and Pokrovskii 1989, Systems with Hysteresis;
/// Visintin 1994, Differential Models of Hysteresis.
#[derive(Clone, Debug)]
pub struct Plays {
    /// Half-width, weight, and where it stands.
    operators: Vec<(f64, f64, f64)>,
}

impl Plays {
    /// Operators of given half-widths, nT, and weights; at rest at zero.
    pub fn new(operators: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { operators: operators.into_iter().map(|(width, weight)| (width, weight, 0.0)).collect() }
    }

    /// The sum after the field has gone to `field_nt` without turning.
    pub fn go(&mut self, field_nt: f64) -> f64 {
        let mut sum = 0.0;
        for (width, weight, play) in &mut self.operators {
            *play = play.max(field_nt - *width).min(field_nt + *width);
            sum += *weight * *play;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> Plays {
        Plays::new([(500.0, 0.2), (1500.0, 0.5), (4000.0, 0.3)])
    }

    /// From rest z = Σ w max(B − r, 0); after a turn each operator waits for twice its half-width.
    #[test]
    fn the_initial_curve_and_the_way_back_are_straight_pieces() {
        let mut plays = model();
        assert!((plays.go(1000.0) - 0.2 * 500.0).abs() < 1e-12);
        assert!((plays.go(6000.0) - (0.2 * 5500.0 + 0.5 * 4500.0 + 0.3 * 2000.0)).abs() < 1e-12);
        let left = 0.2 * 5500.0 + 0.5 * 4500.0 + 0.3 * 2000.0;
        assert!((plays.go(5000.0) - left).abs() < 1e-12);
        assert!((plays.go(4000.0) - (left - 0.2 * 1000.0)).abs() < 1e-12);
    }

    /// A minor loop comes back to the point where it began.
    #[test]
    fn a_return_point_is_remembered() {
        let mut plays = model();
        plays.go(20_000.0);
        let left = plays.go(5000.0);
        plays.go(9000.0);
        plays.go(7000.0);
        plays.go(8000.0);
        assert!((plays.go(5000.0) - left).abs() < 1e-12);
    }

    /// A larger excursion wipes out the smaller ones before it.
    #[test]
    fn a_larger_excursion_wipes_out() {
        let end = |between: &[f64]| {
            let mut plays = model();
            plays.go(30_000.0);
            between.iter().for_each(|b| {
                plays.go(*b);
            });
            plays.go(-30_000.0)
        };
        assert!((end(&[]) - end(&[-5000.0, 12_000.0])).abs() < 1e-12);
    }
}
