//! Numbers on the command line: each is within its range before a program begins.

/// A number.
pub fn finite(text: &str) -> Result<f64, String> {
    within(text, |_| true, "a number")
}

/// A number above zero.
pub fn positive(text: &str) -> Result<f64, String> {
    within(text, |value| value > 0.0, "a number above zero")
}

/// Zero or a number above it.
pub fn not_negative(text: &str) -> Result<f64, String> {
    within(text, |value| value >= 0.0, "zero or a number above it")
}

fn within(text: &str, is: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite() && is(*value));
    value.ok_or_else(|| format!("found {text}; expected {expected}"))
}

#[cfg(test)]
mod tests {
    use super::{finite, not_negative, positive};

    #[test]
    fn ranges() {
        assert_eq!((finite("-1.5"), positive("1e-3"), not_negative("0")), (Ok(-1.5), Ok(1e-3), Ok(0.0)));
        for wrong in ["nan", "inf", "-inf", "1e400", "", "one"] {
            assert!(
                finite(wrong).is_err() && positive(wrong).is_err() && not_negative(wrong).is_err(),
                "{wrong}"
            );
        }
        assert_eq!(positive("0"), Err("found 0; expected a number above zero".into()));
        assert_eq!(not_negative("-1"), Err("found -1; expected zero or a number above it".into()));
    }
}
