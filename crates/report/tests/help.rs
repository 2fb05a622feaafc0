//! The example in the help text runs as it stands.

use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;
use std::{env, fs};

const REPORT: &str = env!("CARGO_BIN_EXE_report");

#[test]
fn the_example_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let fixtures = testkit::fixture("").canonicalize().expect("fixtures");
    symlink(fixtures, folder.path().join("fixtures")).expect("a link");
    let programs = Path::new(REPORT).parent().expect("a folder");
    let path = format!("{}:{}", programs.display(), env::var("PATH").expect("a path"));
    let help = testkit::run(REPORT, &["--help"], "").stdout;
    let (_, example) = help.split_once("Example:\n").expect("an example");
    let example: Vec<&str> = example.lines().take_while(|line| line.starts_with("  ")).collect();
    assert!(example.len() >= 2, "{help}");
    let run = Command::new("sh")
        .args(["-e", "-c", &example.join("\n")])
        .current_dir(folder.path())
        .env("PATH", &path)
        .output()
        .expect("a shell");
    assert!(run.status.success(), "{example:?}: {}", String::from_utf8_lossy(&run.stderr));
    let page = fs::read_to_string(folder.path().join("report.html")).expect("a page");
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
    assert!(String::from_utf8_lossy(&run.stdout).contains("Explained: named effects explain the difference"));
}
