//! What no instrument reads: fill values and faults that would otherwise be taken for readings.

use crate::Error;
use crate::number::{bare, quoted};
use serde_json::Value;

/// How names of columns, conditions and constants end, with the lowest and the highest value: constants of an
/// instrument by name, all else by its unit. The strongest steady magnets make 45 T; a magnetometer of 1 T has
/// little to do with the field of the Earth, nor has a coil of 0.1 T/A.
const BOUNDS: [(&str, [f64; 2]); 9] = [
    ("constant_nt_per_a", [-1e8, 1e8]),
    ("sensitivity_nt_per_v", [-1e9, 1e9]),
    ("sensitivity_nt_per_nt", [-1e6, 1e6]),
    ("offset_nt", [-1e7, 1e7]),
    ("_nt", [-1e9, 1e9]),
    ("_v", [-1e6, 1e6]),
    ("_a", [-1e6, 1e6]),
    ("_c", [-273.15, 1e4]),
    // A turn.
    ("_arcsec", [-1.296e6, 1.296e6]),
];

/// The range of a proton magnetometer, the scalar reference where the facility states no range, nT (NASA).
pub const SCALAR_NT: [f64; 2] = [20_000.0, 60_000.0];
/// How far beyond the scalar reference's range a reading may lie, as a share: a step to its end does not land
/// on it exactly.
pub const SCALAR_MARGIN: f64 = 0.005;

/// The lowest and the highest value that a column of this name may have, by the unit at its end; any number
/// where that is none of these.
pub fn bounds(column: &str) -> [f64; 2] {
    BOUNDS.iter().find(|(unit, _)| column.ends_with(unit)).map_or([f64::MIN, f64::MAX], |(_, bounds)| *bounds)
}

/// The numbers of a part of a document, each by the key that it or its list has.
///
/// # Errors
///
/// A number that no instrument has.
pub(crate) fn numbers(path: &str, key: &str, part: &Value) -> Result<(), Error> {
    match part {
        Value::Number(value) => within(bounds(key), path, value.as_f64().unwrap_or(f64::NAN)),
        Value::Array(list) => {
            let mut items = list.iter().enumerate();
            items.try_for_each(|(place, item)| numbers(&format!("{path}[{place}]"), key, item))
        }
        Value::Object(map) => map.iter().try_for_each(|(own, item)| {
            // A quantity has the unit of its key.
            let unit = if ["value", "std"].contains(&own.as_str()) { key } else { own };
            numbers(&format!("{path}.{own}"), unit, item)
        }),
        _ => Ok(()),
    }
}

/// A number of a document, which may be undetermined, by the key at the end of its path.
///
/// # Errors
///
/// A number that no instrument has.
pub(crate) fn number(path: String, value: f64) -> Result<(), Error> {
    within(bounds(&path), &path, value)
}

fn within([low, high]: [f64; 2], path: &str, value: f64) -> Result<(), Error> {
    if value < low || value > high {
        let expected = format!("a number between {} and {}; is it in another unit?", bare(low), bare(high));
        return Err(Error::document(path, quoted(value), expected));
    }
    Ok(())
}

/// The first row whose value no instrument reads. A missing reading is none.
pub fn first_beyond(column: &str, values: &[f64]) -> Option<usize> {
    first_outside(bounds(column), values)
}

/// The first row whose value is outside a range. A missing reading is none.
pub(crate) fn first_outside([low, high]: [f64; 2], values: &[f64]) -> Option<usize> {
    values.iter().position(|value| *value < low || *value > high)
}

/// Rows of a table that is read piece by piece, of which `first_row` (from 0) is the first.
///
/// # Errors
///
/// The first value that no instrument reads, with row (from 1) and column.
pub fn rows<'a>(
    table: &str,
    first_row: u64,
    columns: impl IntoIterator<Item = (&'a str, &'a [f64])>,
) -> Result<(), Error> {
    for (column, values) in columns {
        if let Some(row) = first_beyond(column, values) {
            let [low, high] = bounds(column);
            return Err(Error::Request(format!(
                "{table}, row {}, column {column}: found {}; expected a reading between {} and {}; leave a missing one empty",
                first_row + row as u64 + 1,
                quoted(values[row]),
                bare(low),
                bare(high)
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::first_beyond;

    #[test]
    fn by_the_unit() {
        assert_eq!(first_beyond("sensor_x_nt", &[6e4, f64::NAN, -1e31]), Some(2));
        assert_eq!(first_beyond("sensor_temperature_c", &[20.0, -300.0]), Some(1));
        assert_eq!(first_beyond("coil_x_a", &[1e200]), Some(0));
        assert_eq!(first_beyond("time_s", &[1.7e18]), None);
        assert_eq!(first_beyond("time_s", &[0.0, f64::INFINITY]), Some(1));
    }
}
