//! What a mapping says of a column's values before they are converted: which stand for none, how whole
//! numbers are coded, what is a reading.

use common::number::{bare, counted};

use crate::mapping::ColumnMapping;

/// Makes fill values missing, whole numbers in two's complement signed, and values outside the valid range
/// missing. Returns notes on what became missing, and the first row that is no whole number of so many bits,
/// with what was expected.
pub fn clean(column: &ColumnMapping, values: &mut [f64]) -> (Vec<String>, Option<(usize, String)>) {
    let (name, mut notes) = (&column.to, Vec::new());
    let fills = &column.missing;
    let missing = if fills.is_empty() { 0 } else { without(values, |value| fills.contains(&value)) };
    if missing > 0 {
        let (count, all) = (counted(missing, "fill value"), fills.iter().map(|value| bare(*value)));
        notes.push(format!("{count} ({}) of {name}, taken as missing", all.collect::<Vec<_>>().join(", ")));
    }
    let no_integer = column.bits.and_then(|bits| signed(values, bits));
    if let Some([low, high]) = column.valid
        && let invalid @ 1.. = without(values, |value| !(low..=high).contains(&value))
    {
        let (count, low, high) = (counted(invalid, "value"), bare(low), bare(high));
        notes.push(format!("{count} of {name} outside {low} to {high}, taken as missing"));
    }
    (notes, no_integer)
}

fn without(values: &mut [f64], is_missing: impl Fn(f64) -> bool) -> usize {
    let found = values.iter_mut().filter(|value| !value.is_nan() && is_missing(**value));
    found.map(|value| *value = f64::NAN).count()
}

/// Two's complement, written without sign, to signed numbers; numbers with their sign stay. The first row
/// that is neither, if any, with what was expected.
fn signed(values: &mut [f64], bits: u8) -> Option<(usize, String)> {
    let (half, all) = (f64::from(bits - 1).exp2(), f64::from(bits).exp2());
    let wrong = |value: &f64| !value.is_nan() && (value.fract() != 0.0 || !(-half..all).contains(value));
    if let Some(first) = values.iter().position(wrong) {
        let (low, high) = (bare(-half), bare(all - 1.0));
        let expected =
            format!("a whole number of {bits} bits, {low} to {high}, as the mapping's `bits` says");
        return Some((first, expected));
    }
    values.iter_mut().filter(|value| **value >= half).for_each(|value| *value -= all);
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::SourceColumn;
    use proptest::prelude::*;

    #[test]
    fn in_their_order() {
        let column = ColumnMapping {
            missing: vec![65_535.0],
            bits: Some(16),
            valid: Some([-100.0, 100.0]),
            ..ColumnMapping::plain(SourceColumn::Name("x".into()), "x", None)
        };
        let mut values = [5.0, 65_535.0, 65_534.0, 32_768.0, f64::NAN, -7.0];
        let (notes, no_integer) = clean(&column, &mut values);
        let expected = [
            "1 fill value (65535) of x, taken as missing",
            "1 value of x outside −100 to 100, taken as missing",
        ];
        assert_eq!((notes.as_slice(), no_integer), (&expected.map(String::from)[..], None));
        assert_eq!([values[0], values[2], values[5]], [5.0, -2.0, -7.0]);
        assert!([values[1], values[3], values[4]].iter().all(|value| value.is_nan()));
        let column = ColumnMapping { bits: Some(12), valid: None, ..column };
        let first = |value: f64| clean(&column, &mut [0.0, value]).1.map(|(row, _)| row);
        assert_eq!([4095.0, 4096.0, -2049.0, 1.5].map(first), [None, Some(1), Some(1), Some(1)]);
    }

    proptest! {
        #[test]
        fn twos_complement(value in -(1_i64 << 52)..(1_i64 << 52), bits in 2_u8..=53) {
            let (half, all) = (1_i64 << (bits - 1), 1_i64 << bits);
            let value = value.rem_euclid(all) - half;
            let mut coded = [value.rem_euclid(all) as f64];
            prop_assert_eq!(signed(&mut coded, bits), None);
            prop_assert_eq!(coded[0], value as f64);
        }
    }
}
