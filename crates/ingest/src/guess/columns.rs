//! What the columns of readings are, and in which unit.

use common::unit;

use super::names::{is_among, plain};
use super::open::Guess;
use super::sample::{Cells, Sample};
use super::{circles, content, temperatures};
use crate::mapping::ColumnMapping;
use crate::units;

/// What stands around x, y and z in names of field readings, in letters of lower case, where anything does.
const STEMS: &str = "b m h mag magn field bfield magfield magnetic magneticfield magnetometer flux fluxgate fgm fg \
                     rm sensor fieldvector";
/// What names the field of another instrument, before or behind such a stem.
const OTHERS: &str = "ref reference base basestation std standard remote obs observatory station";
/// Names of a scalar magnetometer's readings.
const SCALARS: &str = "f scalar fscalar totalfield fieldmagnitude proton pmag overhauser";
/// Beginnings of names that the document knows, up to their underscore.
const KNOWN: &str = "coil sensor reference test third outside ambient electronics attitude tilt";
const GENERIC: &str = "ch chan channel c col column var field value val data in input ain analog adc unnamed";

struct Told {
    column: usize,
    /// Its name without the unit.
    base: String,
    unit: Option<String>,
}

/// Guesses the columns that `time` does not take.
pub fn guess(sample: &Sample, time: &[usize], quantity: &str, guess: &mut Guess) {
    let mut told = Vec::new();
    for column in (0..sample.kinds.len()).filter(|column| !time.contains(column)) {
        match sample.kinds[column] {
            // MagPy writes the time twice, once as days.
            Cells::Numbers if !time.is_empty() && plain(&sample.names[column]) == "timedays" => {}
            Cells::Numbers => {
                let (base, unit) = split_unit(&sample.names[column]);
                let unit = unit.or_else(|| sample.units.get(column).cloned().flatten());
                told.push(Told { column, base, unit });
            }
            Cells::Empty if sample.names[column].trim_matches(['-', '[', ']']).is_empty() => {}
            kind => {
                let what = if kind == Cells::Empty { "holds nothing" } else { "holds no numbers" };
                let (number, name) = (column + 1, &sample.names[column]);
                guess.notes.push(format!("column {number} ({name:?}) {what} and is ignored"));
            }
        }
    }
    let by_name = vector(&told, |stem| stem.is_empty() || is_among(stem, STEMS));
    let other = vector(&told, is_other).filter(|_| quantity != "reference");
    let by_content = if by_name.is_none() { vector_by_content(&told, sample) } else { None };
    let (vector, why) = match by_content {
        Some((vector, unit, why)) => (Some(vector), Some((unit, why))),
        None => (by_name, None),
    };
    // Columns of anything may look like temperatures: where many do, none is taken for one.
    const THERMOMETERS: usize = 2;
    let unnamed = |index: &usize| vector.is_none_or(|vector| !vector.contains(index));
    let like_temperature = |index: &usize| temperature_by_content(&told[*index], sample).is_some();
    let thermal = (0..told.len()).filter(unnamed).filter(like_temperature).count() <= THERMOMETERS;
    // A unit that is not known, "?", is none of a circle.
    let ending = |unit: &String| units::ending_for(unit).unwrap_or("?");
    let endings = told.iter().map(|one| (one.base.as_str(), one.unit.as_ref().map(ending)));
    let circles = circles::find(&endings.collect::<Vec<_>>());
    let beyond = circles
        .iter()
        .filter(|(_, to)| to.ends_with("_deg"))
        .any(|(place, _)| sample.numbers(told[*place].column).into_iter().any(|reading| reading > 360.0));
    let mut names: Vec<String> = Vec::new();
    for (index, one) in told.iter().enumerate() {
        let mut mapping =
            ColumnMapping::plain(sample.from[one.column].clone(), String::new(), one.unit.clone());
        let axis = vector.and_then(|all| place(all, index));
        let named = is_known(&sample.names[one.column]);
        match axis {
            Some(axis) if !named => {
                if let Some((unit, why)) = &why {
                    mapping.to = format!("{quantity}_{axis}_nt");
                    mapping.unit = Some(unit.to_string());
                    mapping.note = Some(format!("taken as the axes of one field by their content: {why}"));
                } else {
                    let all = vector.unwrap_or_default().map(|index| sample.numbers(told[index].column));
                    field(&mut mapping, axis, quantity, &all);
                }
            }
            None if let Some((axis, all)) = other.and_then(|all| Some((place(all, index)?, all)))
                && !named =>
            {
                field(&mut mapping, axis, "reference", &all.map(|index| sample.numbers(told[index].column)));
                let question = "taken as the reference beside the sensors, by the name; for another instrument write `outside_x_nt`, … or `third_x_nt`, …";
                let unit = mapping.note.take();
                mapping.note = Some(unit.map_or(question.into(), |unit| format!("{question}; {unit}")));
            }
            None if let Some((_, to)) = circles.iter().find(|(place, _)| *place == index) => {
                circles::map(&mut mapping, to, beyond);
            }
            _ => scalar_or_other(&mut mapping, one, sample, thermal),
        }
        if names.contains(&mapping.to) {
            mapping.to = numbered(&mapping.to, &names);
        }
        names.push(mapping.to.clone());
        guess.mapping.columns.push(mapping);
    }
    doubts(sample, &told, guess);
}

