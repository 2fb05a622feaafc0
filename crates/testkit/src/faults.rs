use std::fs;
use std::path::Path;

use crate::{bless, fixture, run, run_in};

/// Every document of a folder of `fixtures` (`name.json`) brings its message and exit code (`name.txt`), and
/// nothing on standard output. With BLESS=1 in the environment the messages are written anew. Gives the
/// number of documents.
pub fn faults(folder: &str, program: &str) -> usize {
    let folder = fixture(folder);
    let mut names: Vec<String> = fs::read_dir(&folder)
        .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
        .map(|entry| entry.expect("an entry").file_name().into_string().expect("UTF-8"))
        .filter_map(|name| name.strip_suffix(".json").map(str::to_string))
        .collect();
    names.sort();
    let mut wrong = Vec::new();
    for name in &names {
        let document = fs::read_to_string(folder.join(format!("{name}.json"))).expect("readable");
        let run = run(program, &[], &document);
        let said = format!("exit code {}\n{}", run.code, run.stderr);
        let expected = folder.join(format!("{name}.txt"));
        if bless() {
            fs::write(&expected, &said).expect("written");
        }
        let expected = fs::read_to_string(&expected).unwrap_or_default();
        if said != expected || !run.stdout.is_empty() || run.code == 0 {
            wrong.push(format!("{name}:\n{said}where this is expected:\n{expected}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    names.len()
}

/// A copy of a folder of `fixtures`, in which programs run so that messages name files as they are there,
/// with a piece (`name.json`) that the program makes of each of these tables (`name.csv`).
pub fn pieces(folder: &str, program: &str, tables: &[&str]) -> tempfile::TempDir {
    let copy = tempfile::tempdir().expect("a folder");
    for entry in fs::read_dir(fixture(folder)).expect("fixtures") {
        let path = entry.expect("an entry").path();
        fs::copy(&path, copy.path().join(path.file_name().expect("a name"))).expect("copied");
    }
    for name in tables {
        let (table, piece) = (format!("{name}.csv"), format!("{name}.json"));
        let run = run_in(program, copy.path(), &["stream", "--partial", &table, "-o", &piece]);
        assert_eq!(run.message(), "exit code 0\n");
    }
    copy
}

/// `stream` of each of these tables (`name.csv`) and each of these command lines, run in a folder, brings its
/// message and exit code (`name.txt` in a folder of `fixtures`), and nothing on standard output. With BLESS=1
/// in the environment the messages are written anew.
pub fn faults_in(
    folder: &Path,
    messages: &str,
    program: &str,
    (tables, lines): (&[&str], &[(&str, &[&str])]),
) {
    let mut wrong = Vec::new();
    let tables: Vec<(&str, String)> = tables.iter().map(|name| (*name, format!("{name}.csv"))).collect();
    let tables = tables.iter().map(|(name, file)| (*name, vec!["stream", file.as_str()]));
    for (name, arguments) in tables.chain(lines.iter().map(|(name, words)| (*name, words.to_vec()))) {
        let run = run_in(program, folder, &arguments);
        let said = run.message();
        let expected = fixture(&format!("{messages}/{name}.txt"));
        if bless() {
            fs::write(&expected, &said).expect("written");
        }
        let expected = fs::read_to_string(&expected).unwrap_or_default();
        if said != expected || !run.stdout.is_empty() || run.code == 0 {
            wrong.push(format!("{name}:\n{said}{}where this is expected:\n{expected}", run.stdout));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
