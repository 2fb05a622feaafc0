//! Words that several sections share, and text within markup.

pub use crate::page::number::counted;

/// Text for element content and attributes of markup; what XML cannot hold becomes U+FFFD.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(c),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

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
    fn markup_and_control_characters_are_escaped() {
        assert_eq!(escape("<b a='1'>&\"\u{1}\u{7f}"), "&lt;b a=&#39;1&#39;&gt;&amp;&quot;\u{fffd}\u{fffd}");
    }

    #[test]
    fn units_of_keys() {
        for (name, words, unit) in [
            ("curvature_nt_per_a2", "curvature", "nT/A²"),
            ("coefficient_nt_per_k", "coefficient", "nT/K"),
            ("flicker_nt2_per_hz_at_1hz", "flicker", "nT²/Hz at 1 Hz"),
            ("random_walk_nt_per_sqrt_s", "random walk", "nT/√s"),
            ("gradient_nt_per_m_a", "gradient", "nT/m A"),
            ("sensors.x.offset_nt", "sensors.x.offset", "nT"),
            ("wheel_1_hz", "wheel 1", "Hz"),
            ("torquer_x_am2", "torquer x", "A m²"),
            ("gain", "gain", ""),
            ("a", "a", ""),
        ] {
            assert_eq!(key(name), (words.into(), unit.into()));
        }
    }

    #[test]
    fn slugs() {
        assert_eq!(slug("Sensor X <i>\"run-1\"</i>"), "sensor-x-i-run-1-i");
        assert_eq!(slug("…"), "");
    }
}
