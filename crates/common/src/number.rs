//! Numbers as people read them, in words, tables and messages alike: a value and its uncertainty end at the
//! same decimal, the uncertainty has two digits, a minus is `−`, and powers of ten are written, as
//! `5.2·10⁻¹⁵`, only below 0.0001 and from ten million on. What machines read, and what a message quotes of a
//! file, stays as it is.

/// A number without an uncertainty, to six significant digits.
pub fn bare(value: f64) -> String {
    significant(value, 6)
}

/// A number to so many significant digits.
pub fn figures(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return UNDETERMINED.into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let power = exponent(value, digits);
    if (-4..7).contains(&power) {
        return fixed(value, digits as i32 - 1 - power);
    }
    format!("{}{}", fixed(scaled(value, power), digits as i32 - 1), times_ten_to(power))
}

/// The same without zeros at the end.
pub fn significant(value: f64, digits: usize) -> String {
    let text = figures(value, digits);
    let (mantissa, power) = text.split_at(text.find('·').unwrap_or(text.len()));
    if !mantissa.contains('.') {
        return text;
    }
    format!("{}{power}", mantissa.trim_end_matches('0').trim_end_matches('.'))
}

/// A value with its standard uncertainty: that to two figures, the value to the same decimal.
pub fn uncertain(value: f64, std: f64) -> String {
    if !value.is_finite() {
        return UNDETERMINED.into();
    }
    if !std.is_finite() {
        return format!("{}, uncertainty {UNDETERMINED}", bare(value));
    }
    if std <= 0.0 {
        return format!("{} ± 0", bare(value));
    }
    let power = exponent(value.abs().max(std), 2);
    let decimals = decimals(std);
    if (-4..7).contains(&power) {
        return format!("{} ± {}", fixed(value, decimals), fixed(std, decimals));
    }
    let [value, std] = [value, std].map(|number| fixed(scaled(number, power), decimals + power));
    format!("({value} ± {std}){}", times_ten_to(power))
}

/// Such a number with its sign also where it is above zero, as offsets and changes have it: `+0.31 ± 0.03`.
pub fn signed(text: &str) -> String {
    let (open, number) = text.split_at(usize::from(text.starts_with('(')));
    let value = number.split(' ').next().unwrap_or_default();
    let above_zero =
        number.starts_with(|c: char| c.is_ascii_digit()) && value.contains(|c| ('1'..='9').contains(&c));
    format!("{open}{}{number}", if above_zero { "+" } else { "" })
}

/// The components of a vector, signed, to the decimal of the uncertainty that they share: `(+0.99975,
/// −0.01000, +0.02001)`.
pub fn vector(components: [f64; 3], std: f64) -> String {
    format!("({})", components.map(|one| signed(&as_known(one, std))).join(", "))
}

/// A value alone, to the decimal of its uncertainty, where that is written elsewhere or in another unit.
pub fn as_known(value: f64, std: f64) -> String {
    if std.is_finite() && std > 0.0 { fixed(value, decimals(std)) } else { bare(value) }
}

/// A probability to two figures; tests that say less than 10⁻³⁰⁰ cannot tell how much less.
pub fn probability(p: f64) -> String {
    if p < LEAST_PROBABILITY { "below 10⁻³⁰⁰".into() } else { significant(p, 2) }
}

/// The same as the outcome of a test: `p = 0.024`, `p < 10⁻³⁰⁰`.
pub fn p_value(p: f64) -> String {
    if p < LEAST_PROBABILITY { "p < 10⁻³⁰⁰".into() } else { format!("p = {}", probability(p)) }
}

/// A time in the unit that suits it: `90 s`, `59 min`, `5.25 h`, `365 days`.
pub fn duration(seconds: f64) -> String {
    let (unit, name) = match seconds.abs() {
        s if s < 120.0 => (1.0, "s"),
        s if s < 7_200.0 => (60.0, "min"),
        s if s < 172_800.0 => (3_600.0, "h"),
        _ => (86_400.0, "days"),
    };
    format!("{} {name}", significant(seconds / unit, 4))
}

const LEAST_PROBABILITY: f64 = 1e-300;
/// In place of a number that is not finite.
const UNDETERMINED: &str = "undetermined";

/// `1 reading`, `2 readings`.
pub fn counted(count: usize, of: &str) -> String {
    format!("{count} {of}{}", if count == 1 { "" } else { "s" })
}

/// The first form for one, the second for any other number: where `s` is not the plural, and for the verb.
pub fn plural<'a>(count: usize, one: &'a str, more: &'a str) -> &'a str {
    if count == 1 { one } else { more }
}

/// A number to so many decimals; below zero they count tens, hundreds, ….
pub fn fixed(value: f64, decimals: i32) -> String {
    if !value.is_finite() {
        return UNDETERMINED.into();
    }
    let text = if decimals >= 0 {
        format!("{value:.*}", decimals as usize)
    } else {
        let step = 10f64.powi(-decimals);
        format!("{:.0}", (value / step).round() * step)
    };
    match text.strip_prefix('-') {
        Some(zero) if zero.chars().all(|c| c == '0' || c == '.') => zero.into(),
        Some(size) => format!("−{size}"),
        None => text,
    }
}

/// The decimals to which an uncertainty has two digits; below zero they count tens, hundreds, ….
fn decimals(std: f64) -> i32 {
    1 - exponent(std, 2)
}

