//! Where text and bytes go: standard output, or a file that is there whole or not at all.

use common::Error;
use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tables::files::{self, Unfinished};

use crate::progress;

/// The file that is named; None for standard output, which is `-` as well.
pub fn named(file: Option<&Path>) -> Option<&Path> {
    file.filter(|path| *path != Path::new("-"))
}

/// Writes text to a file (beside it first, then renamed) or to standard output.
/// A reader that has gone is no error.
pub fn write(output: Option<&Path>, text: &str) -> Result<(), Error> {
    let mut sink = Sink::open(output)?;
    sink.write(text)?;
    sink.finish()
}

/// Where text and bytes go, piece by piece: standard output, a file that appears whole when all is written, or a
/// device.
pub struct Sink {
    /// As it is named in errors.
    path: PathBuf,
    target: Target,
}

enum Target {
    Stdout,
    File(fs::File, Unfinished),
}

impl Sink {
    /// Opens a file, or standard output where none is given or `-`.
    pub fn open(output: Option<&Path>) -> Result<Self, Error> {
        let Some(path) = named(output) else {
            progress::give_way();
            return Ok(Self { path: "standard output".into(), target: Target::Stdout });
        };
        let failed = |source| Error::file(path, "written", source);
        let (file, unfinished) = files::create(path).map_err(failed)?;
        Ok(Self { path: path.into(), target: Target::File(file, unfinished) })
    }

    /// Writes a piece. False: the reader of standard output has gone, which is no error, and no more is
    /// wanted.
    pub fn write(&mut self, piece: impl AsRef<[u8]>) -> Result<bool, Error> {
        let bytes = piece.as_ref();
        let result = match &mut self.target {
            Target::Stdout => {
                let mut stdout = io::stdout().lock();
                stdout.write_all(bytes).and_then(|()| stdout.flush())
            }
            Target::File(file, _) => file.write_all(bytes),
        };
        match (&self.target, result) {
            (_, Ok(())) => Ok(true),
            (Target::Stdout, Err(error)) if error.kind() == ErrorKind::BrokenPipe => Ok(false),
            (_, Err(source)) => Err(Error::file(&self.path, "written", source)),
        }
    }

    /// Gives the file its name.
    pub fn finish(self) -> Result<(), Error> {
        match self.target {
            Target::Stdout => Ok(()),
            Target::File(_, unfinished) => unfinished.finish().map_err(|source| Error::File {
                path: self.path,
                action: "written",
                source,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_whole_or_not_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("out.json");
        write(Some(&path), "{}\n").expect("written");
        assert_eq!(fs::read_to_string(&path).expect("there"), "{}\n");
        let lost = folder.path().join("absent").join("out.json");
        let error = write(Some(&lost), "{}").expect_err("no such folder");
        assert!(error.to_string().contains("cannot be written"), "{error}");
        assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 1);
    }
}
