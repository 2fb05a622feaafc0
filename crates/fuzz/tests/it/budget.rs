//! Three hundred cases on the programs beside this test, from a seed that is printed: FLUXCAL_SEED, or always
//! the same. FLUXCAL_FUZZ_CASES is another number of them. What they are and how they end does not depend on
//! the machine: a program only counts as hung after ten minutes of processor time.

use fuzz::programs::Programs;
use fuzz::session::{Session, Settings};
use testkit::number;

#[test]
fn no_rule_is_broken() {
    let programs = Programs::find(None).unwrap_or_else(|error| panic!("{error}"));
    let (seed, cases) = (number("FLUXCAL_SEED").unwrap_or(1977), number("FLUXCAL_FUZZ_CASES").unwrap_or(300));
    println!("seed {seed}, {cases} cases");
    let session = Session::new(programs).unwrap_or_else(|error| panic!("{error}"));
    let settings = Settings { seed, cases: 0..cases, time: None, processor_s: 600, only: None, keep: None };
    let summary = session.run(&settings, |_| {}).unwrap_or_else(|error| panic!("{error}"));
    println!("{} runs", summary.runs.values().sum::<u64>());
    let findings: Vec<String> = summary.findings.iter().map(fuzz::finding::Finding::text).collect();
    assert!(findings.is_empty(), "seed {seed}, {} findings:\n{}", findings.len(), findings.join("\n"));
    assert_eq!(summary.cases, cases);
}

#[test]
fn programs_that_are_not_there_are_told_with_the_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let said = Programs::find(Some(folder.path())).expect_err("refused").to_string();
    assert!(said.starts_with("no program simulate in ") && said.contains("cargo build"), "{said}");
}
