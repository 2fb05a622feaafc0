//! Programs under test: what they do, their help, their examples.

use common::Document;
use serde_json::{Value, json};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

use crate::fixture;

/// What a program did.
#[derive(Debug)]
pub struct Run {
    /// Its exit code.
    pub code: i32,
    /// What it wrote to standard output.
    pub stdout: String,
    /// What it said on standard error.
    pub stderr: String,
}

/// Runs a program (`env!("CARGO_BIN_EXE_…")`) with `input` on standard input.
pub fn run(program: &str, arguments: &[&str], input: &str) -> Run {
    let mut child = Command::new(program)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap_or_else(|error| panic!("{program}: {error}"));
    let mut stdin = child.stdin.take().expect("piped");
    let input = input.to_string();
    // A program that refuses its arguments ends without reading: then the pipe is closed, and that is no
    // error here.
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()).is_ok());
    let output = child.wait_with_output().expect("the program ended");
    writer.join().expect("the writer ended");
    Run::of(output)
}

/// Runs a program in a folder, so that files are named in messages as they are there.
pub fn run_in(program: &str, folder: &Path, arguments: &[&str]) -> Run {
    let output = Command::new(program).args(arguments).current_dir(folder).output();
    Run::of(output.unwrap_or_else(|error| panic!("{program}: {error}")))
}

/// The document that programs make of another, one after the other; `beside` is a program in whose folder
/// they are.
pub fn stages(beside: &str, programs: &[&str], document: &Document) -> Document {
    let folder = Path::new(beside).parent().expect("a folder");
    programs.iter().fold(document.clone(), |document, program| {
        let program = folder.join(program);
        let run = run(program.to_str().expect("UTF-8"), &["-q"], &common::to_text(&document));
        assert!(run.code == 0, "{}", run.stderr);
        Document::parse(&run.stdout).expect("a document")
    })
}

impl Run {
    fn of(output: Output) -> Self {
        Run {
            code: output.status.code().expect("an exit code"),
            stdout: String::from_utf8(output.stdout).expect("UTF-8"),
            stderr: String::from_utf8(output.stderr).expect("UTF-8"),
        }
    }

    /// Exit code and what was said, as messages are kept beside bad files.
    pub fn message(&self) -> String {
        format!("exit code {}\n{}", self.code, self.stderr)
    }
}

/// Runs the examples in the help text of a program, and of each of its subcommands, as they stand, in an
/// empty folder where only the fixtures are; they find the workspace's programs beside it. Gives the folder
/// with what they wrote.
#[cfg(unix)]
pub fn examples(program: &str, subcommands: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let fixtures = fixture("").canonicalize().expect("fixtures");
    std::os::unix::fs::symlink(fixtures, folder.path().join("fixtures")).expect("a link");
    let programs = Path::new(program).parent().expect("a folder");
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").expect("a path"));
    let own = [vec!["--help"]];
    for arguments in own.into_iter().chain(subcommands.iter().map(|name| vec![*name, "--help"])) {
        let help = run(program, &arguments, "").stdout;
        let below = help.lines().skip_while(|line| !line.starts_with("Example")).skip(1);
        let example: Vec<&str> = below.take_while(|line| line.starts_with("  ")).collect();
        assert!(!example.is_empty(), "{arguments:?}: {help}");
        let mut shell = Command::new("bash");
        shell.args(["-e", "-o", "pipefail", "-c", &example.join("\n")]).current_dir(folder.path());
        let done = Run::of(shell.env("PATH", &path).output().expect("a shell"));
        assert_eq!(done.code, 0, "{example:?} (are all programs of the workspace built?): {}", done.stderr);
    }
    folder
}

/// A program prints completions and writes man pages; its help begins with what it does and an example.
pub fn manual(program: &str) {
    let name = Path::new(program).file_name().and_then(|name| name.to_str()).expect("a name");
    let help = run(program, &["--help"], "").stdout;
    let mut lines = help.lines().skip(1);
    let below = (lines.next(), lines.next().map(|line| line.starts_with("Example")));
    assert_eq!(below, (Some(""), Some(true)), "one line on what it does, then an example: {help}");
    for (shell, option) in [("bash", "--man"), ("zsh", "--man"), ("fish", "-l man")] {
        let completions = run(program, &["--completions", shell], "");
        assert_eq!(completions.code, 0, "{}", completions.stderr);
        assert!(completions.stdout.contains(name) && completions.stdout.contains(option), "{shell}");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let done = run_in(program, folder.path(), &["--man", "pages"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let page = fs::read_to_string(folder.path().join(format!("pages/{name}.1"))).expect("a page");
    assert!(page.contains(".SH NAME") && page.contains(".SH EXAMPLE"), "{page}");
    assert_eq!(run(program, &["--completions", "sh"], "").code, 2);
}

/// A stage finds in a document whose recordings keep their readings in files beside it what it finds in the
/// document that holds them (a fixture), and leaves the files alone.
pub fn beside(program: &str, input: &str) {
    let mut document: Value = serde_json::from_str(&crate::read_fixture(input)).expect("JSON");
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("data")).expect("a folder");
    let recordings = document["recordings"].as_array_mut().expect("recordings");
    for (number, recording) in recordings.iter_mut().enumerate() {
        let recording = recording.as_object_mut().expect("an object");
        let columns = recording.remove("columns").expect("columns");
        let columns = columns.as_object().expect("an object");
        let rows = columns.values().map(|column| column.as_array().map_or(0, Vec::len)).max().unwrap_or(0);
        let names: Vec<&str> = columns.keys().map(String::as_str).collect();
        let mut text = names.join(",") + "\n";
        for row in 0..rows {
            let cell =
                |column: &Value| if column[row].is_null() { String::new() } else { column[row].to_string() };
            text += &(columns.values().map(cell).collect::<Vec<_>>().join(",") + "\n");
        }
        let table = format!("data/{number}.csv");
        fs::write(folder.path().join(&table), text).expect("written");
        recording.insert("table".into(), table.into());
        recording.entry("conditions").or_insert_with(|| json!({}));
    }
    fs::write(folder.path().join("campaign.json"), document.to_string()).expect("written");
    let whole = fixture(input).canonicalize().expect("a fixture");
    let read = |input: &str| -> Value {
        let run = run_in(program, folder.path(), &["-q", input]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        serde_json::from_str(&run.stdout).expect("JSON")
    };
    let (apart, together) = (read("campaign.json"), read(whole.to_str().expect("UTF-8")));
    assert_eq!(apart["recordings"], document["recordings"]);
    for part in ["calibration", "model", "diagnosis"] {
        assert_eq!(apart[part], together[part], "{part}");
    }
}
