//! Names that loggers give to temperatures.

use super::names::is_among;

/// Whose temperature it is, by words in a name of letters and digits in lower case; the first that fits.
const WHOSE: [(&str, &str); 4] = [
    ("electronics", "elec electronics electronic board box pcb cpu logger console local adc"),
    ("outside", "outside outdoor air ambient env environment"),
    ("coil", "coil coils"),
    ("sensor", "sensor sens sen head mag magnetometer fluxgate probe remote"),
];
/// What stands for a temperature beside such a word, or alone.
const STEMS: &str = "temperature temp tmp tmpr thermistor therm ntc rtd pt100 pt1000 ds18b20 tmp102";
/// Names that say nothing of temperature but are one in some logger: LEMI's, Narod's and Magson's tables,
/// MagPy's keys, HamSCI's RM3100 board.
const SHORT: [(&str, &str); 3] = [
    ("sensor", "tf ts tsen tsens tsensor thead rt"),
    ("electronics", "te tel telec telectronics tbox lt"),
    ("outside", "tair tout tamb"),
];

/// The document's column for a temperature of that name; `in_degrees`: its unit is one of temperature.
pub fn column(base: &str, in_degrees: bool) -> Option<String> {
    let words = words(base);
    let plain: String = words.concat();
    if let Some((whose, _)) = SHORT.iter().find(|(_, names)| is_among(&plain, names)) {
        // `ts` may be a time as well: that is for its unit to say.
        return (in_degrees || plain != "ts").then(|| format!("{whose}_temperature_c"));
    }
    let named = |word: &str| WHOSE.iter().find(|(_, known)| is_among(word, known)).map(|(whose, _)| *whose);
    let is_temperature = |word: &String| {
        let stem = word.trim_end_matches(|letter: char| letter.is_ascii_digit());
        let is = |known: &str| is_among(word, known) || is_among(stem, known);
        is(STEMS) || in_degrees && is("t")
    };
    // What is left of the name says whose it is: of words, the others; of one word such as `boxtemp`, the
    // rest of it.
    let rest = match words.iter().position(is_temperature) {
        Some(at) => [&words[..at], &words[at + 1..]].concat().join("_"),
        None => {
            let mut stems = STEMS.split(' ');
            let rest =
                stems.find_map(|stem| plain.strip_suffix(stem).or_else(|| plain.strip_prefix(stem)))?;
            named(rest).is_some().then(|| rest.to_string())?
        }
    };
    let whose = match rest.as_str() {
        "" => "sensor",
        rest => rest.split('_').find_map(named).unwrap_or(rest),
    };
    Some(format!("{whose}_temperature_c"))
}

/// Words of a name in lower case: `SensorTemp` and `sensor_temp` have two.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_lower = false;
    for letter in name.chars() {
        if !letter.is_alphanumeric() || letter.is_uppercase() && was_lower {
            words.push(String::new());
        }
        was_lower = letter.is_lowercase();
        if let Some(word) = words.last_mut().filter(|_| letter.is_alphanumeric()) {
            word.extend(letter.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

#[cfg(test)]
mod tests {
    use super::column;

    #[test]
    fn names_of_loggers() {
        for (in_degrees, whose, names) in [
            (false, "sensor", "Temp temperature SensorTemp sensor_temp temp2 rt DS18B20"),
            (false, "electronics", "elec_temp ElectronicsTemperature boxtemp board_temp lt"),
            (false, "bmp", "bmp_temp"),
            (false, "outside", "air-temperature"),
            (false, "coil", "coil_temp"),
            (true, "electronics", "Te"),
            (true, "sensor", "Tf T t1 tmp102 ts"),
            (true, "imu", "imu_T"),
            (true, "outside", "env_T"),
        ] {
            for name in names.split(' ') {
                assert_eq!(column(name, in_degrees), Some(format!("{whose}_temperature_c")), "{name}");
            }
        }
        for name in ["t", "ts", "t1", "attempt_x", "x", "tilt", "dew_point", "template_x", "contempt"] {
            assert_eq!(column(name, false), None, "{name}");
        }
        assert_eq!(column("dew_point", true), None);
    }
}
