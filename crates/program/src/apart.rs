//! What is written is not what is read: a file that is both would be lost.

use common::Error;
use std::fs;
use std::path::Path;

/// Refuses an output that is one of the inputs, by whatever name. `-` and files that are not there yet are none.
///
/// # Errors
///
/// The output and the input that are one file.
pub fn check<'a>(
    outputs: impl IntoIterator<Item = &'a Path>,
    inputs: impl IntoIterator<Item = &'a Path> + Clone,
) -> Result<(), Error> {
    for output in outputs {
        if let Some(input) = inputs.clone().into_iter().find(|input| same(output, input)) {
            return Err(Error::Request(format!(
                "{}: is also read, as {}; name another file to write to, so that what was read is not lost",
                output.display(),
                input.display()
            )));
        }
    }
    Ok(())
}

/// Whether two names lead to one file.
#[cfg(unix)]
fn same(one: &Path, other: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |path| fs::metadata(path).ok().filter(fs::Metadata::is_file).map(|m| (m.dev(), m.ino()));
    place(one).is_some_and(|found| place(other) == Some(found))
}

/// Whether two names lead to one file.
#[cfg(not(unix))]
fn same(one: &Path, other: &Path) -> bool {
    fs::canonicalize(one).is_ok_and(|found| fs::canonicalize(other).is_ok_and(|other| other == found))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_by_another_name_is_the_same() {
        let folder = tempfile::tempdir().expect("a folder");
        let (file, link) = (folder.path().join("a.csv"), folder.path().join("link.csv"));
        fs::write(&file, "time_s\n").expect("written");
        fs::hard_link(&file, &link).expect("linked");
        let other = folder.path().join("b.csv");
        let said = check([link.as_path()], [other.as_path(), &file]).expect_err("refused").to_string();
        assert!(said.contains("link.csv: is also read, as") && said.contains("a.csv"), "{said}");
        assert!(check([other.as_path()], [file.as_path()]).is_ok());
        assert!(check([Path::new("/dev/null")], [Path::new("/dev/null")]).is_ok());
    }
}
