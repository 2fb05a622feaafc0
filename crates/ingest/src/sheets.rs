//! Sheets of absolute measurements: the circles of a theodolite with a magnetometer on its telescope, and the mark.
//!
//! Each measurement becomes a recording of its own, of the procedure `absolute`: sheets are not pieces of one series.
//! `magpy` and `service` read formats, `row` says what a reading is and whether a measurement is whole, `faces` tells
//! what MagPy's sheets leave open, `recordings` makes recordings.

mod faces;
mod magpy;
mod recordings;
mod row;
mod service;

pub use recordings::add;

use common::Extra;
use tables::{Content, Place};

use crate::Error;
use crate::text::Source;
use row::Row;

/// The condition that names the theodolite.
const THEODOLITE: &str = "theodolite_name";

pub struct Sheet {
    pub file: String,
    pub sha256: String,
    pub format: &'static str,
    pub conditions: Extra,
    /// What else the file says, kept under `source`.
    pub kept: Extra,
    pub rows: Vec<Row>,
    pub notes: Vec<String>,
}

impl Sheet {
    fn of(source: &Source, format: &'static str) -> Self {
        let (file, sha256, rows, notes) = (source.name.clone(), source.sha256(), Vec::new(), Vec::new());
        Sheet { file, sha256, format, conditions: Extra::new(), kept: Extra::new(), rows, notes }
    }
}

/// The measurements of a file; None for a file of another format. Errors: what a measurement lacks, and what
/// is not read, with its line; AutoDIF's own files.
pub fn read(source: &Source) -> Result<Option<Vec<Sheet>>, Error> {
    let head = source.bytes.get(..source.bytes.len().min(300)).unwrap_or_default();
    let is_autodif = memchr::memmem::find(head, b"TARGET AZ").is_some();
    match source.kind {
        Content::Delimited if magpy::is_meant(&source.bytes) => Ok(Some(vec![magpy::read(source)?])),
        Content::NdJson if service::is_meant(&source.bytes) => service::read(source).map(Some),
        Content::Delimited if is_autodif => {
            let expected = "MagPy's sheet of each measurement, or a table with the columns horizontal_deg, vertical_deg, residual_nt";
            Err(source.fault(Place::Whole, "AutoDIF's own file, which is not read", expected))
        }
        _ => Ok(None),
    }
}
