//! Three hundred cases on the programs beside this test, from a seed that is printed: FLUXCAL_SEED, or always
//! the same. FLUXCAL_FUZZ_CASES is another number of them. What they are and how they end does not depend on
//! the machine: a program only counts as hung after ten minutes of processor time.

use fuzz::{Finding, Programs, Session, Settings};
use testkit::number;

const FUZZ: &str = env!("CARGO_BIN_EXE_fuzz");

#[test]
fn no_rule_is_broken() {
    let programs = Programs::find(None).unwrap_or_else(|error| panic!("{error}"));
    let (seed, cases) = (number("FLUXCAL_SEED").unwrap_or(1977), number("FLUXCAL_FUZZ_CASES").unwrap_or(300));
    println!("seed {seed}, {cases} cases");
    let session = Session::new(programs).unwrap_or_else(|error| panic!("{error}"));
    let settings = Settings { seed, cases: 0..cases, time: None, processor_s: 600, only: None, keep: None };
    let summary = session.run(&settings, |_| {}).unwrap_or_else(|error| panic!("{error}"));
    println!("{} runs", summary.runs.values().sum::<u64>());
    let findings: Vec<String> = summary.findings.iter().map(Finding::text).collect();
    assert!(findings.is_empty(), "seed {seed}, {} findings:\n{}", findings.len(), findings.join("\n"));
    assert_eq!(summary.cases, cases);
}

#[test]
fn requests_that_make_no_sense() {
    for arguments in [["--minutes", "nan"], ["--minutes", "-1"], ["--only", "fluxcal"], ["--seed", "-1"]] {
        let run = testkit::run(FUZZ, &arguments, "");
        assert_eq!(run.code, 2, "{arguments:?}: {}", run.stderr);
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().to_str().expect("UTF-8");
    let run = testkit::run(FUZZ, &["--programs", path], "");
    assert_eq!((run.code, run.stdout.as_str()), (2, ""));
    assert!(run.stderr.contains("no program simulate in "), "{}", run.stderr);
    assert!(run.stderr.contains("build all of them (`cargo build`"), "{}", run.stderr);
}
