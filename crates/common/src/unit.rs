//! The unit that the name of a housekeeping column ends in.

/// Endings, what a difference is counted in (in names of keys), and that for people.
const UNITS: [(&str, &str, &str); 18] = [
    ("s", "s", "s"),
    ("a", "a", "A"),
    ("am2", "am2", "(A m²)"),
    ("v", "v", "V"),
    ("nt", "nt", "nT"),
    ("c", "k", "K"),
    ("degc", "k", "K"),
    ("k", "k", "K"),
    ("hz", "hz", "Hz"),
    ("rad", "rad", "rad"),
    ("deg", "deg", "deg"),
    ("arcsec", "arcsec", "″"),
    ("m", "m", "m"),
    ("pa", "pa", "Pa"),
    ("percent", "percent", "%"),
    ("ohm", "ohm", "Ω"),
    ("w", "w", "W"),
    ("counts", "counts", "count"),
];

fn of(column: &str) -> Option<&'static (&'static str, &'static str, &'static str)> {
    let name = column.split(' ').next()?;
    let (_, ending) = name.rsplit_once('_')?;
    UNITS.iter().find(|(known, ..)| *known == ending)
}

/// What a change of a column is counted in, as keys have it (`k` of `test_temperature_c`); `unit` where its name
/// says none.
pub fn of_change(column: &str) -> &'static str {
    of(column).map_or("unit", |(_, key, _)| key)
}

/// The same for people: `K`, `(A m²)`.
pub fn in_words(column: &str) -> &'static str {
    of(column).map_or("unit", |(.., words)| words)
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
    }
}
