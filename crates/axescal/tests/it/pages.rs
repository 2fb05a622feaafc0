//! The commands of README and docs run, print what the page shows, and write numbers as people read them.

use rayon::prelude::*;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A command of a page, and the lines that the page shows of what it prints.
#[derive(Default)]
struct Block {
    command: String,
    shown: Vec<String>,
}

/// The ```sh blocks of a page. Below each stands what it prints, in ```text blocks or indented.
fn blocks(page: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut fence: Option<&str> = None;
    let mut below = false;
    for line in page.lines() {
        let text = line.trim();
        match (fence, blocks.last_mut()) {
            (None, _) if text == "```sh" => {
                blocks.push(Block::default());
                (fence, below) = (Some(text), true);
            }
            (None, _) if text.starts_with("```") => fence = Some(text),
            (Some(_), _) if text == "```" => fence = None,
            (Some("```sh"), Some(block)) => block.command += &format!("{line}\n"),
            (Some("```text"), Some(block)) => block.shown.push(text.into()),
            (None, Some(block)) if below && line.starts_with("    ") => block.shown.push(text.into()),
            (None, _) => below &= text.is_empty(),
            _ => {}
        }
    }
    blocks
}

/// Whether a line of a page stands in what was printed. `…` stands for anything left out.
fn stands_in(shown: &str, printed: &str) -> bool {
    let parts: Vec<&str> = shown.split('…').map(str::trim).filter(|part| !part.is_empty()).collect();
    parts.is_empty()
        || printed.lines().any(|line| {
            parts.iter().try_fold(line, |rest, part| rest.split_once(part).map(|(_, after)| after)).is_some()
        })
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().expect("the workspace")
}

/// Runs the commands of a page in a folder of its own.
fn runs(page: &str) {
    let root = root();
    let binaries = Path::new(env!("CARGO_BIN_EXE_axescal")).parent().expect("a folder");
    let others = "simulate ingest series coilcal sensorcal scalarcal starcal diffmag absolute diagnose correct report fluxcal";
    for other in others.split(' ') {
        assert!(binaries.join(other).exists(), "the binary `{other}` is built by `cargo test --workspace`");
    }
    let path = format!("{}:{}", binaries.display(), std::env::var("PATH").expect("a path"));
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("target")).expect("a folder");
    symlink(binaries, folder.path().join("target/release")).expect("a link");
    symlink(root.join("fixtures"), folder.path().join("fixtures")).expect("a link");
    let mut run = 0;
    for Block { command, shown } in blocks(&text(page)) {
        // Building and testing is what runs this test.
        let command = command.replace("cargo build --release && ", "");
        if command.starts_with("cargo ") {
            continue;
        }
        let output = Command::new("sh")
            .args(["-e", "-c", &command])
            .current_dir(folder.path())
            .env("PATH", &path)
            .output()
            .expect("a shell");
        let [said, given] =
            [output.stderr, output.stdout].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        let printed = said.clone() + &given;
        assert!(output.status.success(), "{page}: {command}{printed}");
        let wrong: Vec<&String> = shown.iter().filter(|line| !stands_in(line, &printed)).collect();
        assert!(wrong.is_empty(), "{page}: {command}does not print {wrong:#?} but\n{printed}");
        let wrong = testkit::ill_written(&said);
        assert!(wrong.is_empty(), "{page}: {command}writes {wrong:#?} in\n{said}");
        run += 1;
    }
    assert!(run > 0, "{page}: no block ran");
}

/// The pages of a folder, by their paths from the root.
fn pages(folder: &str) -> Vec<String> {
    let entries = fs::read_dir(root().join(folder)).expect("a folder");
    let names = entries.map(|page| page.expect("a page").file_name().into_string().expect("UTF-8"));
    names.filter(|name| name.ends_with(".md")).map(|name| format!("{folder}/{name}")).collect()
}

fn text(page: &str) -> String {
    fs::read_to_string(root().join(page)).expect("a page")
}

#[test]
fn tutorials() {
    let pages = pages("docs/tutorial");
    assert!(pages.len() >= 4, "{pages:?}");
    for page in pages {
        assert!(text(&page).lines().count() < 100, "{page}: a tutorial has less than 100 lines");
        runs(&page);
    }
}

#[test]
fn pages_with_commands() {
    let all = pages("docs").into_iter().chain(["README.md".into()]);
    let pages: Vec<String> = all.filter(|page| text(page).contains("```sh")).collect();
    assert!(pages.len() >= 18, "{pages:?}");
    pages.par_iter().for_each(|page| runs(page));
}
