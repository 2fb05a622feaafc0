//! Units that files are written in.

/// Ratio and offset: `value × factor + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conversion {
    /// Multiplies the file's value.
    pub factor: f64,
    /// Is added after that, in the document's unit.
    pub offset: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum QuantityKind {
    Field,
    Temperature,
    Voltage,
    Current,
    Angle,
    Length,
    Pressure,
    Frequency,
    Time,
    Resistance,
    Power,
    Percent,
    Counts,
    Moment,
}

/// A unit: what it measures, how many of its kind's first unit it is, and where its zero lies in that.
type Unit = (QuantityKind, f64, f64);

/// Arcseconds of a radian.
const RADIAN_ARCSEC: f64 = 206_264.806_247_096_36;

/// Units of files as people write them. Letters count: mT is not MT, and G (gauss) not g.
const UNITS: [(&str, Unit); 66] = [
    ("nT", (QuantityKind::Field, 1.0, 0.0)),
    ("T", (QuantityKind::Field, 1e9, 0.0)),
    ("mT", (QuantityKind::Field, 1e6, 0.0)),
    ("uT", (QuantityKind::Field, 1e3, 0.0)),
    ("pT", (QuantityKind::Field, 1e-3, 0.0)),
    ("G", (QuantityKind::Field, 1e5, 0.0)),
    ("mG", (QuantityKind::Field, 1e2, 0.0)),
    ("Gauss", (QuantityKind::Field, 1e5, 0.0)),
    ("gauss", (QuantityKind::Field, 1e5, 0.0)),
    ("gamma", (QuantityKind::Field, 1.0, 0.0)),
    ("nt", (QuantityKind::Field, 1.0, 0.0)),
    ("ut", (QuantityKind::Field, 1e3, 0.0)),
    ("C", (QuantityKind::Temperature, 1.0, 0.0)),
    ("°C", (QuantityKind::Temperature, 1.0, 0.0)),
    ("degC", (QuantityKind::Temperature, 1.0, 0.0)),
    ("deg_C", (QuantityKind::Temperature, 1.0, 0.0)),
    ("celsius", (QuantityKind::Temperature, 1.0, 0.0)),
    ("c", (QuantityKind::Temperature, 1.0, 0.0)),
    ("K", (QuantityKind::Temperature, 1.0, -273.15)),
    ("k", (QuantityKind::Temperature, 1.0, -273.15)),
    ("F", (QuantityKind::Temperature, 5.0 / 9.0, -160.0 / 9.0)),
    ("°F", (QuantityKind::Temperature, 5.0 / 9.0, -160.0 / 9.0)),
    ("V", (QuantityKind::Voltage, 1.0, 0.0)),
    ("v", (QuantityKind::Voltage, 1.0, 0.0)),
    ("mV", (QuantityKind::Voltage, 1e-3, 0.0)),
    ("uV", (QuantityKind::Voltage, 1e-6, 0.0)),
    ("A", (QuantityKind::Current, 1.0, 0.0)),
    ("a", (QuantityKind::Current, 1.0, 0.0)),
    ("mA", (QuantityKind::Current, 1e-3, 0.0)),
    ("uA", (QuantityKind::Current, 1e-6, 0.0)),
    ("arcsec", (QuantityKind::Angle, 1.0, 0.0)),
    ("\"", (QuantityKind::Angle, 1.0, 0.0)),
    ("arcmin", (QuantityKind::Angle, 60.0, 0.0)),
    ("'", (QuantityKind::Angle, 60.0, 0.0)),
    ("deg", (QuantityKind::Angle, 3600.0, 0.0)),
    ("°", (QuantityKind::Angle, 3600.0, 0.0)),
    ("rad", (QuantityKind::Angle, RADIAN_ARCSEC, 0.0)),
    ("mrad", (QuantityKind::Angle, RADIAN_ARCSEC / 1e3, 0.0)),
    ("m", (QuantityKind::Length, 1.0, 0.0)),
    ("cm", (QuantityKind::Length, 0.01, 0.0)),
    ("mm", (QuantityKind::Length, 1e-3, 0.0)),
    ("km", (QuantityKind::Length, 1e3, 0.0)),
    ("Pa", (QuantityKind::Pressure, 1.0, 0.0)),
    ("pa", (QuantityKind::Pressure, 1.0, 0.0)),
    ("hPa", (QuantityKind::Pressure, 100.0, 0.0)),
    ("kPa", (QuantityKind::Pressure, 1e3, 0.0)),
    ("mbar", (QuantityKind::Pressure, 100.0, 0.0)),
    ("bar", (QuantityKind::Pressure, 1e5, 0.0)),
    ("Hz", (QuantityKind::Frequency, 1.0, 0.0)),
    ("hz", (QuantityKind::Frequency, 1.0, 0.0)),
    ("kHz", (QuantityKind::Frequency, 1e3, 0.0)),
    ("s", (QuantityKind::Time, 1.0, 0.0)),
    ("ms", (QuantityKind::Time, 1e-3, 0.0)),
    ("us", (QuantityKind::Time, 1e-6, 0.0)),
    ("min", (QuantityKind::Time, 60.0, 0.0)),
    ("h", (QuantityKind::Time, 3600.0, 0.0)),
    ("ohm", (QuantityKind::Resistance, 1.0, 0.0)),
    ("kohm", (QuantityKind::Resistance, 1e3, 0.0)),
    ("W", (QuantityKind::Power, 1.0, 0.0)),
    ("w", (QuantityKind::Power, 1.0, 0.0)),
    ("mW", (QuantityKind::Power, 1e-3, 0.0)),
    ("percent", (QuantityKind::Percent, 1.0, 0.0)),
    ("%", (QuantityKind::Percent, 1.0, 0.0)),
    ("pct", (QuantityKind::Percent, 1.0, 0.0)),
    ("counts", (QuantityKind::Counts, 1.0, 0.0)),
    ("am2", (QuantityKind::Moment, 1.0, 0.0)),
];

