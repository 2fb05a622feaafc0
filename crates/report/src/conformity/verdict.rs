use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};

/// What is said of a requirement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// It is met.
    Pass,
    /// The document does not show whether it is met.
    NotShown,
    /// It is not met.
    Fail,
}

impl Verdict {
    /// As people read it.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Pass => "pass",
            Verdict::NotShown => "not shown",
            Verdict::Fail => "fail",
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Below it; the value cannot be negative.
    Below,
    /// Between minus the limit and the limit.
    Within,
    /// Above it.
    Above,
}

/// What the document shows of one sensor, pair or component.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShownValue {
    /// Of what.
    pub of: String,
    /// The value, in the requirement's unit.
    pub value: f64,
    /// Its standard uncertainty: that of the normal distribution with the same 95 % interval.
    pub std: f64,
    /// Why the true value may be larger; empty where the calibration covers all that is asked.
    pub gaps: Vec<String>,
    /// What the value is and how it was found.
    pub how: String,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Missing {
    /// Of what.
    pub of: String,
    /// What is missing, and the procedure that would show it.
    pub why: String,
}

/// A value or what is missing for it.
pub type Shown = Result<ShownValue, Missing>;

/// What was found, or why not, with what it is of.
pub(crate) fn shown(of: impl Into<String>, found: Result<ShownValue, String>) -> Shown {
    let of = of.into();
    match found {
        Ok(found) => Ok(ShownValue { of, ..found }),
        Err(why) => Err(Missing { of, why }),
    }
}

/// The decision rule (JCGM 106:2012, section 8.3; ILAC-G8:09/2019): a guard band of k standard uncertainties
/// on either side of the limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// k where a limit can be missed on one side.
    pub factor: f64,
}

impl Rule {
    /// Probability that a verdict of pass or fail is right, at least: Φ(k).
    pub fn probability(self) -> f64 {
        Normal::standard().cdf(self.factor)
    }

    /// k for a requirement. Where a limit can be missed on either side, Φ⁻¹((1 + Φ(k))/2): the same
    /// probability for both sides together, 1.960 for 1.645.
    pub fn factor(self, side: Side) -> f64 {
        match side {
            // From the tail, which has digits where the probability has none left.
            Side::Within => -Normal::standard().inverse_cdf(0.5 * Normal::standard().sf(self.factor)),
            Side::Below | Side::Above => self.factor,
        }
    }

    /// What is left to the limit when the guard band is taken off: L − |v| − k u, and v − L − k u where the
    /// requirement is met above its limit.
    pub fn margin(self, side: Side, limit: f64, found: &ShownValue) -> f64 {
        room(side, limit, found) - self.factor(side) * found.std
    }

    /// Pass where the margin is not negative: |v| + k u ≤ L. Fail where |v| − k u > L. Else not shown. A
    /// value that may be larger than what was seen passes no limit from below, and fails none from above.
    pub fn verdict(self, side: Side, limit: f64, found: &ShownValue) -> Verdict {
        let guard = self.factor(side) * found.std;
        let room = room(side, limit, found);
        let whole = found.gaps.is_empty();
        match side {
            Side::Above if room >= guard => Verdict::Pass,
            Side::Above if room < -guard && whole => Verdict::Fail,
            Side::Below | Side::Within if room >= guard && whole => Verdict::Pass,
            Side::Below | Side::Within if room < -guard => Verdict::Fail,
            _ => Verdict::NotShown,
        }
    }
}

fn room(side: Side, limit: f64, found: &ShownValue) -> f64 {
    match side {
        Side::Above => found.value - limit,
        Side::Below | Side::Within => limit - found.value.abs(),
    }
}

/// From standard uncertainty to 95 % interval of a normal distribution.
pub const NORMAL: f64 = 1.959_963_984_540_054;

/// A standard uncertainty with its 95 % factor as that of the normal distribution with the same 95 %
/// interval: few degrees of freedom make it wider.
pub fn normal_std(std: f64, coverage_factor_95: f64) -> f64 {
    std * (coverage_factor_95 / NORMAL).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use Side::{Above, Below, Within};
    use Verdict::{Fail, NotShown, Pass};

    fn found(value: f64, std: f64) -> ShownValue {
        ShownValue { value, std, ..ShownValue::default() }
    }

    const RULE: Rule = Rule { factor: 1.645 };

    /// L = 1, u = 0.1: the guard band is 0.1645 on one side, 0.196 on both. Without u a limit is met at the
    /// limit.
    #[test]
    fn guard_bands_by_hand() {
        for (side, values) in [
            (Below, [0.8354, 0.8356, 1.1644, 1.1646]),
            (Within, [-0.8039, 0.8041, -1.1959, 1.1961]),
            (Above, [1.1646, 1.1644, 0.8356, 0.8354]),
        ] {
            let verdicts = values.map(|value| RULE.verdict(side, 1.0, &found(value, 0.1)));
            assert_eq!(verdicts, [Pass, NotShown, NotShown, Fail], "{side:?}");
        }
        for (side, value, verdict) in
            [(Below, 1.0, Pass), (Within, -1.0, Pass), (Above, 1.0, Pass), (Below, f64::NAN, NotShown)]
        {
            assert_eq!(RULE.verdict(side, 1.0, &found(value, 0.0)), verdict, "{side:?}");
        }
        for (side, value) in [(Below, 0.5), (Above, 1.5)] {
            assert!((RULE.margin(side, 1.0, &found(value, 0.1)) - 0.3355).abs() < 1e-12, "{side:?}");
        }
        // What was seen in part decides in one direction.
        for (side, value, verdict) in
            [(Below, 0.1, NotShown), (Below, 2.0, Fail), (Above, 0.1, NotShown), (Above, 2.0, Pass)]
        {
            let part = ShownValue { gaps: vec!["half of it".into()], ..found(value, 0.1) };
            assert_eq!(RULE.verdict(side, 1.0, &part), verdict, "{side:?} {value}");
        }
    }

    #[test]
    fn both_sides_together_have_the_probability_of_one() {
        assert!((RULE.probability() - 0.95).abs() < 2e-5);
        assert!((RULE.factor(Side::Within) - 1.960).abs() < 2e-4);
        assert_eq!(RULE.factor(Side::Above), 1.645);
        // Where Φ(k) is one to all digits, there is still a k for both sides: half the tail of k = 10 is that
        // of 10.068.
        assert!((Rule { factor: 10.0 }.factor(Side::Within) - 10.068).abs() < 1e-3);
        assert!(Rule { factor: 30.0 }.factor(Side::Within) > 30.0);
        assert_eq!(normal_std(2.0, 1.959_963_984_540_054), 2.0);
        // Ten degrees of freedom: t = 2.228139.
        assert!((normal_std(1.0, 2.228_139) - 1.136_827).abs() < 1e-6);
    }
}
