//! For tests only: golden cases with tolerances, binaries under test, Jacobians against finite differences,
//! shares of intervals that hold, laws that hold whatever was recorded.

use std::path::{Path, PathBuf};

mod coverage;
mod faults;
mod golden;
mod jacobian;
pub mod laws;
mod partials;
mod programs;
pub mod reference;
mod words;

pub use coverage::{agrees, campaigns, number, some};
pub use faults::{faults, faults_in, pieces, refusals};
pub use golden::{bless, golden};
pub use jacobian::check_jacobian;
pub use partials::partials_merge;
pub use programs::{Run, beside, examples, manual, run, run_in, stages};
pub use words::ill_written;

/// A path below the workspace's `fixtures`.
pub fn fixture(relative: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(relative)
}

/// The folder of a set of real recordings, which are not in the repository: below `FLUXCAL_DATA`, else below
/// `../shared/data` beside the repository. Tests that need one are ignored unless they are asked for (`just
/// recordings`).
pub fn recordings(set: &str) -> PathBuf {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var("FLUXCAL_DATA").map_or(beside, PathBuf::from).join(set);
    let path = folder.display();
    assert!(folder.is_dir(), "{path}: no such folder; name the one with the recordings in FLUXCAL_DATA");
    folder
}

/// The text of a fixture.
pub fn read_fixture(relative: &str) -> String {
    let path = fixture(relative);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}