/// A number as a file has it, for messages that quote it: `-1e31`.
pub fn quoted(value: f64) -> String {
    let text = format!("{value:?}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_string)
}

/// A number over a power of ten, in two steps: below 10⁻³⁰⁸ the power itself is none.
fn scaled(value: f64, power: i32) -> f64 {
    let half = power / 2;
    value / 10f64.powi(half) / 10f64.powi(power - half)
}

/// The power of ten of a number that is rounded to so many significant digits.
fn exponent(value: f64, digits: usize) -> i32 {
    let text = format!("{:.*e}", digits - 1, value);
    text.split_once('e').and_then(|(_, power)| power.parse().ok()).unwrap_or(0)
}

/// `·10⁻⁵`.
pub fn times_ten_to(power: i32) -> String {
    format!("·10{}", superscript(power))
}

/// A whole number in raised digits.
pub fn superscript(number: i32) -> String {
    let raised = |c: char| match c.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    };
    number.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uncertainties_have_two_figures_and_values_their_decimals() {
        assert_eq!(uncertain(6401.196031, 0.014612), "6401.196 ± 0.015");
        assert_eq!(uncertain(41234.46234, 0.09789), "41234.462 ± 0.098");
        assert_eq!(uncertain(-0.0004, 0.0996), "0.00 ± 0.10");
        assert_eq!(uncertain(-123456.0, 1234.0), "−123500 ± 1200");
        assert_eq!(uncertain(1.02146e-4, 4.76e-6), "0.0001021 ± 0.0000048");
        assert_eq!(uncertain(-1.84655e-7, 1.1328e-7), "(−1.8 ± 1.1)·10⁻⁷");
        assert_eq!(uncertain(3e-9, 2.5e-3), "0.0000 ± 0.0025");
        assert_eq!(uncertain(4.5e8, 1.2e6), "(4.500 ± 0.012)·10⁸");
    }

    #[test]
    fn signs_are_written_where_they_matter() {
        let with_sign = |value, std| signed(&uncertain(value, std));
        assert_eq!(with_sign(0.30851, 0.00432), "+0.3085 ± 0.0043");
        assert_eq!(with_sign(-0.30851, 0.00432), "−0.3085 ± 0.0043");
        assert_eq!(with_sign(0.0004, 0.0996), "0.00 ± 0.10");
        assert_eq!(with_sign(1.84655e-7, 1.1328e-7), "(+1.8 ± 1.1)·10⁻⁷");
        assert_eq!(with_sign(-1.84655e-7, 1.1328e-7), "(−1.8 ± 1.1)·10⁻⁷");
        assert_eq!(with_sign(f64::NAN, 1.0), "undetermined");
        assert_eq!((signed(&bare(2.5)), signed(&bare(0.0))), ("+2.5".into(), "0".into()));
    }

    #[test]
    fn the_components_of_a_vector_share_their_decimals() {
        let arcsec = 1f64.to_radians() / 3600.0;
        let direction = [0.99974982, -0.01000172, 0.0];
        assert_eq!(vector(direction, 1.3 * arcsec), "(+0.9997498, −0.0100017, 0.0000000)");
        assert_eq!(vector(direction, 20.0 * arcsec), "(+0.999750, −0.010002, 0.000000)");
        assert_eq!(as_known(89.9912345, 0.43 * arcsec.to_degrees()), "89.99123");
        assert_eq!(vector([1.0, 0.0, -0.5], 0.0), "(+1, 0, −0.5)");
        assert_eq!(vector([12345.0, 0.0, f64::NAN], 1234.0), "(+12300, 0, undetermined)");
    }

    #[test]
    fn times_plurals_and_probabilities() {
        let all = [0.0, 0.02, 119.9, 3540.0, 18_900.0, 31_536_000.0, -90.0].map(duration);
        assert_eq!(all, ["0 s", "0.02 s", "119.9 s", "59 min", "5.25 h", "365 days", "−90 s"]);
        assert_eq!([0, 1, 2].map(|count| counted(count, "row")), ["0 rows", "1 row", "2 rows"]);
        assert_eq!([0, 1, 2].map(|count| plural(count, "agrees", "agree")), ["agree", "agrees", "agree"]);
        assert_eq!([0.02449, 2.94e-106, 0.0].map(probability), ["0.024", "2.9·10⁻¹⁰⁶", "below 10⁻³⁰⁰"]);
        assert_eq!([0.02449, 1.0, 1e-301].map(p_value), ["p = 0.024", "p = 1", "p < 10⁻³⁰⁰"]);
    }

    #[test]
    fn bare_numbers_and_what_is_missing() {
        let all = [0.0, -50000.0, 0.123456789, 9.9999999e-5, 2.5e-9, 12345678.0, 5e-310, f64::NEG_INFINITY];
        let expected =
            ["0", "−50000", "0.123457", "0.0001", "2.5·10⁻⁹", "1.23457·10⁷", "5·10⁻³¹⁰", "undetermined"];
        assert_eq!(all.map(bare), expected);
        assert_eq!([0.2, 0.0, 3.04e-9, 1234.5].map(|one| figures(one, 2)), ["0.20", "0", "3.0·10⁻⁹", "1200"]);
        assert_eq!(uncertain(3e-310, 2e-310), "(3.0 ± 2.0)·10⁻³¹⁰");
        assert_eq!(uncertain(f64::NAN, 1.0), "undetermined");
        assert_eq!(uncertain(2.5, f64::INFINITY), "2.5, uncertainty undetermined");
        assert_eq!(uncertain(2.5, 0.0), "2.5 ± 0");
        assert_eq!([-1e31, -300.5, 7e8].map(quoted), ["-1e31", "-300.5", "700000000"]);
    }
}
