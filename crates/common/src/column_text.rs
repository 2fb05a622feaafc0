//! The JSON text of a column: its summary, for which no number is parsed, and its parsing.

/// A number with more digits before the decimal point is not summarised.
const MOST_DIGITS: usize = 15;

/// Rows and range of a list of numbers and nulls.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Number of rows.
    pub rows: usize,
    /// A bound of all absolute values: a power of ten.
    pub bound: f64,
}

/// Summarises valid JSON. None where it is not a plain list of nulls and of numbers without positive
/// exponents, with at most one space after each comma.
pub fn summary(text: &str) -> Option<Summary> {
    let inner = text.strip_prefix('[')?.strip_suffix(']')?;
    if inner.is_empty() {
        return Some(Summary::default());
    }
    let (mut rows, mut most) = (0, 0);
    let mut rest = inner.as_bytes();
    loop {
        rows += 1;
        rest = rest.strip_prefix(b" ").filter(|_| rows > 1).unwrap_or(rest);
        let number = rest.strip_prefix(b"-").unwrap_or(rest);
        let digits = number.iter().take_while(|byte| byte.is_ascii_digit()).count();
        rest = match digits {
            0 => number.strip_prefix(b"null").filter(|_| number.len() == rest.len())?,
            1..=MOST_DIGITS => fraction(&number[digits..])?,
            _ => return None,
        };
        most = most.max(digits);
        rest = match rest {
            [] => return Some(Summary { rows, bound: 10_f64.powi(most as i32) }),
            [b',', others @ ..] => others,
            _ => return None,
        };
    }
}

/// The text after the fraction and the negative exponent of a number.
fn fraction(text: &[u8]) -> Option<&[u8]> {
    let digits = |text: &[u8]| text.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let text = text.strip_prefix(b".").map_or(text, |rest| &rest[digits(rest)..]);
    match text {
        [b'e' | b'E', b'-', rest @ ..] => Some(&rest[digits(rest)..]),
        [b'e' | b'E', ..] => None,
        _ => Some(text),
    }
}

/// Parses a text that has a [`summary`]; null is NaN.
pub fn values(text: &str, rows: usize) -> Vec<f64> {
    let mut values = Vec::with_capacity(rows);
    if rows > 0 {
        let inner = &text[1..text.len() - 1];
        values.extend(inner.split(',').map(|number| number.trim_start().parse().unwrap_or(f64::NAN)));
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_lists_are_summarised_and_parsed() {
        let text = "[1, -22.5,null,3.25e-7, 4E-2,0]";
        assert_eq!(summary(text), Some(Summary { rows: 6, bound: 100.0 }));
        let read = values(text, 6);
        assert!(read[2].is_nan());
        assert_eq!([read[0], read[1], read[3], read[4], read[5]], [1.0, -22.5, 3.25e-7, 0.04, 0.0]);
        assert_eq!(summary("[]"), Some(Summary::default()));
        assert!(values("[]", 0).is_empty());
    }

    #[test]
    fn others_are_not() {
        let long = format!("[{}]", "1".repeat(MOST_DIGITS + 1));
        for text in
            ["{}", "5", "[ 1]", "[1 ]", "[1,\n2]", "[1e5]", "[true]", "[\"1\"]", "[[1]]", "[1,[2]]", &long]
        {
            assert_eq!(summary(text), None, "{text}");
        }
    }
}