/// What is open, each question once with the columns that it is about.
fn doubts(sample: &Sample, told: &[Told], guess: &mut Guess) {
    let mut questions: Vec<(String, Vec<String>)> = Vec::new();
    for (one, mapping) in told.iter().zip(&guess.mapping.columns) {
        let question = match (&mapping.unit, &mapping.note) {
            (Some(unit), _) if unit == "?" => "no known unit is stated".to_string(),
            (_, Some(note)) => note.clone(),
            _ => continue,
        };
        let name = &sample.names[one.column];
        let name = if name.is_empty() { format!("column {}", one.column + 1) } else { format!("{name:?}") };
        match questions.iter_mut().find(|(known, _)| *known == question) {
            Some((_, columns)) => columns.push(name),
            None => questions.push((question, vec![name])),
        }
    }
    let said = questions.into_iter().map(|(question, columns)| format!("{}: {question}", columns.join(", ")));
    guess.doubts.extend(said);
    if sample.names.iter().all(String::is_empty) {
        guess.doubts.push("what the columns are: the file names none".into());
    }
}

/// A unit in which readings of that size are the Earth's field, with the question; `?` where there is none.
fn of_earth(sizes: Vec<f64>) -> (String, Option<String>) {
    match content::unit_of_earth(sizes) {
        Some(unit) => {
            let note = format!("no unit is stated; in {unit} the field would be as strong as the Earth's");
            (unit.into(), Some(note))
        }
        None => ("?".into(), None),
    }
}

/// Whether a name says nothing: none, a number, `ch3`, `Column 5`.
fn is_generic(base: &str) -> bool {
    let name = plain(base);
    let word = name.trim_matches(|letter: char| letter.is_ascii_digit());
    word.is_empty() || is_among(word, GENERIC)
}

/// Whether a name begins as those of the document.
fn is_known(name: &str) -> bool {
    name.split_once('_').is_some_and(|(head, _)| is_among(head, KNOWN))
}

/// Three columns beside one another that are one field by their content, where their names say nothing.
fn vector_by_content(told: &[Told], sample: &Sample) -> Option<([usize; 3], &'static str, String)> {
    let candidate = |one: &Told| one.unit.is_none() && is_generic(&one.base);
    (2..told.len()).find_map(|last| {
        let all = [last - 2, last - 1, last];
        let columns = all.map(|index| sample.numbers(told[index].column));
        let (unit, why) =
            content::field(&columns).filter(|_| all.iter().all(|index| candidate(&told[*index])))?;
        Some((all, unit, why))
    })
}

/// The axis that a column is of a vector.
fn place(vector: [usize; 3], index: usize) -> Option<&'static str> {
    vector.iter().position(|found| *found == index).map(|axis| ["x", "y", "z"][axis])
}

/// Whether what stands around x, y and z names another instrument: `ref`, `base_mag`, `b_obs`.
fn is_other(stem: &str) -> bool {
    OTHERS.split(' ').any(|other| {
        let rest = stem.strip_prefix(other).or_else(|| stem.strip_suffix(other));
        rest.is_some_and(|rest| rest.is_empty() || is_among(rest, STEMS))
    })
}

