//! Numbers as people read them: a value and its uncertainty end at the same decimal, the uncertainty has two digits, and powers of
//! ten are written only where plain digits would be too many.

/// A number without an uncertainty, to six significant digits.
pub fn bare(value: f64) -> String {
    significant(value, 6)
}

/// A number to so many significant digits.
pub fn figures(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return missing(value).into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let power = exponent(value, digits);
    if (-4..7).contains(&power) {
        return fixed(value, digits as i32 - 1 - power);
    }
    format!("{}{}", fixed(value / 10f64.powi(power), digits as i32 - 1), times_ten_to(power))
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
        return missing(value).into();
    }
    if !std.is_finite() {
        return format!("{}, uncertainty {}", bare(value), missing(std));
    }
    if std <= 0.0 {
        return format!("{} ± 0", bare(value));
    }
    let power = exponent(value.abs().max(std), 2);
    let decimals = 1 - exponent(std, 2);
    if (-4..7).contains(&power) {
        return format!("{} ± {}", fixed(value, decimals), fixed(std, decimals));
    }
    let scale = 10f64.powi(power);
    let [value, std] = [value, std].map(|number| fixed(number / scale, decimals + power));
    format!("({value} ± {std}){}", times_ten_to(power))
}

/// A probability to two figures.
pub fn probability(p: f64) -> String {
    if p == 0.0 { "below 10⁻³⁰⁰".into() } else { significant(p, 2) }
}

/// `1 reading`, `2 readings`.
pub fn counted(count: usize, of: &str) -> String {
    if count == 1 { format!("1 {of}") } else { format!("{count} {of}s") }
}

/// A number to so many decimals; below zero they count tens, hundreds, ….
pub fn fixed(value: f64, decimals: i32) -> String {
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

fn missing(value: f64) -> &'static str {
    if value.is_nan() { "missing" } else { "not finite" }
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
    fn what_is_missing_is_said() {
        assert_eq!(uncertain(f64::NAN, 1.0), "missing");
        assert_eq!(uncertain(2.5, f64::INFINITY), "2.5, uncertainty not finite");
        assert_eq!(uncertain(2.5, 0.0), "2.5 ± 0");
        assert_eq!(bare(f64::NEG_INFINITY), "not finite");
    }

    #[test]
    fn bare_numbers() {
        assert_eq!(bare(0.0), "0");
        assert_eq!(bare(-50000.0), "−50000");
        assert_eq!(bare(0.123456789), "0.123457");
        assert_eq!(bare(9.9999999e-5), "0.0001");
        assert_eq!((figures(0.2, 2), figures(0.0, 2)), ("0.20".into(), "0".into()));
        assert_eq!((figures(3.04e-9, 2), figures(1234.5, 2)), ("3.0·10⁻⁹".into(), "1200".into()));
        assert_eq!(bare(2.5e-9), "2.5·10⁻⁹");
        assert_eq!(bare(12345678.0), "1.23457·10⁷");
        assert_eq!(probability(0.02449), "0.024");
        assert_eq!(probability(2.94e-106), "2.9·10⁻¹⁰⁶");
    }
}
