//! The records of a file: the descriptors of file, attributes and variables, each a list that leads from one
//! to the next.

use super::bytes::{Bytes, Compression};
use super::variable::Layout;
use super::{Cdf, Error, ValueType, Values, Variable};

/// Records of a list that are read at most.
const MOST: usize = 1 << 16;

/// What holds for the whole file.
struct File<'a> {
    bytes: &'a Bytes<'a>,
    /// Least significant byte first.
    little: bool,
    /// Dimensions of r variables.
    dimensions: Vec<usize>,
}

pub fn read(bytes: &Bytes<'_>) -> Result<Cdf, Error> {
    let mut cdr = bytes.record(8, &[1])?;
    let gdr_at = cdr.offset()?;
    cdr.take(8)?;
    let (encoding, flags) = (cdr.u32()?, cdr.u32()?);
    let little = match encoding {
        1 | 2 | 5 | 7 | 9 | 11 | 12 | 18 => false,
        4 | 6 | 13 | 16 | 17 => true,
        other => {
            return Err(Error(format!(
                "a CDF with the encoding {other} (VAX or unknown); convert it with NASA's cdfconvert"
            )));
        }
    };
    // Bit 1: all in one file.
    if flags & 2 == 0 {
        return Err(Error("a CDF in several files; make it one with NASA's cdfconvert".into()));
    }
    let mut gdr = bytes.record(gdr_at, &[2])?;
    let [r_variables, z_variables, attributes] = [gdr.offset()?, gdr.offset()?, gdr.offset()?];
    gdr.take(8 + 4 + 4 + 4)?;
    let dimensions = gdr.u32()? as usize;
    gdr.take(4 + 8 + 4 + 4 + 4)?;
    let dimensions = sizes(&mut gdr, dimensions)?;
    let file = File { bytes, little, dimensions };
    let mut variables = Vec::new();
    let mut numbers = Vec::new();
    for (head, kind) in [(r_variables, 3), (z_variables, 8)] {
        each(head, |at| {
            let (next, number, variable) = file.variable(at, kind)?;
            numbers.push((kind, number));
            variables.push(variable);
            Ok(next)
        })?;
    }
    let mut cdf = Cdf { attributes: Vec::new(), variables };
    each(attributes, |at| file.attribute(at, &mut cdf, &numbers))?;
    Ok(cdf)
}

/// Goes through a list; `read` gives the next record's place, 0 at the end.
fn each(mut at: u64, mut read: impl FnMut(u64) -> Result<u64, Error>) -> Result<(), Error> {
    for _ in 0..MOST {
        if at == 0 {
            return Ok(());
        }
        at = read(at)?;
    }
    Err(Error("a broken CDF: a list that does not end".into()))
}

fn sizes(record: &mut super::bytes::Record<'_>, count: usize) -> Result<Vec<usize>, Error> {
    if count > 10 {
        return Err(Error(format!("a broken CDF: {count} dimensions")));
    }
    (0..count).map(|_| record.u32().map(|size| size as usize)).collect()
}

/// What a compression record (CPR) says.
pub fn compression(bytes: &Bytes<'_>, at: u64) -> Result<Option<Compression>, Error> {
    match bytes.record(at, &[11])?.u32()? {
        0 => Ok(None),
        1 => Ok(Some(Compression::Runs)),
        5 => Ok(Some(Compression::Gzip)),
        _ => Err(Error("a CDF compressed by Huffman codes; convert it with NASA's cdfconvert".into())),
    }
}

impl File<'_> {
    /// A variable (VDR), its number, and the place of the next one.
    fn variable(&self, at: u64, record_kind: u32) -> Result<(u64, u32, Variable), Error> {
        let mut vdr = self.bytes.record(at, &[record_kind])?;
        let next = vdr.offset()?;
        let kind = ValueType::of(vdr.u32()?)?;
        let records = usize::try_from(i64::from(vdr.u32()? as i32) + 1).unwrap_or(0);
        let index = vdr.offset()?;
        vdr.offset()?;
        let (flags, sparse) = (vdr.u32()?, vdr.u32()?);
        vdr.take(12)?;
        let (elements, number) = (vdr.u32()? as usize, vdr.u32()?);
        let compression_at = vdr.offset()?;
        vdr.take(4)?;
        let name = vdr.name()?;
        let all = if record_kind == 8 {
            let count = vdr.u32()? as usize;
            sizes(&mut vdr, count)?
        } else {
            self.dimensions.clone()
        };
        let mut dimensions = Vec::new();
        for size in all {
            // A dimension that does not vary is stored once.
            if vdr.u32()? != 0 {
                dimensions.push(size);
            }
        }
        let each =
            dimensions.iter().try_fold(kind.bytes() * elements.max(1), |sum, size| sum.checked_mul(*size));
        let record = each.filter(|bytes| (1..1 << 31).contains(bytes));
        let record =
            record.ok_or_else(|| Error(format!("a broken CDF: records of {name:?} have no size")))?;
        let compressed = flags & 4 != 0 && compression_at != 0;
        let compression = if compressed { compression(self.bytes, compression_at)? } else { None };
        let layout = Layout { record, records, compression, repeats: sparse == 2, index };
        let (bytes, there) = layout.read(self.bytes)?;
        let mut values = kind.read(&bytes, elements, self.little);
        clear(&mut values, &there);
        let varies = flags & 1 != 0;
        Ok((next, number, Variable { name, dimensions, varies, attributes: Vec::new(), values }))
    }

    /// An attribute (ADR) with its entries: to the file or to variables. The place of the next one.
    fn attribute(&self, at: u64, cdf: &mut Cdf, numbers: &[(u32, u32)]) -> Result<u64, Error> {
        let mut adr = self.bytes.record(at, &[4])?;
        let next = adr.offset()?;
        let r_entries = adr.offset()?;
        let is_global = matches!(adr.u32()?, 1 | 3);
        adr.take(16)?;
        let z_entries = adr.offset()?;
        adr.take(12)?;
        let name = adr.name()?;
        let mut global = Vec::new();
        for (head, entry_kind, variable_kind) in [(r_entries, 5, 3), (z_entries, 9, 8)] {
            each(head, |at| {
                let mut entry = self.bytes.record(at, &[entry_kind])?;
                let next = entry.offset()?;
                entry.take(4)?;
                let (kind, number, elements) =
                    (ValueType::of(entry.u32()?)?, entry.u32()?, entry.u32()? as usize);
                entry.take(20)?;
                let size = elements
                    .checked_mul(kind.bytes())
                    .ok_or_else(|| Error("a broken CDF: an attribute without a size".into()))?;
                let values = kind.read(entry.take(size)?, elements, self.little);
                if is_global {
                    global.push(values);
                } else if let Some(place) = numbers.iter().position(|known| *known == (variable_kind, number))
                {
                    cdf.variables[place].attributes.push((name.clone(), values));
                }
                Ok(next)
            })?;
        }
        if is_global {
            cdf.attributes.push((name, global));
        }
        Ok(next)
    }
}

/// Makes values of absent records missing.
fn clear(values: &mut Values, there: &[bool]) {
    if there.iter().all(|there| *there) {
        return;
    }
    let width = values.len() / there.len().max(1);
    for absent in (0..there.len()).filter(|record| !there[*record]) {
        let range = absent * width..(absent + 1) * width;
        match values {
            Values::Numbers(values) => values[range].fill(f64::NAN),
            Values::Moments(values) => values[range].fill(None),
            Values::Texts(values) => values[range].fill(String::new()),
        }
    }
}
