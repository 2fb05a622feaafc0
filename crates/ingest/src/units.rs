//! Units that files are written in, and those that the document's column names end in.

/// Ratio and offset: `value × factor + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conversion {
    /// Multiplies the file's value.
    pub factor: f64,
    /// Is added after that, in the document's unit.
    pub offset: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
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
}

/// A unit: what it measures, how many of its kind's first unit it is, and where its zero lies in that.
type Unit = (Kind, f64, f64);

/// Arcseconds of a radian.
const RADIAN_ARCSEC: f64 = 206_264.806_247_096_36;

/// Units of files as people write them. Letters count: mT is not MT, and G (gauss) not g.
const UNITS: [(&str, Unit); 65] = [
    ("nT", (Kind::Field, 1.0, 0.0)),
    ("T", (Kind::Field, 1e9, 0.0)),
    ("mT", (Kind::Field, 1e6, 0.0)),
    ("uT", (Kind::Field, 1e3, 0.0)),
    ("pT", (Kind::Field, 1e-3, 0.0)),
    ("G", (Kind::Field, 1e5, 0.0)),
    ("mG", (Kind::Field, 1e2, 0.0)),
    ("Gauss", (Kind::Field, 1e5, 0.0)),
    ("gauss", (Kind::Field, 1e5, 0.0)),
    ("gamma", (Kind::Field, 1.0, 0.0)),
    ("nt", (Kind::Field, 1.0, 0.0)),
    ("ut", (Kind::Field, 1e3, 0.0)),
    ("C", (Kind::Temperature, 1.0, 0.0)),
    ("°C", (Kind::Temperature, 1.0, 0.0)),
    ("degC", (Kind::Temperature, 1.0, 0.0)),
    ("deg_C", (Kind::Temperature, 1.0, 0.0)),
    ("celsius", (Kind::Temperature, 1.0, 0.0)),
    ("c", (Kind::Temperature, 1.0, 0.0)),
    ("K", (Kind::Temperature, 1.0, -273.15)),
    ("k", (Kind::Temperature, 1.0, -273.15)),
    ("F", (Kind::Temperature, 5.0 / 9.0, -160.0 / 9.0)),
    ("°F", (Kind::Temperature, 5.0 / 9.0, -160.0 / 9.0)),
    ("V", (Kind::Voltage, 1.0, 0.0)),
    ("v", (Kind::Voltage, 1.0, 0.0)),
    ("mV", (Kind::Voltage, 1e-3, 0.0)),
    ("uV", (Kind::Voltage, 1e-6, 0.0)),
    ("A", (Kind::Current, 1.0, 0.0)),
    ("a", (Kind::Current, 1.0, 0.0)),
    ("mA", (Kind::Current, 1e-3, 0.0)),
    ("uA", (Kind::Current, 1e-6, 0.0)),
    ("arcsec", (Kind::Angle, 1.0, 0.0)),
    ("\"", (Kind::Angle, 1.0, 0.0)),
    ("arcmin", (Kind::Angle, 60.0, 0.0)),
    ("'", (Kind::Angle, 60.0, 0.0)),
    ("deg", (Kind::Angle, 3600.0, 0.0)),
    ("°", (Kind::Angle, 3600.0, 0.0)),
    ("rad", (Kind::Angle, RADIAN_ARCSEC, 0.0)),
    ("mrad", (Kind::Angle, RADIAN_ARCSEC / 1e3, 0.0)),
    ("m", (Kind::Length, 1.0, 0.0)),
    ("cm", (Kind::Length, 0.01, 0.0)),
    ("mm", (Kind::Length, 1e-3, 0.0)),
    ("km", (Kind::Length, 1e3, 0.0)),
    ("Pa", (Kind::Pressure, 1.0, 0.0)),
    ("pa", (Kind::Pressure, 1.0, 0.0)),
    ("hPa", (Kind::Pressure, 100.0, 0.0)),
    ("kPa", (Kind::Pressure, 1e3, 0.0)),
    ("mbar", (Kind::Pressure, 100.0, 0.0)),
    ("bar", (Kind::Pressure, 1e5, 0.0)),
    ("Hz", (Kind::Frequency, 1.0, 0.0)),
    ("hz", (Kind::Frequency, 1.0, 0.0)),
    ("kHz", (Kind::Frequency, 1e3, 0.0)),
    ("s", (Kind::Time, 1.0, 0.0)),
    ("ms", (Kind::Time, 1e-3, 0.0)),
    ("us", (Kind::Time, 1e-6, 0.0)),
    ("min", (Kind::Time, 60.0, 0.0)),
    ("h", (Kind::Time, 3600.0, 0.0)),
    ("ohm", (Kind::Resistance, 1.0, 0.0)),
    ("kohm", (Kind::Resistance, 1e3, 0.0)),
    ("W", (Kind::Power, 1.0, 0.0)),
    ("w", (Kind::Power, 1.0, 0.0)),
    ("mW", (Kind::Power, 1e-3, 0.0)),
    ("percent", (Kind::Percent, 1.0, 0.0)),
    ("%", (Kind::Percent, 1.0, 0.0)),
    ("pct", (Kind::Percent, 1.0, 0.0)),
    ("counts", (Kind::Counts, 1.0, 0.0)),
];

