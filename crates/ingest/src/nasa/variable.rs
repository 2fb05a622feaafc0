//! Variables and their records.

use super::bytes::{Bytes, Compression, inflate};
use super::{Error, Values};

/// Bytes of a variable that are read at most.
const MOST: usize = 1 << 32;
/// Records of an index that are followed at most, so that one that leads back to itself ends.
const MOST_RECORDS: usize = 1 << 20;

#[derive(Clone, Debug)]
pub struct Variable {
    pub name: String,
    /// Sizes of a record's dimensions; empty for one value a record.
    pub dimensions: Vec<usize>,
    /// Whether it has a value for each record, or one for all.
    pub varies: bool,
    pub attributes: Vec<(String, Values)>,
    /// Values, record after record; where sparse records are absent, NaN, no moment, or an empty text.
    pub values: Values,
}

impl Variable {
    pub fn attribute(&self, name: &str) -> Option<&Values> {
        self.attributes.iter().find(|(known, _)| known == name).map(|(_, values)| values)
    }

    pub fn text(&self, name: &str) -> Option<String> {
        self.attribute(name).and_then(Values::text)
    }

    pub fn width(&self) -> usize {
        self.dimensions.iter().product()
    }
}

/// Where the values of a variable are, and how.
pub struct Layout {
    /// Bytes of a record.
    pub record: usize,
    pub records: usize,
    pub compression: Option<Compression>,
    /// Absent records repeat the one before them.
    pub repeats: bool,
    /// The first record of the index.
    pub index: u64,
}

impl Layout {
    /// The bytes of all records, and which of them are there.
    pub fn read(&self, bytes: &Bytes<'_>) -> Result<(Vec<u8>, Vec<bool>), Error> {
        let size = self.record.checked_mul(self.records).filter(|size| *size <= MOST);
        // Compression reaches a factor of a thousand; what claims more is broken.
        let size = size.filter(|size| *size / 2048 <= bytes.0.len());
        let size = size.ok_or_else(|| {
            let (records, record, file) = (self.records, self.record, bytes.0.len());
            Error(format!("a broken CDF: {records} records of {record} bytes in a file of {file}"))
        })?;
        let (mut all, mut there) = (vec![0; size], vec![false; self.records]);
        let mut followed = 0;
        self.follow(bytes, self.index, &mut followed, &mut |first, block| {
            let count = (block.len() / self.record).min(self.records.saturating_sub(first));
            let (from, size) = (first * self.record, count * self.record);
            all[from..from + size].copy_from_slice(&block[..size]);
            there[first..first + count].fill(true);
        })?;
        if self.repeats {
            for record in 1..self.records {
                if !there[record] && there[record - 1] {
                    all.copy_within((record - 1) * self.record..record * self.record, record * self.record);
                    there[record] = true;
                }
            }
        }
        Ok((all, there))
    }

    /// Goes through an index (VXR) and the blocks that it names.
    fn follow(
        &self,
        bytes: &Bytes<'_>,
        mut at: u64,
        followed: &mut usize,
        put: &mut dyn FnMut(usize, &[u8]),
    ) -> Result<(), Error> {
        while at != 0 {
            let mut index = bytes.record(at, &[6])?;
            at = index.offset()?;
            let entries = index.count(16)?;
            let used = (index.u32()? as usize).min(entries);
            let mut list = |_| (0..entries).map(|_| index.u32()).collect::<Result<Vec<u32>, Error>>();
            let (first, last) = (list(0)?, list(1)?);
            for entry in 0..entries {
                let block_at = index.offset()?;
                *followed += 1;
                if *followed > MOST_RECORDS {
                    return Err(Error("a broken CDF: an index that does not end".into()));
                }
                if entry >= used {
                    continue;
                }
                let mut block = bytes.record(block_at, &[6, 7, 13])?;
                if block.kind == 6 {
                    self.follow(bytes, block_at, followed, put)?;
                    continue;
                }
                let (first, last) = (first[entry] as usize, last[entry] as usize);
                let count = (last + 1).checked_sub(first).filter(|count| last < self.records && *count > 0);
                let count = count.ok_or_else(|| {
                    Error(format!("a broken CDF: records {first} to {last} of {}", self.records))
                })?;
                let compressed = block.kind == 13;
                if compressed {
                    block.take(4)?;
                    block.u64()?;
                }
                let packed = self.compression.filter(|_| compressed);
                put(first, &inflate(block.left, packed, count * self.record)?);
            }
        }
        Ok(())
    }
}
