//! Files that are there whole or not at all.
//!
//! What is written goes to a file without a name, which gets one when all is written. So nothing is left
//! behind however the program ends, a signal included. Where a file system knows no such files, it goes to a
//! hidden neighbour, which is removed when writing fails, but not when a signal ends the program.

mod unnamed;

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use tempfile::{Builder, TempPath};

/// A file on its way. Dropped, it is gone and the one of before is as it was.
#[derive(Debug)]
pub struct Unfinished {
    written_to: WrittenTo,
}

#[derive(Debug)]
enum WrittenTo {
    /// What is no file: a terminal, a named pipe.
    Device,
    /// A file without a name, and the one that it shall have.
    Unnamed(File, PathBuf),
    /// A hidden neighbour, and the name that it shall have.
    Neighbour(TempPath, PathBuf),
}

/// Opens a file to be written. A link stays a link, and what is no file is written to and not replaced. The
/// permissions are those of the file that is replaced, else those that a new file has.
///
/// # Errors
///
/// Where the folder or the device cannot be written to.
pub fn create(path: &Path) -> io::Result<(File, Unfinished)> {
    let real = fs::canonicalize(path).unwrap_or_else(|_| path.into());
    let existing = fs::metadata(&real).ok();
    if existing.as_ref().is_some_and(|existing| !existing.is_file()) {
        let device = OpenOptions::new().write(true).open(&real)?;
        return Ok((device, Unfinished { written_to: WrittenTo::Device }));
    }
    if !folder(&real).is_dir() {
        let missing = format!("there is no folder {}", folder(&real).display());
        return Err(io::Error::new(io::ErrorKind::NotFound, missing));
    }
    let (file, written_to) = match unnamed::create(folder(&real)) {
        Some(file) => (file.try_clone()?, WrittenTo::Unnamed(file, real)),
        None => {
            let mut builder = neighbours();
            #[cfg(unix)]
            builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
            let (file, neighbour) = builder.tempfile_in(folder(&real))?.into_parts();
            (file, WrittenTo::Neighbour(neighbour, real))
        }
    };
    if let Some(existing) = existing {
        file.set_permissions(existing.permissions())?;
    }
    Ok((file, Unfinished { written_to }))
}

impl Unfinished {
    /// Gives the file its name.
    ///
    /// # Errors
    ///
    /// Where it cannot be named; it is then gone.
    pub fn finish(self) -> io::Result<()> {
        let (neighbour, real) = match self.written_to {
            WrittenTo::Device => return Ok(()),
            WrittenTo::Neighbour(neighbour, real) => (neighbour, real),
            // Only a neighbour can take the place of the file of before.
            WrittenTo::Unnamed(file, real) => {
                let named = neighbours().make_in(folder(&real), |name| unnamed::name(&file, name))?;
                (named.into_temp_path(), real)
            }
        };
        neighbour.persist(real).map_err(|failed| failed.error)
    }
}

fn neighbours() -> Builder<'static, 'static> {
    let mut builder = Builder::new();
    builder.prefix(".").suffix(".part");
    builder
}

fn folder(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn files(folder: &Path) -> usize {
        fs::read_dir(folder).expect("a folder").count()
    }

    #[test]
    fn whole_or_not_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("out.json");
        let (mut file, unfinished) = create(&path).expect("created");
        file.write_all(b"{}").expect("written");
        assert!(!path.exists());
        unfinished.finish().expect("named");
        assert_eq!((fs::read_to_string(&path).expect("there"), files(folder.path())), ("{}".into(), 1));
        let (mut file, unfinished) = create(&path).expect("created");
        file.write_all(b"[").expect("written");
        drop(unfinished);
        assert_eq!((fs::read_to_string(&path).expect("there"), files(folder.path())), ("{}".into(), 1));
        let absent = folder.path().join("absent");
        let said = create(&absent.join("out.json")).expect_err("no folder").to_string();
        assert_eq!(said, format!("there is no folder {}", absent.display()));
    }

    #[cfg(unix)]
    #[test]
    fn links_devices_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().expect("a folder");
        let (path, link) = (folder.path().join("out.json"), folder.path().join("link.json"));
        fs::write(&path, "{}").expect("written");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).expect("set");
        symlink(&path, &link).expect("a link");
        let (mut file, unfinished) = create(&link).expect("created");
        file.write_all(b"[]").expect("written");
        unfinished.finish().expect("named");
        assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
        assert_eq!(fs::read_to_string(&path).expect("there"), "[]");
        assert_eq!(fs::metadata(&path).expect("there").permissions().mode() & 0o777, 0o600);
        create(Path::new("/dev/null")).expect("opened").1.finish().expect("nothing to name");
        assert!(!fs::metadata("/dev/null").expect("there").is_file());
    }
}
