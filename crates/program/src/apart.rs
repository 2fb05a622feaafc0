//! What is written is not what is read: a file that is both would be lost.

use common::Error;
use std::fs;
use std::path::Path;

use crate::sink::named;

/// Refuses an output that is one of the inputs, by whatever name. `-` and files that are not there yet are
/// none.
///
/// # Errors
///
/// The output and the input that are one file.
pub fn check<'a>(
    outputs: impl IntoIterator<Item = &'a Path>,
    inputs: impl IntoIterator<Item = &'a Path> + Clone,
) -> Result<(), Error> {
    for output in outputs.into_iter().filter(|output| named(Some(output)).is_some()) {
        if let Some(input) =
            inputs.clone().into_iter().find(|input| named(Some(input)).is_some() && same(output, input))
        {
            return Err(Error::Request(format!(
                "{}: is also read, as {}; name another file to write to, so that what was read is not lost",
                output.display(),
                input.display()
            )));
        }
    }
    Ok(())
}

/// Refuses what is written besides the document, by the option of that name, to where the document goes.
///
/// # Errors
///
/// The option and the place.
pub fn from_document(option: &str, other: Option<&Path>, document: Option<&Path>) -> Result<(), Error> {
    let real = |path: &Path| fs::canonicalize(path).or_else(|_| std::path::absolute(path)).ok();
    let place = |path: Option<&Path>| named(path).and_then(real);
    if other.is_none() || place(other) != place(document) {
        return Ok(());
    }
    let shown = named(document).map_or("standard output".into(), |path| path.display().to_string());
    Err(Error::Request(format!(
        "{option} and the document both go to {shown}; name another file for one of them"
    )))
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
