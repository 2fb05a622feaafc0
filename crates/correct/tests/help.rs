//! The example in the help text runs as it stands.

use std::env;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

const CORRECT: &str = env!("CARGO_BIN_EXE_correct");

#[test]
fn the_example_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let fixtures = testkit::fixture("").canonicalize().expect("fixtures");
    symlink(fixtures, folder.path().join("fixtures")).expect("a link");
    let programs = Path::new(CORRECT).parent().expect("a folder");
    let path = format!("{}:{}", programs.display(), env::var("PATH").expect("a path"));
    let help = testkit::run(CORRECT, &["--help"], "").stdout;
    let (_, example) = help.split_once("Example:\n").expect("an example");
    let example: Vec<&str> = example.lines().take_while(|line| line.starts_with("  ")).collect();
    assert_eq!(example.len(), 3, "{help}");
    let run = Command::new("sh")
        .args(["-e", "-c", &example.join("\n")])
        .current_dir(folder.path())
        .env("PATH", &path)
        .output()
        .expect("a shell");
    assert!(run.status.success(), "{example:?}: {}", String::from_utf8_lossy(&run.stderr));
    assert!(folder.path().join("result.json").exists() && folder.path().join("field.parquet").exists());
}
