//! Words that several sections share.

use common::{Axis, PerAxis, Quantity};

use crate::Cell;
pub use crate::number::counted;

/// Words of a stage as a sentence.
pub fn sentence(words: &str) -> String {
    let mut letters = words.trim().chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    let end = if words.ends_with(['.', '!', '?']) { "" } else { "." };
    format!("{first}{}{end}", letters.as_str())
}

/// A number to three significant digits: the end of a band, the width of a code.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// For links: lower case letters, digits and single hyphens.
pub fn slug(text: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    let text: String = text.chars().map(plain).collect();
    text.split('-').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-")
}

/// A cell for each axis.
pub fn cells(each: Option<&PerAxis<Quantity>>) -> [Cell; 3] {
    Axis::ALL.map(|axis| each.and_then(|each| each.get(axis)).into())
}

/// A name whose last part is a unit (`offset_nt`, `flicker_nt2_per_hz_at_1hz`) as words and unit. Without a
/// unit the words are all.
pub fn key(name: &str) -> (String, String) {
    let parts: Vec<&str> = name.split('_').collect();
    let first = (1..parts.len())
        .find(|first| parts[*first..].iter().all(|part| in_unit(part)))
        .unwrap_or(parts.len());
    let words = parts[..first].join(" ");
    if parts.get(first).is_none_or(|part| symbol(part).is_none()) {
        return (parts.join(" "), String::new());
    }
    let mut unit = String::new();
    let mut rest = parts[first..].iter();
    while let Some(part) = rest.next() {
        match *part {
            "per" => unit.push('/'),
            "sqrt" => unit.push('√'),
            "at" => {
                let at = rest.next().map(|part| part.replace("hz", " Hz")).unwrap_or_default();
                unit.push_str(&format!(" at {at}"));
            }
            part => {
                if unit.ends_with(char::is_alphabetic) {
                    unit.push(' ');
                }
                unit.push_str(&symbol(part).unwrap_or_default());
            }
        }
    }
    (words, unit)
}

fn in_unit(part: &str) -> bool {
    matches!(part, "per" | "sqrt" | "at" | "1hz") || symbol(part).is_some()
}

fn symbol(part: &str) -> Option<String> {
    let name = part.trim_end_matches(|c: char| c.is_ascii_digit());
    let symbol = match name {
        "ppm" | "day" | "year" => name,
        "am" => "A m",
        _ => common::unit::of_ending(name)?,
    };
    let power = match &part[name.len()..] {
        "" => "",
        "2" => "²",
        "3" => "³",
        "4" => "⁴",
        _ => return None,
    };
    Some(format!("{symbol}{power}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_keys() {
        let key = |name| {
            let (words, unit) = super::key(name);
            format!("{words}|{unit}")
        };
        assert_eq!(key("curvature_nt_per_a2"), "curvature|nT/A²");
        assert_eq!(key("coefficient_nt_per_k"), "coefficient|nT/K");
        assert_eq!(key("flicker_nt2_per_hz_at_1hz"), "flicker|nT²/Hz at 1 Hz");
        assert_eq!(key("random_walk_nt_per_sqrt_s"), "random walk|nT/√s");
        assert_eq!(key("gradient_nt_per_m_a"), "gradient|nT/m A");
        assert_eq!(key("sensors.x.offset_nt"), "sensors.x.offset|nT");
        assert_eq!(key("wheel_1_hz"), "wheel 1|Hz");
        assert_eq!(key("torquer_x_am2"), "torquer x|A m²");
        assert_eq!(key("gain"), "gain|");
        assert_eq!(key("a"), "a|");
    }

    #[test]
    fn slugs() {
        assert_eq!(slug("Sensor X <i>\"run-1\"</i>"), "sensor-x-i-run-1-i");
        assert_eq!(slug("…"), "");
    }
}