/// What a mapping may say, for messages.
pub const KNOWN: &str = "T, mT, uT (µT), nT, pT, G, mG, counts (with \"scale\"), V, mV, A, mA, C, K, F, deg, arcmin, arcsec, rad, \
                         mrad, m, cm, mm, Pa, hPa, mbar, Hz, s, ms, ohm, W, A m², percent";

/// A unit without blanks, µ, Ω and A m² in one spelling.
fn plain(name: &str) -> String {
    let close: String = name.chars().filter(|letter| !letter.is_whitespace()).collect();
    close.replace(['µ', 'μ'], "u").replace(['Ω', 'Ω'], "ohm").replace('²', "2").replace("Am2", "am2")
}

fn unit(name: &str) -> Option<Unit> {
    let name = plain(name);
    UNITS.iter().find(|(known, _)| *known == name).map(|(_, unit)| *unit)
}

/// Whether a file's unit is known.
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
    Some(match unit(name)?.0 {
        QuantityKind::Field => "nt",
        QuantityKind::Temperature => "c",
        QuantityKind::Voltage => "v",
        QuantityKind::Current => "a",
        QuantityKind::Angle if plain(name).ends_with("rad") => "rad",
        QuantityKind::Angle if matches!(plain(name).as_str(), "arcsec" | "\"") => "arcsec",
        QuantityKind::Angle => "deg",
        QuantityKind::Length => "m",
        QuantityKind::Pressure => "pa",
        QuantityKind::Frequency => "hz",
        QuantityKind::Time => "s",
        QuantityKind::Resistance => "ohm",
        QuantityKind::Power => "w",
        QuantityKind::Percent => "percent",
        QuantityKind::Counts => "counts",
        QuantityKind::Moment => "am2",
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
        for (unit, factor) in [
            ("T", 1e9),
            ("mT", 1e6),
            ("µT", 1e3),
            ("μT", 1e3),
            ("uT", 1e3),
            ("nT", 1.0),
            ("G", 1e5),
            ("mG", 1e2),
        ] {
            assert_eq!(conversion(unit, "nT"), Some(Conversion { factor, offset: 0.0 }), "{unit}");
        }
        let kelvin = conversion("K", "C").expect("temperatures");
        assert!((300.0 * kelvin.factor + kelvin.offset - 26.85).abs() < 1e-12);
        let celsius = conversion("C", "K").expect("temperatures");
        assert!((26.85 * celsius.factor + celsius.offset - 300.0).abs() < 1e-12);
        let fahrenheit = conversion("F", "C").expect("temperatures");
        assert!((212.0 * fahrenheit.factor + fahrenheit.offset - 100.0).abs() < 1e-12);
        assert_eq!(conversion("arcmin", "deg").expect("angles").factor, 1.0 / 60.0);
        for unit in ["am2", "Am2", "A m²"] {
            assert_eq!(conversion(unit, "A m²").map(|found| found.factor), Some(1.0), "{unit}");
        }
        assert_eq!(conversion("V", "nT"), None);
        assert!(!is_known("furlong") && !is_known("g"));
    }
}