/// Three columns that are x, y and z of one field, with such a stem around: the first such three.
fn vector(told: &[Told], is_stem: impl Fn(&str) -> bool) -> Option<[usize; 3]> {
    let of_field = |unit: &Option<String>| {
        unit.as_deref().is_none_or(|unit| matches!(units::ending_for(unit), Some("nt" | "v")))
    };
    let stem = |told: &Told, axis: char| {
        let name = plain(&told.base);
        let (head, digits_end) =
            name.split_at(name.trim_end_matches(|letter: char| letter.is_ascii_digit()).len());
        let without = name.strip_suffix(axis).or_else(|| name.strip_prefix(axis));
        // x1, bx2: the axis before a number.
        let without = without.or_else(|| head.strip_suffix(axis).filter(|_| !digits_end.is_empty()))?;
        let stem = without.trim_end_matches(|letter: char| letter.is_ascii_digit());
        is_stem(stem).then(|| (stem.to_string(), digits_end.to_string()))
    };
    told.iter().enumerate().find_map(|(x, first)| {
        let key = stem(first, 'x').filter(|_| of_field(&first.unit))?;
        let other = |axis: char| {
            told.iter().position(|one| stem(one, axis).as_ref() == Some(&key) && one.unit == first.unit)
        };
        Some([x, other('y')?, other('z')?])
    })
}

/// An axis of the field; where the unit is not stated, one in which the readings are the Earth's field.
fn field(mapping: &mut ColumnMapping, axis: &str, quantity: &str, all: &[Vec<f64>; 3]) {
    let ending = mapping.unit.as_deref().and_then(units::ending_for).unwrap_or("nt");
    mapping.to = format!("{quantity}_{axis}_{ending}");
    if mapping.unit.is_some() {
        return;
    }
    let (unit, note) = of_earth(content::norms(all));
    (mapping.unit, mapping.note) = (Some(unit), note);
}

fn scalar_or_other(mapping: &mut ColumnMapping, told: &Told, sample: &Sample, thermal: bool) {
    let (name, column) = (sample.names[told.column].as_str(), told.column);
    let short = plain(&told.base);
    let ending = told.unit.as_deref().and_then(units::ending_for);
    if is_among(&short, SCALARS) && matches!(ending, None | Some("nt")) {
        mapping.to = "reference_nt".into();
        if mapping.unit.is_none() {
            let (unit, note) = of_earth(sample.numbers(column));
            (mapping.unit, mapping.note) = (Some(unit), note);
        }
        return;
    }
    if is_known(name) && is_name(name) && name == name.to_lowercase() {
        mapping.to = name.into();
        return;
    }
    let base = sanitized(&told.base, column);
    let by_name =
        temperatures::column(&told.base, ending == Some("c")).filter(|_| matches!(ending, None | Some("c")));
    if let Some(temperature) = by_name {
        mapping.to = temperature;
        if told.unit.is_none() {
            let kelvin = content::temperature(&sample.numbers(column)).is_some_and(|(unit, _)| unit == "K");
            mapping.unit = Some(if kelvin { "K" } else { "C" }.into());
            let unit = if kelvin { "K" } else { "°C" };
            mapping.note = Some(format!("no unit is stated; {unit} is usual"));
        }
        return;
    }
    if thermal && let Some((unit, why)) = temperature_by_content(told, sample) {
        mapping.to = "sensor_temperature_c".into();
        (mapping.unit, mapping.note) = (Some(unit.into()), Some(why));
        return;
    }
    mapping.to = match ending {
        Some(ending) => format!("{base}_{ending}"),
        // A name that ends as if in a unit would be taken for one.
        None if unit::of_column(&base).is_some() => format!("{base}_value"),
        None => base,
    };
}

/// A column whose name says nothing and whose values are a temperature's.
fn temperature_by_content(told: &Told, sample: &Sample) -> Option<(&'static str, String)> {
    let open = told.unit.is_none() && is_generic(&told.base);
    open.then(|| content::temperature(&sample.numbers(told.column)))?
}

