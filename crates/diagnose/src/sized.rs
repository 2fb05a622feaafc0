//! A parameter of an effect with its uncertainty and its interval.

use common::Quantity;
use estimate::stats::coverage_factor;
use physics::{ParameterInfo, Role};

/// Intervals of shapes that go farther than this share of the value are not as far to either side.
const FAR: f64 = 0.05;

/// A parameter with its standard uncertainty, known with so many degrees of freedom. A fit knows a time
/// constant or a level by its logarithm, and so its interval is one of the logarithm.
pub fn quantity(value: f64, std: f64, freedom: f64, info: Option<&ParameterInfo>) -> Quantity {
    if !(std.is_finite() && std > 0.0) {
        return Quantity::Bare(value);
    }
    let factor = coverage_factor(0.95, freedom);
    let quantity = Quantity::new(value, std).covered_by(factor);
    let far = factor * std / value.abs();
    if info.is_some_and(|info| info.role == Role::Shape) && far > FAR {
        let ends = [(-far).exp() * value, far.exp() * value];
        return quantity.within([ends[0].min(ends[1]), ends[0].max(ends[1])]);
    }
    quantity
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::Kind;

    #[test]
    fn a_lag_that_is_known_roughly_is_not_negative() {
        let of = |value: f64, std: f64| {
            quantity(value, std, f64::INFINITY, Some(&Kind::LoopBandwidth.parameters()[0]))
        };
        let [low, high] = of(10.0, 6.0).interval_95().expect("an interval");
        assert!(low > 0.0 && (low * high / 100.0 - 1.0).abs() < 1e-12 && high > 30.0);
        let [low, high] = of(10.0, 0.1).interval_95().expect("an interval");
        assert!((0.5 * (low + high) - 10.0).abs() < 1e-12);
        assert_eq!(of(10.0, 0.0), Quantity::Bare(10.0));
    }
}
