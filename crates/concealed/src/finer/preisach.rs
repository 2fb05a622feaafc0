//! Hysteresis of a core with many domains.

/// Preisach's model: relays that switch up at u + h and down at u − h, with coercive fields h of a log-normal
/// distribution and interaction fields u of a normal one. Relays of one h are up for all u below the play
/// operator's output P_h, so that
///
/// ```text
/// M = Σ_h w_h (2 Φ(P_h / σ) − 1),   P_h = min(max(P_h, B − h), B + h)
/// ```
///
/// in −1 to 1, B in nT. Source: Mayergoyz 1991, Mathematical Models of Hysteresis; Visintin 1994,
/// Differential Models of Hysteresis.
#[derive(Clone, Debug)]
pub struct Preisach {
    /// Coercive field, weight, and where its play operator stands.
    classes: Vec<(f64, f64, f64)>,
    interaction_nt: f64,
}

/// Classes of coercive fields.
const CLASSES: usize = 41;

impl Preisach {
    /// A core with a median coercive field, the standard deviation of its logarithm, and that of the
    /// interaction fields; demagnetised.
    pub fn new(coercive_nt: f64, spread: f64, interaction_nt: f64) -> Self {
        let position = |k: usize| 3.0 * (2.0 * k as f64 / (CLASSES - 1) as f64 - 1.0);
        let weight = |k: usize| (-0.5 * position(k).powi(2)).exp();
        let sum: f64 = (0..CLASSES).map(weight).sum();
        let class = |k: usize| (coercive_nt * (spread * position(k)).exp(), weight(k) / sum, 0.0);
        Self { classes: (0..CLASSES).map(class).collect(), interaction_nt }
    }

    /// The magnetisation after the field has gone to `field_nt`, −1 to 1.
    pub fn go(&mut self, field_nt: f64) -> f64 {
        let mut sum = 0.0;
        for (coercive, weight, play) in &mut self.classes {
            *play = play.max(field_nt - *coercive).min(field_nt + *coercive);
            sum += *weight * erf(*play / (self.interaction_nt * std::f64::consts::SQRT_2));
        }
        sum
    }

    /// What the magnetisation lags behind that of the same core without coercive fields, −1 to 1.
    pub fn lag(&mut self, field_nt: f64) -> f64 {
        self.go(field_nt) - erf(field_nt / (self.interaction_nt * std::f64::consts::SQRT_2))
    }
}

/// The error function to 1.2e-7. Source: Press et al. 1992, Numerical Recipes in C, section 6.2.
fn erf(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.5 * x.abs());
    let series = [
        -1.26551223,
        1.00002368,
        0.37409196,
        0.09678418,
        -0.18628806,
        0.27886807,
        -1.13520398,
        1.48851587,
        -0.82215223,
        0.17087277,
    ];
    let polynomial = series.iter().rev().fold(0.0, |sum, c| sum * t + c);
    let complement = t * (-x * x + polynomial).exp();
    if x >= 0.0 { 1.0 - complement } else { complement - 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(core: &mut Preisach, to: f64, from: f64) -> Vec<f64> {
        (0..=50).map(|k| core.go(from + (to - from) * f64::from(k) / 50.0)).collect()
    }

    #[test]
    fn a_minor_loop_returns_to_its_point() {
        let mut core = Preisach::new(2000.0, 0.4, 30_000.0);
        core.go(40_000.0);
        let left = core.go(5_000.0);
        core.go(12_000.0);
        assert!((core.go(5_000.0) - left).abs() < 1e-12);
    }

    /// Minor loops between the same fields are congruent, whatever was before.
    #[test]
    fn minor_loops_are_congruent() {
        let loops = |before: f64| {
            let mut core = Preisach::new(2000.0, 0.4, 30_000.0);
            core.go(before);
            core.go(1_000.0);
            core.go(9_000.0);
            let down = path(&mut core, 1_000.0, 9_000.0);
            let low = down[down.len() - 1];
            down.iter().map(|m| m - low).collect::<Vec<f64>>()
        };
        let (one, other) = (loops(50_000.0), loops(-50_000.0));
        assert!(one.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    /// A larger excursion wipes out the smaller ones before it.
    #[test]
    fn a_larger_excursion_wipes_out() {
        let end = |between: &[f64]| {
            let mut core = Preisach::new(2000.0, 0.4, 30_000.0);
            core.go(60_000.0);
            between.iter().for_each(|b| {
                core.go(*b);
            });
            core.go(-60_000.0);
            core.go(3_000.0)
        };
        assert!((end(&[]) - end(&[-5_000.0, 7_000.0, -9_000.0])).abs() < 1e-12);
    }

    #[test]
    fn without_coercive_fields_there_is_no_loop() {
        let mut core = Preisach::new(1e-6, 0.1, 30_000.0);
        assert!([3e4, -2e4, 1e4].into_iter().all(|b| core.lag(b).abs() < 1e-6));
    }
}
