//! Values as a CDF holds them.

use std::slice::ChunksExact;

use super::Error;
use super::times;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueType {
    /// A whole number of so many bytes.
    Int {
        bytes: usize,
        signed: bool,
    },
    Float,
    Double,
    /// Milliseconds since the year 0, UTC.
    Epoch,
    /// Seconds since the year 0 and picoseconds, UTC.
    Epoch16,
    /// Nanoseconds since J2000, terrestrial time.
    Tt2000,
    Char,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    Numbers(Vec<f64>),
    /// Moments, ns since 1970 in UTC; None for a fill value or before 1972.
    Moments(Vec<Option<i64>>),
    Texts(Vec<String>),
}

impl ValueType {
    pub(super) fn of(number: u32) -> Result<Self, Error> {
        Ok(match number {
            1 | 41 => ValueType::Int { bytes: 1, signed: true },
            2 => ValueType::Int { bytes: 2, signed: true },
            4 => ValueType::Int { bytes: 4, signed: true },
            8 => ValueType::Int { bytes: 8, signed: true },
            11 => ValueType::Int { bytes: 1, signed: false },
            12 => ValueType::Int { bytes: 2, signed: false },
            14 => ValueType::Int { bytes: 4, signed: false },
            21 | 44 => ValueType::Float,
            22 | 45 => ValueType::Double,
            31 => ValueType::Epoch,
            32 => ValueType::Epoch16,
            33 => ValueType::Tt2000,
            51 | 52 => ValueType::Char,
            other => return Err(Error(format!("a broken CDF: values of the unknown type {other}"))),
        })
    }

    pub(super) fn bytes(self) -> usize {
        match self {
            ValueType::Int { bytes, .. } => bytes,
            ValueType::Float => 4,
            ValueType::Double | ValueType::Epoch | ValueType::Tt2000 => 8,
            ValueType::Epoch16 => 16,
            ValueType::Char => 1,
        }
    }

    /// Values of bytes: texts of `elements` characters each, otherwise as many as there are.
    pub(super) fn read(self, bytes: &[u8], elements: usize, little: bool) -> Values {
        let each = self.bytes() * if self == ValueType::Char { elements.max(1) } else { 1 };
        let values = bytes.chunks_exact(each);
        match self {
            ValueType::Char => Values::Texts(values.map(text).collect()),
            ValueType::Epoch => moments(values, |value| times::of_epoch(double(value, little))),
            ValueType::Tt2000 => moments(values, |value| times::of_tt2000(unsigned(value, little) as i64)),
            ValueType::Epoch16 => moments(values, |value| {
                let (seconds, picos) = value.split_at(8);
                times::of_epoch16(double(seconds, little), double(picos, little))
            }),
            ValueType::Double => numbers(values, |value| double(value, little)),
            ValueType::Float => {
                numbers(values, |value| f32::from_bits(unsigned(value, little) as u32).into())
            }
            ValueType::Int { bytes, signed } => numbers(values, |value| {
                let number = unsigned(value, little);
                let unused = 64 - 8 * bytes as u32;
                if signed { ((number << unused) as i64 >> unused) as f64 } else { number as f64 }
            }),
        }
    }
}

fn numbers(values: ChunksExact<'_, u8>, of: impl Fn(&[u8]) -> f64) -> Values {
    Values::Numbers(values.map(of).collect())
}

fn moments(values: ChunksExact<'_, u8>, of: impl Fn(&[u8]) -> Option<i64>) -> Values {
    Values::Moments(values.map(of).collect())
}

impl Values {
    pub fn len(&self) -> usize {
        match self {
            Values::Numbers(values) => values.len(),
            Values::Moments(values) => values.len(),
            Values::Texts(values) => values.len(),
        }
    }

    pub fn text(&self) -> Option<String> {
        match self {
            Values::Numbers(values) => values.first().map(f64::to_string),
            Values::Moments(values) => values.first()?.map(|value| value.to_string()),
            Values::Texts(values) => values.first().cloned(),
        }
    }

    pub fn number(&self) -> Option<f64> {
        match self {
            Values::Numbers(values) => values.first().copied(),
            _ => None,
        }
    }
}

fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).trim_end().to_string()
}

fn unsigned(bytes: &[u8], little: bool) -> u64 {
    let join = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
    if little { bytes.iter().rev().fold(0, join) } else { bytes.iter().fold(0, join) }
}

fn double(bytes: &[u8], little: bool) -> f64 {
    f64::from_bits(unsigned(bytes, little))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_either_order() {
        let [signed, unsigned] = [true, false].map(|signed| ValueType::Int { bytes: 2, signed });
        assert_eq!(signed.read(&[0xFF, 0xFE], 1, false), Values::Numbers(vec![-2.0]));
        assert_eq!(signed.read(&[0xFE, 0xFF], 1, true), Values::Numbers(vec![-2.0]));
        assert_eq!(unsigned.read(&[0xFF, 0xFE, 0, 1], 1, false), Values::Numbers(vec![65_534.0, 1.0]));
        assert_eq!(ValueType::Double.read(&1.5_f64.to_le_bytes(), 1, true), Values::Numbers(vec![1.5]));
        assert_eq!(ValueType::Float.read(&1.5_f32.to_be_bytes(), 1, false), Values::Numbers(vec![1.5]));
        assert_eq!(ValueType::Char.read(b"nT  X   ", 4, false), Values::Texts(vec!["nT".into(), "X".into()]));
    }
}
