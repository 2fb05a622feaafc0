//! Numbers as files write most of them: digits, a decimal mark, digits.

/// Powers of ten; double precision holds them exactly.
const POWERS: [f64; 16] =
    [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];

/// The number that the text begins with, and its length: digits, perhaps a mark and digits, perhaps a minus,
/// 15 digits at most. Both the digits as a whole number and the power of ten are then exact, and their
/// quotient is the nearest double (Clinger 1990). None for whatever else; that is for `fast_float2`.
#[inline]
pub fn plain(text: &[u8], point: u8) -> Option<(f64, usize)> {
    let negative = text.first() == Some(&b'-');
    let begin = usize::from(negative);
    let (whole, at) = digits(text, begin, 0);
    let (all, end) = match text.get(at) {
        Some(mark) if *mark == point => digits(text, at + 1, whole),
        _ => (whole, at),
    };
    let decimals = if end > at { end - at - 1 } else { 0 };
    if at == begin || at - begin + decimals > 15 {
        return None;
    }
    let value = all as f64 / POWERS[decimals];
    Some((if negative { -value } else { value }, end))
}

#[inline]
fn digits(text: &[u8], mut at: usize, mut sum: u64) -> (u64, usize) {
    while let Some(byte) = text.get(at) {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        sum = sum.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    (sum, at)
}

/// A whole field as a number, in any notation; NaN and infinities too, where they are written so.
#[inline]
pub fn parse(field: &[u8], point: u8) -> Option<f64> {
    match plain(field, point) {
        Some((value, end)) if end == field.len() => Some(value),
        _ if point == b',' => with_comma(field),
        _ => fast_float2::parse::<f64, _>(field).ok(),
    }
}

/// A number whose digits before the decimal mark stand in groups of three.
pub fn grouped(field: &[u8], point: u8, mark: u8) -> Option<f64> {
    let end = field.iter().position(|byte| *byte == point).unwrap_or(field.len());
    let (whole, rest) = field.split_at(end);
    let digits = whole.strip_prefix(b"-").or(whole.strip_prefix(b"+")).unwrap_or(whole);
    let mut groups = digits.split(|byte| *byte == mark);
    let first = groups.next().is_some_and(|group| (1..=3).contains(&group.len()));
    let fits = first
        && groups.all(|group| group.len() == 3)
        && digits.iter().all(|byte| *byte == mark || byte.is_ascii_digit());
    let plain: Vec<u8> = whole.iter().filter(|byte| **byte != mark).chain(rest).copied().collect();
    fits.then(|| parse(&plain, point))?
}

fn with_comma(field: &[u8]) -> Option<f64> {
    if field.contains(&b'.') {
        return None;
    }
    let text: Vec<u8> = field.iter().map(|byte| if *byte == b',' { b'.' } else { *byte }).collect();
    fast_float2::parse::<f64, _>(&text).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_is_plain_and_what_is_not() {
        assert_eq!(plain(b"48520,3;", b','), Some((48520.3, 7)));
        for (text, value, end) in [("-31.96 ", -31.96, 6), ("12", 12.0, 2), ("12.", 12.0, 3)] {
            assert_eq!(plain(text.as_bytes(), b'.'), Some((value, end)));
        }
        for other in ["", "-", ".5", "+1", "x", "1234567890.1234567"] {
            assert_eq!(plain(other.as_bytes(), b'.'), None, "{other}");
        }
        assert_eq!(parse(b"-1,5e3", b','), Some(-1500.0));
        assert_eq!(parse(b"48.520,3", b','), None);
        assert_eq!(parse(b"1.5x", b'.'), None);
        assert_eq!(parse(b"-0", b'.').map(f64::to_bits), Some((-0.0_f64).to_bits()));
    }

    #[test]
    fn groups_of_three() {
        assert_eq!(grouped(b"48,520.31", b'.', b','), Some(48_520.31));
        assert_eq!(grouped(b"-1.048.520,5", b',', b'.'), Some(-1_048_520.5));
        assert_eq!(grouped(b"48 520", b'.', b' '), Some(48_520.0));
        assert_eq!(grouped(b"520.31", b'.', b','), Some(520.31));
        for other in ["48,52.3", "4852,031", ",520", "48,520,", "48,5x0", "48.520,5"] {
            assert_eq!(grouped(other.as_bytes(), b'.', b','), None, "{other}");
        }
    }

    proptest! {
        #[test]
        fn the_nearest_double(text in "-?[0-9]{1,9}(\\.[0-9]{0,9})?(e-?[0-9]{1,2})?") {
            prop_assert_eq!(parse(text.as_bytes(), b'.').map(f64::to_bits), text.parse::<f64>().ok().map(f64::to_bits));
        }
    }
}
