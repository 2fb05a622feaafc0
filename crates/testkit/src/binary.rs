use common::Document;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

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
    /// What a process that has ended did.
    pub(crate) fn of(output: Output) -> Self {
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
