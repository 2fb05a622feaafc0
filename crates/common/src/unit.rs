//! The units that names of columns and keys end in.

/// Endings, with the units for people.
const UNITS: [(&str, &str); 18] = [
    ("s", "s"),
    ("a", "A"),
    ("am2", "A m²"),
    ("v", "V"),
    ("nt", "nT"),
    ("c", "°C"),
    ("k", "K"),
    ("hz", "Hz"),
    ("rad", "rad"),
    ("deg", "deg"),
    ("arcsec", "arcsec"),
    ("m", "m"),
    ("pa", "Pa"),
    ("percent", "%"),
    ("ohm", "Ω"),
    ("w", "W"),
    ("counts", "counts"),
    ("rpm", "rpm"),
];

/// The unit of an ending.
pub fn of_ending(ending: &str) -> Option<&'static str> {
    UNITS.iter().find(|(known, _)| *known == ending).map(|(_, unit)| *unit)
}

/// The ending of a column's name that is a unit, with that unit. The w of a quaternion is none, and what follows
/// a blank (of which recording it is) is no part of the name.
pub fn of_column(column: &str) -> Option<(&'static str, &'static str)> {
    let name = column.split(' ').next()?;
    let (_, ending) = name.rsplit_once('_').filter(|(quantity, _)| *quantity != "attitude")?;
    UNITS.iter().find(|(known, _)| *known == ending).copied()
}

/// What a change of a column is counted in, as keys have it (`k` of `test_temperature_c`); `unit` where its name
/// says none.
pub fn of_change(column: &str) -> &'static str {
    match of_column(column) {
        Some(("c", _)) => "k",
        other => other.map_or("unit", |(ending, _)| ending),
    }
}

/// The same for people: `K`, `(A m²)`.
pub fn in_words(column: &str) -> &'static str {
    match of_change(column) {
        "unit" => "unit",
        "am2" => "(A m²)",
        ending => of_ending(ending).unwrap_or(ending),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_says_its_unit() {
        let both = |column| (of_change(column), in_words(column));
        assert_eq!(both("test_temperature_c"), ("k", "K"));
        assert_eq!(both("torquer_x_am2"), ("am2", "(A m²)"));
        assert_eq!(both("load_current_a of \"night\""), ("a", "A"));
        assert_eq!(both("heater_state"), ("unit", "unit"));
        assert_eq!((of_column("sensor_temperature_c"), of_column("attitude_w")), (Some(("c", "°C")), None));
    }
}
