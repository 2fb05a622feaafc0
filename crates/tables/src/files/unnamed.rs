//! Files without a name, which the system removes with the program (`O_TMPFILE` of open(2)).

use std::fs::File;
use std::io;
use std::path::Path;

/// A file in a folder, with the permissions that a new file has; None where there are no such files.
#[cfg(target_os = "linux")]
pub fn create(folder: &Path) -> Option<File> {
    use rustix::fs::{Mode, OFlags};
    let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
    let file = rustix::fs::open(folder, flags, Mode::from_bits_retain(0o666)).ok().map(File::from)?;
    own(&file).exists().then_some(file)
}

/// Gives the file a name that no other has.
#[cfg(target_os = "linux")]
pub fn name(file: &File, name: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD, linkat};
    Ok(linkat(CWD, own(file), CWD, name, AtFlags::SYMLINK_FOLLOW)?)
}

/// Where the system lists it.
#[cfg(target_os = "linux")]
fn own(file: &File) -> std::path::PathBuf {
    use std::os::fd::AsRawFd;
    format!("/proc/self/fd/{}", file.as_raw_fd()).into()
}

#[cfg(not(target_os = "linux"))]
pub fn create(_: &Path) -> Option<File> {
    None
}

#[cfg(not(target_os = "linux"))]
pub fn name(_: &File, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
