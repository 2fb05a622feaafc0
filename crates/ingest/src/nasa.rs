//! NASA's Common Data Format, version 3 (CDF Internal Format Description, NASA GSFC, version 3.9): variables
//! with their numbers, attributes, and times as nanoseconds since 1970 in UTC. Single files, uncompressed or
//! compressed by GZIP or run lengths, as a whole or variable by variable; r and z variables; sparse records.
//! Not read: versions before 3, VAX floating point, Huffman compression.

mod bytes;
mod records;
mod times;
mod values;
mod variable;

use std::borrow::Cow;
use thiserror::Error;

use bytes::{Bytes, inflate};

pub use times::{LAST_LEAP, tt2000};
pub use values::{ValueType, Values};
pub use variable::Variable;

#[derive(Debug, Error, PartialEq, Eq)]
#[error("{0}")]
pub struct Error(pub(crate) String);

#[derive(Debug, Default)]
pub struct Cdf {
    /// Attributes of the file by name, with their entries.
    pub attributes: Vec<(String, Vec<Values>)>,
    pub variables: Vec<Variable>,
}

/// Whether bytes begin as a CDF of any version.
pub fn is_cdf(bytes: &[u8]) -> bool {
    matches!(
        bytes,
        [0xCD, 0xF3, 0x00, 0x01, ..]
            | [0xCD, 0xF2, 0x60, 0x02, ..]
            | [0x00, 0x00, 0xFF, 0xFF, 0x00, 0x00, 0xFF, 0xFF, ..]
    )
}

impl Cdf {
    /// Reads a file's bytes. Errors: what is not read, or is broken, with the record.
    pub fn parse(file: &[u8]) -> Result<Self, Error> {
        let bytes = match file {
            [0xCD, 0xF3, 0x00, 0x01, 0x00, 0x00, 0xFF, 0xFF, ..] => Cow::Borrowed(file),
            [0xCD, 0xF3, 0x00, 0x01, 0xCC, 0xCC, 0x00, 0x01, ..] => Cow::Owned(whole(file)?),
            _ if is_cdf(file) => {
                return Err(Error("a CDF of a version before 3.0; convert it with NASA's cdfconvert".into()));
            }
            _ => return Err(Error("no CDF".into())),
        };
        records::read(&Bytes(&bytes))
    }

    /// The first entry of an attribute of the file, as text.
    pub fn text(&self, name: &str) -> Option<String> {
        let (_, entries) = self.attributes.iter().find(|(known, _)| known == name)?;
        entries.first()?.text()
    }
}

/// A file that is compressed as a whole: its records as if it were not.
fn whole(file: &[u8]) -> Result<Vec<u8>, Error> {
    const MOST: u64 = 1 << 32;
    let bytes = Bytes(file);
    let mut ccr = bytes.record(8, &[10])?;
    let (cpr, size) = (ccr.offset()?, ccr.u64()?);
    ccr.take(4)?;
    if size > MOST {
        return Err(Error(format!("{size} bytes compressed; at most {MOST} are read")));
    }
    let mut plain = file[..4].to_vec();
    plain.extend([0x00, 0x00, 0xFF, 0xFF]);
    plain.extend(inflate(ccr.left, records::compression(&bytes, cpr)?, size as usize)?);
    Ok(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fixture(name: &str) -> Vec<u8> {
        std::fs::read(format!("{}/../../fixtures/ingest/{name}", env!("CARGO_MANIFEST_DIR"))).expect(name)
    }

    fn variable<'c>(cdf: &'c Cdf, name: &str) -> &'c Variable {
        cdf.variables.iter().find(|variable| variable.name == name).expect(name)
    }

    /// Values of five files, big and little endian, plain, compressed by variable and as a whole, as cdflib
    /// reads them (fixtures/reference/ingest/cdf.py); times over the leap second at the end of 2016.
    #[test]
    fn as_cdflib_reads_them() {
        let expected: serde_json::Value =
            serde_json::from_slice(&fixture("../reference/ingest/cdf.json")).expect("JSON");
        let files = expected["files"].as_object().expect("files");
        let mut count = 0;
        for (name, variables) in files {
            let cdf = Cdf::parse(&fixture(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(Some(cdf.variables.len()), variables.as_object().map(|all| all.len()), "{name}");
            for (name, expected) in variables.as_object().into_iter().flatten() {
                let list = |key: &str| expected[key].as_array().expect(name).iter();
                let due = match &variable(&cdf, name).values {
                    Values::Moments(_) => {
                        Values::Moments(list("ns").map(|ns| Some(ns.as_i64().expect("ns"))).collect())
                    }
                    _ => Values::Numbers(list("values").map(|one| one.as_f64().expect("a number")).collect()),
                };
                assert_eq!(variable(&cdf, name).values, due, "{name}");
                count += due.len();
            }
        }
        assert_eq!(count, 6 + 3 * 30 + 15 + 30 + 15 + 6 + 4 * 12 + 2 * 40 * 6);
        let cdf = Cdf::parse(&fixture("imagcdf-hdz.cdf")).expect("a CDF");
        assert_eq!(cdf.text("IagaCode").as_deref(), Some("FLX"));
        let d = variable(&cdf, "GeomagneticFieldD");
        assert_eq!(d.text("UNITS").as_deref(), Some("Degrees of arc"));
        assert_eq!(d.attribute("FILLVAL").and_then(Values::number), Some(99_999.0));
    }

    #[test]
    fn damage_is_refused_and_never_panics() {
        for name in ["imagcdf.cdf", "mission.cdf", "mission-compressed.cdf"] {
            let whole = fixture(name);
            assert!(Cdf::parse(&whole).is_ok());
            for end in (0..whole.len()).step_by(37) {
                let _ = Cdf::parse(&whole[..end]);
            }
            for at in (8..whole.len()).step_by(13) {
                let mut changed = whole.clone();
                changed[at] ^= 0xFF;
                let _ = Cdf::parse(&changed);
            }
        }
        let old = Cdf::parse(&[0xCD, 0xF2, 0x60, 0x02, 0, 0, 0xFF, 0xFF]).expect_err("version 2");
        assert!(old.to_string().contains("cdfconvert"));
    }
}
