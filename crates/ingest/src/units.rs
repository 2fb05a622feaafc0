//! Units that files are written in.

/// Ratio and offset: `value × factor + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conversion {
    pub factor: f64,
    pub offset: f64,
}

const RADIAN_ARCSEC: f64 = 206_264.806_247_096_36;

/// Units of files: the ending of the document's columns for what they measure, size and zero in that kind's
/// base unit (the one of size one; for angles arcseconds, whose ending `ending_for` tells), and how people
/// write it. Letters count: mT is not MT, and G (gauss) not g.
const UNITS: [(&str, f64, f64, &str); 45] = [
    ("nt", 1.0, 0.0, "nT nt gamma"),
    ("nt", 1e9, 0.0, "T"),
    ("nt", 1e6, 0.0, "mT"),
    ("nt", 1e3, 0.0, "uT ut"),
    ("nt", 1e-3, 0.0, "pT"),
    ("nt", 1e5, 0.0, "G Gauss gauss"),
    ("nt", 1e2, 0.0, "mG"),
    ("c", 1.0, 0.0, "C °C degC deg_C celsius c"),
    ("c", 1.0, -273.15, "K k"),
    ("c", 5.0 / 9.0, -160.0 / 9.0, "F °F"),
    ("v", 1.0, 0.0, "V v"),
    ("v", 1e-3, 0.0, "mV"),
    ("v", 1e-6, 0.0, "uV"),
    ("a", 1.0, 0.0, "A a"),
    ("a", 1e-3, 0.0, "mA"),
    ("a", 1e-6, 0.0, "uA"),
    ("deg", 1.0, 0.0, "arcsec \""),
    ("deg", 60.0, 0.0, "arcmin '"),
    ("deg", 3600.0, 0.0, "deg °"),
    ("deg", 3240.0, 0.0, "gon grad"),
    ("deg", RADIAN_ARCSEC, 0.0, "rad"),
    ("deg", RADIAN_ARCSEC / 1e3, 0.0, "mrad"),
    ("m", 1.0, 0.0, "m"),
    ("m", 0.01, 0.0, "cm"),
    ("m", 1e-3, 0.0, "mm"),
    ("m", 1e3, 0.0, "km"),
    ("pa", 1.0, 0.0, "Pa pa"),
    ("pa", 100.0, 0.0, "hPa mbar"),
    ("pa", 1e3, 0.0, "kPa"),
    ("pa", 1e5, 0.0, "bar"),
    ("hz", 1.0, 0.0, "Hz hz"),
    ("hz", 1e3, 0.0, "kHz"),
    ("s", 1.0, 0.0, "s"),
    ("s", 1e-3, 0.0, "ms"),
    ("s", 1e-6, 0.0, "us"),
    ("s", 60.0, 0.0, "min"),
    ("s", 3600.0, 0.0, "h"),
    ("ohm", 1.0, 0.0, "ohm"),
    ("ohm", 1e3, 0.0, "kohm"),
    ("w", 1.0, 0.0, "W w"),
    ("w", 1e-3, 0.0, "mW"),
    ("percent", 1.0, 0.0, "percent % pct"),
    ("counts", 1.0, 0.0, "counts"),
    ("am2", 1.0, 0.0, "am2"),
    ("rpm", 1.0, 0.0, "rpm RPM r/min"),
];

/// What a mapping may say, for messages.
pub const KNOWN: &str = "T, mT, uT (µT), nT, pT, G, mG, counts (with \"scale\"), V, mV, A, mA, C, K, F, deg, gon, arcmin, arcsec, rad, \
                         mrad, m, cm, mm, Pa, hPa, mbar, Hz, s, ms, ohm, W, A m², rpm, percent";

/// A unit without blanks, µ, Ω and A m² in one spelling.
fn plain(name: &str) -> String {
    let close: String = name.chars().filter(|letter| !letter.is_whitespace()).collect();
    close.replace(['µ', 'μ'], "u").replace(['Ω', 'Ω'], "ohm").replace('²', "2").replace("Am2", "am2")
}

/// What it measures, its size and its zero.
fn unit(name: &str) -> Option<(&'static str, f64, f64)> {
    let name = plain(name);
    let found = UNITS.iter().find(|(.., spellings)| spellings.split(' ').any(|known| known == name));
    found.map(|(kind, size, zero, _)| (*kind, *size, *zero))
}

pub fn is_known(name: &str) -> bool {
    unit(name).is_some()
}

/// Whether a name says what a unit of one letter at its end measures: `load_current` of amperes.
pub fn is_measured(name: &str, unit: &str) -> bool {
    let words: &[&str] = match unit {
        "a" => &["current", "amp"],
        "v" => &["voltage", "volt", "battery"],
        "c" | "k" => &["temp", "temperature"],
        "w" => &["power", "watt"],
        "s" => &["time", "seconds", "uptime"],
        "m" => &["position", "height", "distance"],
        _ => &[],
    };
    let name = name.to_lowercase();
    name.split(|letter: char| !letter.is_alphanumeric()).any(|part| words.contains(&part))
}

/// The ending of column names in the document for values in `name`, of the same kind: `nt` for `G`, `c` for
/// `F`.
pub fn ending_for(name: &str) -> Option<&'static str> {
    Some(match (unit(name)?.0, plain(name).as_str()) {
        ("deg", name) if name.ends_with("rad") => "rad",
        ("deg", "arcsec" | "\"") => "arcsec",
        (ending, _) => ending,
    })
}

/// From a file's unit to that of a column; None where they do not measure the same.
pub fn conversion(from: &str, to: &str) -> Option<Conversion> {
    let ((kind, size, zero), (to_kind, to_size, to_zero)) = (unit(from)?, unit(to)?);
    (kind == to_kind).then(|| Conversion { factor: size / to_size, offset: (zero - to_zero) / to_size })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_exact_and_temperatures_have_a_zero() {
        for (units, factor) in
            [("T", 1e9), ("mT", 1e6), ("µT μT uT", 1e3), ("nT", 1.0), ("G", 1e5), ("mG", 1e2)]
        {
            for unit in units.split(' ') {
                assert_eq!(conversion(unit, "nT"), Some(Conversion { factor, offset: 0.0 }), "{unit}");
            }
        }
        for (from, to, value, due) in
            [("K", "C", 300.0, 26.85), ("C", "K", 26.85, 300.0), ("F", "C", 212.0, 100.0)]
        {
            let Conversion { factor, offset } = conversion(from, to).expect("temperatures");
            assert!((value * factor + offset - due).abs() < 1e-12, "{from}");
        }
        assert_eq!(conversion("arcmin", "deg").expect("angles").factor, 1.0 / 60.0);
        for unit in ["am2", "Am2", "A m²"] {
            assert_eq!(conversion(unit, "A m²").map(|found| found.factor), Some(1.0), "{unit}");
        }
        assert_eq!(conversion("V", "nT"), None);
        assert!(!is_known("furlong") && !is_known("g"));
    }
}
