//! The example in each help text runs as it stands, also in an empty folder where only the fixtures are.

use std::env;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

const INGEST: &str = env!("CARGO_BIN_EXE_ingest");

#[test]
fn examples_run() {
    let programs = Path::new(INGEST).parent().expect("a folder");
    let path = format!("{}:{}", programs.display(), env::var("PATH").expect("a path"));
    for (command, result) in [(&["--help"][..], "result.json"), (&["guess", "--help"], "map.json")] {
        let folder = tempfile::tempdir().expect("a folder");
        let fixtures = testkit::fixture("").canonicalize().expect("fixtures");
        symlink(fixtures, folder.path().join("fixtures")).expect("a link");
        let help = testkit::run(INGEST, command, "").stdout;
        let (_, example) = help.split_once("Example:\n").unwrap_or_else(|| panic!("{command:?}: {help}"));
        let example: Vec<&str> = example.lines().take_while(|line| line.starts_with("  ingest")).collect();
        assert!(!example.is_empty(), "{help}");
        let run = Command::new("sh")
            .args(["-e", "-c", &example.join("\n")])
            .current_dir(folder.path())
            .env("PATH", &path)
            .output()
            .expect("a shell");
        assert!(run.status.success(), "{example:?}: {}", String::from_utf8_lossy(&run.stderr));
        let result = fs::read_to_string(folder.path().join(result)).expect("a result");
        let result: serde_json::Value = serde_json::from_str(&result).expect("JSON");
        assert!(
            result["recordings"][0]["columns"]["sensor_x_nt"][0] == 20_900.0
                || result["fluxcal-mapping"] == 1
        );
    }
}

/// What README and page show of a command is what is said.
#[test]
fn the_words_that_the_pages_show() {
    let files = ["flx20240310a.min", "flx20240310b.min"].map(|name| testkit::fixture("ingest").join(name));
    let files = files.each_ref().map(|path| path.to_str().expect("UTF-8"));
    let said = testkit::run(INGEST, &files, "").stderr;
    for page in ["README.md", "docs/ingest.md"] {
        let text = fs::read_to_string(testkit::fixture("..").join(page)).expect("a page");
        let (_, shown) = text.split_once("ingest/flx20240310b.min > minutes.json").expect("the command");
        let from = shown.find("ingest: \"flx").expect("what it says");
        let shown = shown[from..].lines().take_while(|line| !line.trim().is_empty() && *line != "```");
        for line in shown.map(str::trim).filter(|line| *line != "…") {
            assert!(said.contains(line), "{page}: {line}\n{said}");
        }
    }
}
