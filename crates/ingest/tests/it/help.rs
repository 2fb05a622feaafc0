//! The examples in the help texts run as they stand, also in an empty folder where only the fixtures are.

use std::fs;

const INGEST: &str = env!("CARGO_BIN_EXE_ingest");

#[test]
fn examples_run() {
    let folder = testkit::examples(INGEST, &["guess"]);
    let read = |name: &str| -> serde_json::Value {
        let text = fs::read_to_string(folder.path().join(name)).expect("a result");
        serde_json::from_str(&text).expect("JSON")
    };
    assert_eq!(read("result.json")["recordings"][0]["columns"]["sensor_x_nt"][0], 20_900.0);
    assert_eq!(read("map.json")["fluxcal-mapping"], 1);
}

#[test]
fn completions_and_man_pages() {
    testkit::manual(INGEST);
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
