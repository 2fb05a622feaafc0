//! A minute of cases on the programs beside this test, from a seed that is printed: FLUXCAL_SEED, or always the same. FLUXCAL_MINUTES is
//! another time. How many cases that makes depends on the machine, what they are does not.

use fuzz::programs::Programs;
use fuzz::session::{Session, Settings};
use std::time::Duration;

fn number(variable: &str, usual: f64) -> f64 {
    match std::env::var(variable) {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("{variable}={text}; expected a number")),
        Err(_) => usual,
    }
}

#[test]
fn a_minute_breaks_no_rule() {
    let programs = Programs::find(None).unwrap_or_else(|error| panic!("{error}"));
    let seed = number("FLUXCAL_SEED", 1977.0) as u64;
    let time = Duration::from_secs_f64(60.0 * number("FLUXCAL_MINUTES", 1.0));
    println!("seed {seed}");
    let session = Session::new(programs).unwrap_or_else(|error| panic!("{error}"));
    let settings = Settings { seed, time, case: None, only: None, keep: None };
    let summary = session.run(&settings, |_| {}).unwrap_or_else(|error| panic!("{error}"));
    println!("{} cases, {} runs", summary.cases, summary.runs.values().sum::<u64>());
    let findings: Vec<String> = summary.findings.iter().map(fuzz::finding::Finding::text).collect();
    assert!(findings.is_empty(), "seed {seed}, {} findings:\n{}", findings.len(), findings.join("\n"));
    assert!(summary.cases > 0);
}

#[test]
fn programs_that_are_not_there_are_told_with_the_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let said = Programs::find(Some(folder.path())).expect_err("refused").to_string();
    assert!(said.starts_with("no program simulate in ") && said.contains("cargo build"), "{said}");
}
