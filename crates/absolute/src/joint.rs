//! The measurements in the joint uncertainty of the document: what the readings of each leave uncertain, and what all of
//! them have in common.

use common::uncertainty::{Block, Source};
use common::{AbsoluteSet, Document, Error, Uncertainty};
use faer::Mat;
use indexmap::IndexMap;

use crate::sets::Measured;

/// More measurements than this are not listed one by one.
const MOST: usize = 500;
const COMMON: [&str; 2] = ["azimuth of the mark", "scalar magnetometer and difference of the pillars"];

/// Puts the baseline values of all measurements into `calibration.uncertainty`.
/// Errors: a stated uncertainty that none can be.
pub fn put(document: &mut Document, measured: &Measured, written: &[AbsoluteSet]) -> Result<(), Error> {
    if written.len() > MOST {
        return Ok(());
    }
    let mut joint = Uncertainty::of(document)?;
    joint.sources.retain(|source| !COMMON.iter().any(|name| source.name.starts_with(name)));
    // One mark has one azimuth, whatever its measurements.
    let mut common: IndexMap<String, IndexMap<String, f64>> = IndexMap::new();
    for (at, set) in written.iter().enumerate() {
        let Some(own) = set.covariance else { continue };
        let path = |key: &String| format!("calibration.absolute.sets[{at}].baseline.{key}");
        let parameters: Vec<String> = set.baseline.keys().map(path).collect();
        let (readings, found) = &measured.sets[at];
        let units = found.components.units();
        let stated = [readings.azimuth[0].to_degrees(), readings.pillar[0]];
        for ((name, moved), stated) in COMMON.iter().zip(measured.common(at)).zip(stated) {
            let moves = common.entry(format!("{name}, {stated:.4}")).or_default();
            let moved = parameters.iter().zip(moved.iter().zip(units)).filter(|(_, (size, _))| **size != 0.0);
            moves.extend(moved.map(|(path, (size, unit))| (path.clone(), size / unit)));
        }
        let block = Block {
            name: format!("measurement {}", set.recording),
            degrees_of_freedom: measured.freedom,
            parameters,
            covariance: Mat::from_fn(3, 3, |i, j| own[i][j]),
            by: Vec::new(),
        };
        joint.put(block).map_err(|found| {
            Error::document(format!("calibration.absolute.sets[{at}]"), found, "a covariance")
        })?;
    }
    let sources = common.into_iter().filter(|(_, moves)| !moves.is_empty());
    joint.sources.extend(sources.map(|(name, moves)| Source { name, degrees_of_freedom: None, moves }));
    if !joint.sources.is_empty() {
        document.calibration.get_or_insert_default().uncertainty = Some(joint);
    }
    Ok(())
}
