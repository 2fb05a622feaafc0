//! The example in each help text runs as it stands, and the README shows what is said.

use std::env;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

const DIFFMAG: &str = env!("CARGO_BIN_EXE_diffmag");

#[test]
fn examples_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let fixtures = testkit::fixture("").canonicalize().expect("fixtures");
    symlink(fixtures, folder.path().join("fixtures")).expect("a link");
    let programs = Path::new(DIFFMAG).parent().expect("a folder");
    let path = format!("{}:{}", programs.display(), env::var("PATH").expect("a path"));
    for command in [&["--help"][..], &["stream", "--help"], &["merge", "--help"]] {
        let help = testkit::run(DIFFMAG, command, "").stdout;
        let (_, example) = help.split_once("Example:\n").unwrap_or_else(|| panic!("{command:?}: {help}"));
        let example: Vec<&str> = example.lines().take_while(|line| line.starts_with("  diffmag")).collect();
        assert!(!example.is_empty(), "{help}");
        let run = Command::new("sh")
            .args(["-e", "-c", &example.join("\n")])
            .current_dir(folder.path())
            .env("PATH", &path)
            .output()
            .expect("a shell");
        assert!(run.status.success(), "{example:?}: {}", String::from_utf8_lossy(&run.stderr));
        let result = fs::read_to_string(folder.path().join("result.json")).expect("a result");
        let result: serde_json::Value = serde_json::from_str(&result).expect("JSON");
        assert_eq!(result["calibration"]["differential"]["matrix"].as_array().map(Vec::len), Some(3));
    }
}

#[test]
fn the_answer_that_the_readme_shows() {
    let readme = fs::read_to_string(testkit::fixture("../README.md")).expect("a page");
    let (_, shown) = readme.split_once("fixtures/diffmag/turned-pair/input.json").expect("the command");
    let (_, shown) = shown.split_once("```text\n").expect("what it says");
    let (shown, _) = shown.split_once("```").expect("the end");
    let said = testkit::run(DIFFMAG, &[], &testkit::read_fixture("diffmag/turned-pair/input.json")).stderr;
    for line in shown.lines().filter(|line| line.trim() != "…") {
        assert!(said.contains(line), "{line}\n{said}");
    }
}
