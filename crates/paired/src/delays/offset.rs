//! Offsets with uncertainties: their mean, and how they scatter.

use common::OffsetScatter;
use estimate::line_search::{self, Accuracy};
use estimate::stats;
use std::convert::Infallible;

/// To which the variance between offsets is sought.
const ACCURACY: Accuracy = Accuracy { relative: 1e-12, value: 1e-12 };

/// An offset with its standard uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset {
    pub s: f64,
    pub std: f64,
}

/// By their information; None where there is none.
pub fn mean(known: &[Offset]) -> Option<Offset> {
    let usable = || known.iter().filter(|of| of.s.is_finite() && of.std.is_finite() && of.std > 0.0);
    let weight: f64 = usable().map(|of| of.std.powi(-2)).sum();
    let sum: f64 = usable().map(|of| of.s * of.std.powi(-2)).sum();
    (weight > 0.0).then(|| Offset { s: sum / weight, std: weight.sqrt().recip() })
}

/// How offsets scatter: Q(τ²) = Σ (δ − δ̄)²/(σ² + τ²), δ̄ their mean with the same weights, is χ² at τ = 0
/// with one degree of freedom less than there are if all are the same; the variance between them is the τ² at
/// which Q is that number of degrees.
///
/// Sources: R. T. Birge, Phys. Rev. 40 (1932) 207–227; R. C. Paule and J. Mandel, J. Res. NBS 87 (1982)
/// 377–385.
pub fn scatter(offsets: &[Offset]) -> Option<OffsetScatter> {
    let all = mean(offsets).filter(|_| offsets.len() > 1)?;
    let freedom = offsets.len() as f64 - 1.0;
    let q = |between: f64| -> f64 {
        let wider: Vec<Offset> =
            offsets.iter().map(|of| Offset { s: of.s, std: of.std.hypot(between) }).collect();
        let middle = mean(&wider).map_or(f64::NAN, |of| of.s);
        wider.iter().map(|of| ((of.s - middle) / of.std).powi(2)).sum()
    };
    // Beyond the range of all offsets Q is below one each.
    let (low, high) = offsets.iter().fold((all.s, all.s), |(low, high), of| (low.min(of.s), high.max(of.s)));
    let (alike, range) = (q(0.0), high - low);
    let between_s = if alike > freedom {
        let beyond = |between: f64| Ok::<_, Infallible>(freedom - q(between));
        let Ok(zero) =
            line_search::zero((0.0, freedom - alike), (range, freedom - q(range)), ACCURACY, beyond);
        zero
    } else {
        0.0
    };
    Some(OffsetScatter {
        count: offsets.len(),
        std_if_same_s: all.std,
        birge_ratio: (alike / freedom).sqrt(),
        p: stats::chi_squared_p(alike, freedom),
        between_s,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TOLD_BELOW;
    use noise::Stream;

    #[test]
    fn a_scatter_is_told_from_uncertainties() {
        let (mut alike, mut apart) = (0, 0.0);
        for seed in 0..400 {
            let mut stream = Stream::new(seed, "offsets");
            let mut of = |between: f64| -> Vec<Offset> {
                let stds = (0..16).map(|k| 0.01 * f64::from(1 + k % 3));
                stds.map(|std| Offset { s: 0.1 + std * stream.normal() + between * stream.normal(), std })
                    .collect()
            };
            alike += usize::from(scatter(&of(0.0)).expect("offsets").p < TOLD_BELOW);
            apart += scatter(&of(0.05)).expect("offsets").between_s / 400.0;
        }
        assert!(alike <= 12, "{alike} of 400 at 1 %");
        assert!((apart - 0.05).abs() < 0.004, "{apart}");
    }
}
