//! The example in the help text runs as it stands.

use std::env;
use std::path::Path;
use std::process::Command;

const BLIND: &str = env!("CARGO_BIN_EXE_blind");

#[test]
fn the_example_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let programs = Path::new(BLIND).parent().expect("a folder");
    let path = format!("{}:{}", programs.display(), env::var("PATH").expect("a path"));
    let help = testkit::run(BLIND, &["--help"], "").stdout;
    let (_, example) = help.split_once("Example:\n").expect("an example");
    let example = example.lines().next().expect("a line").trim();
    let run = Command::new("sh")
        .args(["-e", "-c", example])
        .current_dir(folder.path())
        .env("PATH", &path)
        .output()
        .expect("a shell");
    assert!(run.status.success(), "{example}: {}", String::from_utf8_lossy(&run.stderr));
    let commitment = std::fs::read_to_string(folder.path().join("commitment.txt")).expect("a commitment");
    assert_eq!(commitment.trim().len(), 64);
    assert_eq!(std::fs::read_dir(folder.path().join("sealed/documents")).expect("documents").count(), 3);
}