fn is_name(name: &str) -> bool {
    name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
}

/// A name of letters, digits and single underscores.
fn sanitized(name: &str, column: usize) -> String {
    let mut clean = String::new();
    for letter in name.chars().flat_map(char::to_lowercase) {
        if letter.is_ascii_alphanumeric() {
            clean.push(letter);
        } else if !clean.is_empty() && !clean.ends_with('_') {
            clean.push('_');
        }
    }
    let clean = clean.trim_end_matches('_');
    if clean.is_empty() || clean == "time_s" { format!("column_{}", column + 1) } else { clean.into() }
}

/// A name that is free: `panel_2_a` after `panel_a`.
fn numbered(name: &str, taken: &[String]) -> String {
    let (head, ending) = match unit::of_column(name).and_then(|_| name.rsplit_once('_')) {
        Some((head, ending)) => (head, format!("_{ending}")),
        None => (name, String::new()),
    };
    let free = (2..).map(|number| format!("{head}_{number}{ending}")).find(|name| !taken.contains(name));
    free.unwrap_or_else(|| name.into())
}

/// A name and the unit that it states: `Bx (µT)`, `Bx [nT]`, `x_nT`, `sensor_x_nt`.
fn split_unit(name: &str) -> (String, Option<String>) {
    for (open, close) in [('(', ')'), ('[', ']')] {
        if let Some((base, rest)) = name.rsplit_once(open)
            && let Some((unit, _)) = rest.split_once(close)
        {
            let known = units::is_known(unit).then(|| unit.trim().to_string());
            let stated = known.or_else(|| Some("?".into()).filter(|_| !unit.trim().is_empty()));
            return (base.trim().to_string(), stated);
        }
    }
    if let Some((base, unit)) = name.rsplit_once(['_', ' ', '/']) {
        let lower = unit.chars().all(|letter| letter.is_ascii_lowercase());
        let meant = is_known(name) || units::is_measured(base, unit);
        let known = meant && unit::of_column(name).is_some();
        let long = units::is_known(unit) && (!lower || unit.len() > 1);
        if !base.is_empty() && (known || long) {
            return (base.to_string(), Some(unit.to_string()));
        }
        if unit == "raw" || unit == "count" {
            return (base.to_string(), Some("counts".into()));
        }
    }
    (name.to_string(), None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_in_names() {
        for (name, base, unit) in [
            ("Bx (μT)", "Bx", "μT"),
            ("x_nT", "x", "nT"),
            ("field [nT]", "field", "nT"),
            ("T (°C)", "T", "°C"),
            ("imu_T_C", "imu_T", "C"),
            ("sensor_x_v", "sensor_x", "v"),
            ("load_current_a", "load_current", "a"),
            ("route_a", "route_a", ""),
            ("orient_w", "orient_w", ""),
            ("mag_x", "mag_x", ""),
            ("rm3100_x_raw", "rm3100_x", "counts"),
            ("Bx (furlong)", "Bx", "?"),
        ] {
            let unit = Some(unit.to_string()).filter(|unit| !unit.is_empty());
            assert_eq!(split_unit(name), (base.to_string(), unit));
        }
    }

    #[test]
    fn names_of_another_instrument() {
        assert!(["ref", "basemag", "bobs"].into_iter().all(is_other));
        assert!(!["mag", "refuse"].into_iter().any(is_other));
    }

    #[test]
    fn three_axes_of_one_field() {
        for (names, found) in [
            ("accel_x accel_y accel_z mag_x mag_y mag_z", Some([3, 4, 5])),
            ("z y x", Some([2, 1, 0])),
            ("x1 y1 z1 x2 y2 z2", Some([0, 1, 2])),
            ("rm3100_x rm3100_y rm3100_z", Some([0, 1, 2])),
            ("x y", None),
        ] {
            let told = names.split(' ').enumerate();
            let told = told.map(|(column, name)| Told { column, base: name.to_string(), unit: None });
            let told: Vec<Told> = told.collect();
            assert_eq!(vector(&told, |stem| stem.is_empty() || is_among(stem, STEMS)), found, "{names}");
            assert_eq!(vector(&told, is_other), None, "{names}");
        }
    }
}
