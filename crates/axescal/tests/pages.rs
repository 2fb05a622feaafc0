//! The commands of README and docs run as they stand.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

/// The ```sh blocks of a page.
fn commands(page: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let mut block: Option<String> = None;
    for line in page.lines() {
        match (&mut block, line.trim()) {
            (None, "```sh") => block = Some(String::new()),
            (Some(text), "```") => {
                blocks.push(std::mem::take(text));
                block = None;
            }
            (Some(text), _) => text.push_str(&format!("{line}\n")),
            _ => {}
        }
    }
    blocks
}

#[test]
fn commands_of_the_pages() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().expect("the workspace");
    let binaries = Path::new(env!("CARGO_BIN_EXE_axescal")).parent().expect("a folder");
    for other in ["simulate", "ingest", "coilcal", "sensorcal", "diffmag", "diagnose", "correct", "report"] {
        assert!(binaries.join(other).exists(), "the binary `{other}` is built by `cargo test --workspace`");
    }
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("target")).expect("a folder");
    symlink(binaries, folder.path().join("target/release")).expect("a link");
    symlink(root.join("fixtures"), folder.path().join("fixtures")).expect("a link");
    let mut run = 0;
    let stages =
        ["simulate", "ingest", "coilcal", "sensorcal", "axescal", "diffmag", "diagnose", "correct", "report"]
            .map(|stage| format!("docs/{stage}.md"));
    for page in ["README.md".to_string(), "docs/document.md".into()].into_iter().chain(stages) {
        for block in commands(&fs::read_to_string(root.join(&page)).expect("a page")) {
            // Building and testing is what runs this test.
            let block = block.replace("cargo build --release && ", "");
            if block.starts_with("cargo ") {
                continue;
            }
            let output = Command::new("sh")
                .args(["-e", "-c", &block])
                .current_dir(folder.path())
                .output()
                .expect("a shell");
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{page}: {block}{said}");
            run += 1;
        }
    }
    assert!(run >= 14, "only {run} blocks ran");
}

#[test]
fn the_answer_that_the_readme_shows() {
    let readme =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../README.md")).expect("a page");
    let shown = |start: &str| {
        readme.lines().find(|line| line.trim_start().starts_with(start)).expect("a line").to_string()
    };
    let nasa =
        testkit::run(env!("CARGO_BIN_EXE_axescal"), &[], &testkit::read_fixture("nasa-1977/table-4.json"));
    assert!(nasa.stderr.contains(&shown("doubtful: orientation 4")), "{}", nasa.stderr);
    assert!(nasa.stderr.contains(&shown("doubtful: orientation 1")), "{}", nasa.stderr);
    let magsat =
        testkit::run(env!("CARGO_BIN_EXE_axescal"), &[], &testkit::read_fixture("axescal/magsat/input.json"));
    for start in ["axescal: 168 readings", "sensor x in SEN", "field without drive"] {
        assert!(magsat.stderr.contains(&shown(start)), "{start}: {}", magsat.stderr);
    }
}
