use std::fs;
use std::path::Path;

use crate::{Run, bless, fixture, run, run_in};

/// Every document of a folder of `fixtures` (`name.json`) brings its message and exit code (`name.txt`), and
/// nothing on standard output. With BLESS=1 in the environment the messages are written anew. Gives the
/// number of documents.
pub fn faults(folder: &str, program: &str) -> usize {
    let folder = fixture(folder);
    let entries = fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let names = entries.map(|entry| entry.expect("an entry").file_name().into_string().expect("UTF-8"));
    let mut names: Vec<String> =
        names.filter_map(|name| name.strip_suffix(".json").map(str::to_string)).collect();
    names.sort();
    let runs = names.iter().map(|name| {
        let document = fs::read_to_string(folder.join(format!("{name}.json"))).expect("readable");
        (name.as_str(), run(program, &[], &document))
    });
    as_expected(&folder, runs);
    names.len()
}

/// Each of these runs failed with its message and exit code (`name.txt` in a folder), and wrote nothing.
fn as_expected<'a>(messages: &Path, runs: impl Iterator<Item = (&'a str, Run)>) {
    let mut wrong = Vec::new();
    for (name, run) in runs {
        let said = run.message();
        let expected = messages.join(format!("{name}.txt"));
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
pub fn faults_in<'a>(
    folder: &Path,
    messages: &str,
    program: &str,
    (tables, lines): (&'a [&'a str], &'a [(&'a str, &'a [&'a str])]),
) {
    let tables =
        tables.iter().map(|name| (*name, run_in(program, folder, &["stream", &format!("{name}.csv")])));
    let lines = lines.iter().map(|(name, words)| (*name, run_in(program, folder, words)));
    as_expected(&fixture(messages), tables.chain(lines));
}

/// Each of these command lines, run in a folder, is refused with what stands below it (`\n` is the end of a line): exit
/// code 2, nothing on standard output, and no file more. Gives the number of command lines.
pub fn refusals(program: &str, folder: &Path, faults: &str) -> usize {
    let files = || fs::read_dir(folder).expect("a folder").count();
    let (before, lines) = (files(), faults.trim().lines().collect::<Vec<&str>>());
    for fault in lines.chunks_exact(2) {
        let (asked, message) = (fault[0], fault[1].trim().replace("\\n", "\n"));
        let run = run_in(program, folder, &asked.split(' ').collect::<Vec<&str>>());
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{asked}: {}", run.stderr);
        assert!(run.stderr.contains(&message), "{asked}: {}", run.stderr);
        assert_eq!(files(), before, "{asked}");
    }
    lines.len() / 2
}
