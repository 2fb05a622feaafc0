//! A small proof: one case of each set through the program as it is built, and seals that hold.
//!
//! The whole is `cargo run --release -p concealed -- prove --build`.

use std::fs;
use std::path::Path;

const CONCEALED: &str = env!("CARGO_BIN_EXE_concealed");

/// The program under proof is beside this one: `cargo test --workspace` builds both.
fn diagnose_is_built() {
    let diagnose = Path::new(CONCEALED).with_file_name("diagnose");
    assert!(
        diagnose.is_file(),
        "no {}; `cargo test --workspace` or `cargo build -p diagnose` makes it",
        diagnose.display()
    );
}

#[test]
fn a_small_proof_is_made_twice_alike_and_a_changed_truth_is_refused() {
    diagnose_is_built();
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let prove = |page: &str| {
        let (sets, page) = (path("sets"), path(page));
        testkit::run(
            CONCEALED,
            &["prove", "--cases", "1", "--cases-only", "--folder", &sets, "-o", &page],
            "",
        )
    };
    let first = prove("first.md");
    assert_eq!(first.code, 0, "{}", first.stderr);
    assert!(first.stdout.is_empty() && first.stderr.contains("named right"), "{}", first.stderr);
    assert_eq!(prove("second.md").code, 0);
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).expect("a page");
    assert_eq!(read("first.md"), read("second.md"));
    assert!(read("first.md").contains("| clean | 1 |"), "{}", read("first.md"));

    let truths = fs::read_dir(folder.path().join("sets/seed-8001/truths")).expect("truths");
    let truth = truths.filter_map(Result::ok).next().expect("a truth").path();
    let text = fs::read_to_string(&truth).expect("a truth");
    fs::write(&truth, text.replacen("\"seed\": 8001", "\"seed\": 8002", 1)).expect("written");
    let sets = path("sets");
    let opened =
        testkit::run(CONCEALED, &["score", "--cases-only", "--folder", &sets, "-o", &path("third.md")], "");
    assert_eq!(opened.code, 2, "{}", opened.stderr);
    assert!(opened.stderr.contains("seals.txt"), "{}", opened.stderr);
    assert!(!folder.path().join("third.md").exists());
}

/// On this orbit the turns of the sensors were once all taken for a turn of them together, and the names that came after were wrong.
#[test]
fn an_orbit_is_explained_down_to_its_noise() {
    diagnose_is_built();
    let folder = tempfile::tempdir().expect("a folder");
    let run = testkit::run(
        CONCEALED,
        &["swarm", "--seed", "2001", "--folder", &folder.path().display().to_string()],
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
    let folder = tempfile::tempdir().expect("a folder");
    let empty = folder.path().display().to_string();
    let run =
        testkit::run(CONCEALED, &["prove", "--programs", &empty, "--folder", &empty, "--cases", "1"], "");
    assert_eq!((run.code, run.stdout.as_str()), (2, ""));
    assert!(run.stderr.contains("diagnose") && run.stderr.contains("cargo build"), "{}", run.stderr);
}
