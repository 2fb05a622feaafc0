use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::Error;

/// The path of a table that a document in `document_folder` names. It stays in that folder or below it.
///
/// # Errors
///
/// [`Error::Request`] for an absolute path, for one with `..`, and where a symbolic link leads out of the
/// folder or nowhere; [`Error::File`] where the folder cannot be read.
pub fn beside(document_folder: &Path, relative: &str) -> Result<PathBuf, Error> {
    let refused = |why: &str| {
        Err(Error::Request(format!(
            "table {relative:?} {why}; expected a path relative to the document's folder that stays in it"
        )))
    };
    let path = Path::new(relative);
    for component in path.components() {
        match component {
            Component::Normal(_) | Component::CurDir => {}
            Component::ParentDir => return refused("has .. in it"),
            Component::RootDir | Component::Prefix(_) => return refused("is absolute"),
        }
    }
    if path.file_name().is_none() {
        return refused("names no file");
    }
    if fs::metadata(document_folder.join(path)).is_ok_and(|found| !found.is_file()) {
        return refused("names no regular file");
    }
    let folder = if document_folder.as_os_str().is_empty() { Path::new(".") } else { document_folder };
    let real_folder = fs::canonicalize(folder).map_err(|source| Error::file(folder, "read", source))?;
    let joined = folder.join(path);
    // The deepest part that exists decides: what is below it has no links yet.
    if let Some(part) = joined.ancestors().find(|part| fs::symlink_metadata(part).is_ok()) {
        match fs::canonicalize(part) {
            Ok(real) if real.starts_with(&real_folder) => {}
            Ok(real) => return refused(&format!("leads out of the folder, to {}", real.display())),
            Err(_) => return refused("is a symbolic link that leads nowhere"),
        }
    }
    Ok(joined)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_stays_in_its_folder() {
        let root = tempfile::tempdir().expect("a folder");
        let folder = root.path().join("campaign");
        fs::create_dir_all(folder.join("data")).expect("made");
        fs::write(folder.join("data/day.csv"), "a\n").expect("written");
        fs::write(root.path().join("secret.csv"), "a\n").expect("written");
        for good in ["data/day.csv", "./data/day.csv", "data/new.parquet", "new/new.parquet", "a..b.csv"] {
            assert_eq!(beside(&folder, good).expect(good), folder.join(good));
        }
        assert_eq!(beside(Path::new(""), "x.csv").expect("here"), Path::new("./x.csv"));
        let message = |relative: &str| beside(&folder, relative).expect_err(relative).to_string();
        assert_eq!(
            message("../secret.csv"),
            "table \"../secret.csv\" has .. in it; expected a path relative to the document's folder that stays in it"
        );
        assert!(message("data/../../secret.csv").contains("has .. in it"));
        assert!(message("/etc/passwd").contains("is absolute"));
        assert!(message("").contains("names no file"));
        assert!(message(".").contains("names no file"));
        let error = beside(&root.path().join("absent"), "x.csv").expect_err("no folder").to_string();
        assert!(error.contains("absent: cannot be read"), "{error}");
        #[cfg(unix)]
        {
            use std::os::unix::fs::symlink;
            symlink(root.path().join("secret.csv"), folder.join("out.csv")).expect("a link");
            symlink(root.path(), folder.join("up")).expect("a link");
            symlink(root.path().join("nowhere.csv"), folder.join("lost.csv")).expect("a link");
            symlink(folder.join("data"), folder.join("inside")).expect("a link");
            assert!(message("out.csv").contains("leads out of the folder"));
            assert!(message("up/secret.csv").contains("leads out of the folder"));
            assert!(message("up/absent.csv").contains("leads out of the folder"));
            assert!(message("lost.csv").contains("leads nowhere"));
            assert!(beside(&folder, "inside/day.csv").is_ok());
        }
    }
}
