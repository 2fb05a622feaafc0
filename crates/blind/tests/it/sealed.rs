//! A small proof in its three steps, each a run of its own: seals that hold, and an opening that counts once.
//!
//! The whole is `just proof`.

use std::fs;
use std::path::{Path, PathBuf};

const BLIND: &str = env!("CARGO_BIN_EXE_blind");

/// The programs under proof are beside this one: `cargo test --workspace` builds them all.
fn the_programs_are_built() {
    for name in ["diagnose", "baselines"] {
        let program = Path::new(BLIND).with_file_name(name);
        assert!(
            program.is_file(),
            "no {}; `cargo test --workspace` or `cargo build -p {name}` makes it",
            program.display()
        );
    }
}

/// Cases in a folder with their truths beside it.
struct Proof(tempfile::TempDir);

impl Proof {
    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, arguments: &[&str]) -> testkit::Run {
        testkit::run_in(BLIND, self.0.path(), arguments)
    }

    fn made(arguments: &[&str]) -> Self {
        let proof = Self(tempfile::tempdir().expect("a folder"));
        let made = proof
            .run(&[&["make", "--cases", "1", "-o", "cases", "--truths", "truths.json"], arguments].concat());
        assert_eq!((made.code, made.stdout.trim().len()), (0, 64), "{}", made.stderr);
        proof
    }

    fn score(&self, page: &str) -> testkit::Run {
        self.run(&["score", "cases", "--truths", "truths.json", "--cases-only", "-o", page])
    }
}

#[test]
fn answers_are_scored_once_and_a_changed_truth_or_a_late_answer_is_refused() {
    the_programs_are_built();
    let proof = Proof::made(&["--set", "single", "--set", "clean", "--seed", "8001"]);
    let answered = proof.run(&["answer", "cases"]);
    assert_eq!((answered.code, answered.stdout.as_str()), (0, ""), "{}", answered.stderr);
    let first = proof.score("first.md");
    assert_eq!(first.code, 0, "{}", first.stderr);
    assert!(first.stdout.is_empty() && first.stderr.contains("named right"), "{}", first.stderr);
    assert_eq!(proof.score("second.md").code, 0);
    let read = |name: &str| fs::read_to_string(proof.path(name)).expect("a file");
    assert_eq!(read("first.md"), read("second.md"));
    assert!(read("first.md").contains("| nothing | clean | 1 |"), "{}", read("first.md"));
    assert!(proof.path("first/blind-strengths.svg").is_file());
    assert_eq!(read("first/history.md").lines().count(), 7);

    // An answer that was changed after the opening.
    let bears_a_digest =
        |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("answers-"));
    let folder = fs::read_dir(proof.path("cases"))
        .expect("a folder")
        .filter_map(Result::ok)
        .map(|entry| entry.path())
        .find(bears_a_digest)
        .expect("answers");
    let answer = fs::read_dir(folder)
        .expect("answers")
        .filter_map(Result::ok)
        .map(|entry| entry.path())
        .find(|path| path.extension().is_some_and(|extension| extension == "json"))
        .expect("an answer");
    let text = fs::read_to_string(&answer).expect("an answer");
    fs::write(&answer, format!("{text} ")).expect("written");
    let late = proof.score("third.md");
    assert_eq!(late.code, 2, "{}", late.stderr);
    assert!(late.stderr.contains("not there when the truths were opened"), "{}", late.stderr);
    fs::write(&answer, text).expect("written");

    let truths = proof.path("truths.json");
    let text = fs::read_to_string(&truths).expect("truths");
    fs::write(&truths, text.replacen("8001", "8002", 1)).expect("written");
    let changed = proof.score("third.md");
    assert_eq!(changed.code, 2, "{}", changed.stderr);
    assert!(changed.stderr.contains("seals.txt"), "{}", changed.stderr);
    assert!(!proof.path("third.md").exists());
}

#[test]
fn a_seed_of_the_system_is_another_each_time() {
    let seals = |proof: &Proof| fs::read_to_string(proof.path("cases/seals.txt")).expect("seals");
    let made = || Proof::made(&["--set", "clean"]);
    assert_ne!(seals(&made()), seals(&made()));
}

#[test]
fn the_documents_do_not_hold_the_truths() {
    let proof = Proof::made(&["--set", "single", "--seed", "5"]);
    let there: Vec<String> = fs::read_dir(proof.path("cases"))
        .expect("a folder")
        .filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()))
        .collect();
    assert!(there.len() == 2 && there.contains(&"seals.txt".to_string()), "{there:?}");
}

/// What diagnose cannot name because the name was taken out of its catalogue is no neighbour of it.
#[test]
fn what_is_taken_out_of_the_catalogue_gets_no_name() {
    the_programs_are_built();
    let proof = Proof(tempfile::tempdir().expect("a folder"));
    let counted = proof.run(&[
        "tally",
        "--set",
        "single",
        "--seed",
        "6001",
        "--first",
        "3",
        "--cases",
        "1",
        "--removed",
        "--folder",
        "t",
    ]);
    assert_eq!(counted.code, 0, "{}", counted.stderr);
    assert!(counted.stdout.contains("single, all: 1 cases: right 1"), "{}", counted.stdout);
}

/// On this orbit the turns of the sensors were once all taken for a turn of them together, and the names that
/// came after were wrong.
#[test]
fn an_orbit_is_explained_down_to_its_noise() {
    the_programs_are_built();
    let folder = tempfile::tempdir().expect("a folder");
    let run = testkit::run(
        BLIND,
        &["orbit", "--seed", "2001", "--folder", &folder.path().display().to_string()],
        "",
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    for line in [
        "| verdict | explained |",
        "| named | sun_thermoelectric_harmonics |",
        "| with what was found | 0.148 nT |",
    ] {
        assert!(run.stdout.contains(line), "{line}\n{}", run.stdout);
    }
}

#[test]
fn a_program_that_is_not_there_is_named() {
    let proof = Proof::made(&["--set", "clean"]);
    let run = proof.run(&["answer", "cases", "--programs", "nowhere"]);
    assert_eq!((run.code, run.stdout.as_str()), (2, ""));
    assert!(run.stderr.contains("diagnose") && run.stderr.contains("cargo build"), "{}", run.stderr);
}
