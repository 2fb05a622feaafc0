//! Bytes of a file, read by records; compression.

use flate2::read::GzDecoder;
use std::io::Read;

use super::Error;

pub struct Bytes<'a>(pub &'a [u8]);

/// A record, read from its beginning.
pub struct Record<'a> {
    pub left: &'a [u8],
    pub kind: u32,
    at: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// Runs of zero bytes.
    Runs,
    Gzip,
}

impl<'a> Bytes<'a> {
    /// The record at an offset, which is one of these types.
    pub fn record(&self, at: u64, kinds: &[u32]) -> Result<Record<'a>, Error> {
        let broken = |what: &str| Error(format!("a broken CDF: {what} at byte {at}; was it copied in full?"));
        let from = self.0.get(usize::try_from(at).map_err(|_| broken("no record"))?..);
        let from = from.filter(|from| from.len() >= 12).ok_or_else(|| broken("no record"))?;
        let size = u64::from_be_bytes(from[..8].try_into().map_err(|_| broken("no record"))?);
        let kind = u32::from_be_bytes(from[8..12].try_into().map_err(|_| broken("no record"))?);
        let size = usize::try_from(size).ok().filter(|size| *size >= 12 && *size <= from.len());
        let size = size.ok_or_else(|| broken("a record that goes on beyond the end"))?;
        if !kinds.contains(&kind) {
            return Err(broken(&format!("a record of type {kind} where one of type {kinds:?} is due")));
        }
        Ok(Record { left: &from[12..size], kind, at })
    }
}

impl<'a> Record<'a> {
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], Error> {
        let found = self.left.split_at_checked(count);
        let at = self.at;
        let (taken, left) = found.ok_or_else(|| {
            Error(format!("a broken CDF: the record at byte {at} is too short; was it copied in full?"))
        })?;
        self.left = left;
        Ok(taken)
    }

    pub fn u32(&mut self) -> Result<u32, Error> {
        Ok(self.take(4)?.iter().fold(0, |sum, byte| sum << 8 | u32::from(*byte)))
    }

    pub fn u64(&mut self) -> Result<u64, Error> {
        Ok(self.take(8)?.iter().fold(0, |sum, byte| sum << 8 | u64::from(*byte)))
    }

    /// An offset; 0 and all ones stand for none.
    pub fn offset(&mut self) -> Result<u64, Error> {
        Ok(Some(self.u64()?).filter(|offset| *offset != u64::MAX).unwrap_or(0))
    }

    /// A count of things of so many bytes each, which are in this record.
    pub fn count(&mut self, bytes_each: usize) -> Result<usize, Error> {
        let count = self.u32()? as usize;
        let fits = count.checked_mul(bytes_each).is_some_and(|bytes| bytes <= self.left.len());
        let at = self.at;
        fits.then_some(count).ok_or_else(|| {
            Error(format!(
                "a broken CDF: the record at byte {at} announces {count} entries and is too short for them"
            ))
        })
    }

    /// A name of 256 bytes.
    pub fn name(&mut self) -> Result<String, Error> {
        let bytes = self.take(256)?;
        let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
        Ok(String::from_utf8_lossy(&bytes[..end]).trim_end().to_string())
    }
}

/// Takes compression off; `size` is how many bytes come of it.
pub fn inflate(bytes: &[u8], compression: Option<Compression>, size: usize) -> Result<Vec<u8>, Error> {
    let mut plain = Vec::new();
    match compression {
        None => plain.extend_from_slice(bytes),
        Some(Compression::Gzip) => {
            let read = GzDecoder::new(bytes).take(size as u64 + 1).read_to_end(&mut plain);
            read.map_err(|error| {
                Error(format!("a broken CDF: compressed values that do not unpack ({error})"))
            })?;
        }
        Some(Compression::Runs) => {
            let mut bytes = bytes.iter();
            while let Some(byte) = bytes.next().filter(|_| plain.len() <= size) {
                let run = if *byte == 0 { bytes.next().map_or(1, |more| usize::from(*more) + 1) } else { 1 };
                plain.resize(plain.len() + run, *byte);
            }
        }
    }
    if plain.len() < size || compression.is_some() && plain.len() > size {
        return Err(Error(format!("a broken CDF: {} bytes unpacked where {size} are due", plain.len())));
    }
    plain.truncate(size);
    Ok(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_zeros() {
        assert_eq!(inflate(&[1, 0, 2, 5], Some(Compression::Runs), 5), Ok(vec![1, 0, 0, 0, 5]));
        assert!(inflate(&[0, 255], Some(Compression::Runs), 3).is_err());
        assert!(inflate(&[1, 2], None, 3).is_err());
    }
}
