//! The programs under test, as they are shipped.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::Error;

/// All programs that read files.
pub const NAMES: [&str; 12] = [
    "simulate",
    "ingest",
    "series",
    "coilcal",
    "sensorcal",
    "axescal",
    "starcal",
    "diffmag",
    "absolute",
    "diagnose",
    "correct",
    "report",
];

/// Where the programs are.
#[derive(Clone, Debug)]
pub struct Programs {
    folder: PathBuf,
}

impl Programs {
    /// Has cargo build all programs, optimised.
    pub fn build() -> Result<(), Error> {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let built = Command::new(&cargo).args(["build", "--release"]).status();
        match built.map_err(|source| Error::file(&cargo, "run", source))? {
            status if status.success() => Ok(()),
            _ => Err(Error::Request("the programs could not be built; cargo says above why".into())),
        }
    }

    /// In a folder; absent: beside the running program, or above it where that is a test.
    pub fn find(folder: Option<&Path>) -> Result<Self, Error> {
        let folder = match folder {
            Some(folder) => std::path::absolute(folder).map_err(|e| Error::file(folder, "read", e))?,
            None => {
                let own = std::env::current_exe().map_err(|e| Error::file("fuzz", "read", e))?;
                let beside = own.parent().map(Path::to_path_buf).unwrap_or_default();
                if beside.ends_with("deps") { beside.join("..") } else { beside }
            }
        };
        let missing = NAMES.iter().find(|name| !folder.join(name).is_file());
        match missing {
            None => Ok(Self { folder }),
            Some(name) => Err(Error::Request(format!(
                "no program {name} in {}; build all of them (`cargo build` for tests, which `cargo test --workspace` does by \
                 itself, `cargo build --release` for `just fuzz`), or say where they are with --programs",
                folder.display()
            ))),
        }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }
}