/// The unit that a column name of the document ends in, as [`UNITS`] writes it.
const ENDINGS: [(&str, &str); 16] = [
    ("s", "s"),
    ("a", "A"),
    ("v", "V"),
    ("nt", "nT"),
    ("c", "C"),
    ("k", "K"),
    ("hz", "Hz"),
    ("rad", "rad"),
    ("deg", "deg"),
    ("arcsec", "arcsec"),
    ("m", "m"),
    ("pa", "Pa"),
    ("percent", "percent"),
    ("ohm", "ohm"),
    ("w", "W"),
    ("counts", "counts"),
];

/// What a mapping may say, for messages.
pub const KNOWN: &str = "T, mT, uT (µT), nT, pT, G, mG, counts (with \"scale\"), V, mV, A, mA, C, K, F, deg, arcmin, arcsec, rad, \
                         mrad, m, cm, mm, Pa, hPa, mbar, Hz, s, ms, ohm, W, percent";

/// A unit without blanks, µ and Ω in one spelling.
fn plain(name: &str) -> String {
    let close: String = name.chars().filter(|letter| !letter.is_whitespace()).collect();
    close.replace(['µ', 'μ'], "u").replace(['Ω', 'Ω'], "ohm")
}

fn unit(name: &str) -> Option<Unit> {
    let name = plain(name);
    UNITS.iter().find(|(known, _)| *known == name).map(|(_, unit)| *unit)
}

/// Whether a file's unit is known.
pub fn is_known(name: &str) -> bool {
    unit(name).is_some()
}

/// The unit that a column's name ends in, as a file would write it (`nT` of `sensor_x_nt`); None where it ends in none.
pub fn of_column(column: &str) -> Option<&'static str> {
    let (quantity, ending) = column.rsplit_once('_')?;
    // The w of a quaternion.
    if quantity == "attitude" {
        return None;
    }
    ENDINGS.iter().find(|(known, _)| *known == ending).map(|(_, unit)| *unit)
}

/// The ending of column names in the document for values in `name`, of the same kind: `nt` for `G`, `c` for `F`.
pub fn ending_for(name: &str) -> Option<&'static str> {
    Some(match unit(name)?.0 {
        Kind::Field => "nt",
        Kind::Temperature => "c",
        Kind::Voltage => "v",
        Kind::Current => "a",
        Kind::Angle if plain(name).ends_with("rad") => "rad",
        Kind::Angle if matches!(plain(name).as_str(), "arcsec" | "\"") => "arcsec",
        Kind::Angle => "deg",
        Kind::Length => "m",
        Kind::Pressure => "pa",
        Kind::Frequency => "hz",
        Kind::Time => "s",
        Kind::Resistance => "ohm",
        Kind::Power => "w",
        Kind::Percent => "percent",
        Kind::Counts => "counts",
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
        assert_eq!(conversion("V", "nT"), None);
        assert!(!is_known("furlong") && !is_known("g"));
        assert_eq!(
            (of_column("sensor_x_nt"), of_column("position"), of_column("x_y")),
            (Some("nT"), None, None)
        );
    }
}
