//! Bytes on their way to standard output, or to a file that is there whole or not at all.

use common::Error;
use program::pipe::named;
use program::progress;
use std::fs::File;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tables::files::{self, Unfinished};

pub struct Out {
    /// The file; None for standard output.
    file: Option<(PathBuf, File, Unfinished)>,
}

impl Out {
    pub fn open(output: Option<&Path>) -> Result<Self, Error> {
        let Some(path) = named(output) else {
            progress::give_way();
            return Ok(Self { file: None });
        };
        let (file, unfinished) =
            files::create(path).map_err(|source| Error::file(path, "written", source))?;
        Ok(Self { file: Some((path.into(), file, unfinished)) })
    }

    /// False: the reader of standard output has gone, which is no error.
    pub fn write(&mut self, bytes: &[u8]) -> Result<bool, Error> {
        if let Some((path, file, _)) = &mut self.file {
            file.write_all(bytes).map_err(|source| Error::file(path.as_path(), "written", source))?;
            return Ok(true);
        }
        let mut stdout = io::stdout().lock();
        match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(false),
            written => {
                written.map(|()| true).map_err(|source| Error::file("standard output", "written", source))
            }
        }
    }

    /// Gives the file its name.
    pub fn finish(self) -> Result<(), Error> {
        let Some((path, _, unfinished)) = self.file else { return Ok(()) };
        unfinished.finish().map_err(|source| Error::file(path, "written", source))
    }
}
