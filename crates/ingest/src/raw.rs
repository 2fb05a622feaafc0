//! What a mapping says of a column's values before they are converted: which stand for none, how whole
//! numbers are coded, what is a reading.

use common::number::{bare, counted};

use crate::mapping::ColumnMapping;

/// What was done to a column.
pub struct Raw<'a> {
    column: &'a ColumnMapping,
    missing: usize,
    invalid: usize,
    /// The first row that is no whole number of so many bits, and what was expected.
    pub no_integer: Option<(usize, String)>,
}

impl<'a> Raw<'a> {
    /// Makes fill values missing, whole numbers in two's complement signed, and values outside the valid
    /// range missing.
    pub fn of(column: &'a ColumnMapping, values: &mut [f64]) -> Self {
        let mut raw = Raw { column, missing: 0, invalid: 0, no_integer: None };
        if !column.missing.is_empty() {
            raw.missing = without(values, |value| column.missing.contains(&value));
        }
        if let Some(bits) = column.bits {
            raw.no_integer = signed(values, bits).map(|row| (row, integers(bits)));
        }
        if let Some([low, high]) = column.valid {
            raw.invalid = without(values, |value| !(low..=high).contains(&value));
        }
        raw
    }

    /// In words, what became missing.
    pub fn notes(&self, name: &str) -> Vec<String> {
        let mut notes = Vec::new();
        if self.missing > 0 {
            let all: Vec<String> = self.column.missing.iter().map(|value| bare(*value)).collect();
            notes.push(format!(
                "{} ({}) of {name}, taken as missing",
                counted(self.missing, "fill value"),
                all.join(", ")
            ));
        }
        if let (1.., Some([low, high])) = (self.invalid, self.column.valid) {
            let (count, low, high) = (counted(self.invalid, "value"), bare(low), bare(high));
            notes.push(format!("{count} of {name} outside {low} to {high}, taken as missing"));
        }
        notes
    }
}

/// Makes values missing; how many.
fn without(values: &mut [f64], is_missing: impl Fn(f64) -> bool) -> usize {
    let found = values.iter_mut().filter(|value| !value.is_nan() && is_missing(**value));
    found.map(|value| *value = f64::NAN).count()
}

/// Two's complement, written without sign, to signed numbers; numbers with their sign stay. The first row
/// that is neither, if any.
fn signed(values: &mut [f64], bits: u8) -> Option<usize> {
    let (half, all) = (f64::from(bits - 1).exp2(), f64::from(bits).exp2());
    let wrong = |value: &f64| !value.is_nan() && (value.fract() != 0.0 || !(-half..all).contains(value));
    let first = values.iter().position(wrong);
    if first.is_none() {
        values.iter_mut().filter(|value| **value >= half).for_each(|value| *value -= all);
    }
    first
}

fn integers(bits: u8) -> String {
    let (half, all) = (f64::from(bits - 1).exp2(), f64::from(bits).exp2());
    format!(
        "a whole number of {bits} bits, {} to {}, as the mapping's `bits` says",
        bare(-half),
        bare(all - 1.0)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::SourceColumn;
    use proptest::prelude::*;

    fn column() -> ColumnMapping {
        ColumnMapping::plain(SourceColumn::Name("x".into()), "x", None)
    }

    #[test]
    fn in_their_order() {
        let column = ColumnMapping {
            missing: vec![65_535.0],
            bits: Some(16),
            valid: Some([-100.0, 100.0]),
            ..column()
        };
        let mut values = [5.0, 65_535.0, 65_534.0, 32_768.0, f64::NAN, -7.0];
        let raw = Raw::of(&column, &mut values);
        assert_eq!((raw.missing, raw.invalid, raw.no_integer.is_none()), (1, 1, true));
        assert_eq!([values[0], values[2], values[5]], [5.0, -2.0, -7.0]);
        assert!([values[1], values[3], values[4]].iter().all(|value| value.is_nan()));
        assert_eq!(raw.notes("x")[1], "1 value of x outside −100 to 100, taken as missing");
        let column = ColumnMapping { bits: Some(12), valid: None, ..column };
        let first = |value: f64| Raw::of(&column, &mut [0.0, value]).no_integer.map(|(row, _)| row);
        assert_eq!(
            (first(4095.0), first(4096.0), first(-2049.0), first(1.5)),
            (None, Some(1), Some(1), Some(1))
        );
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
