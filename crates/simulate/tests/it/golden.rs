//! A line a case: the document that a plan gives, number for number. The streams of noise are part of it: the
//! same seed gives the same campaign in every version. The examples in the help texts run as they stand.

use testkit::golden;

const SIMULATE: &str = env!("CARGO_BIN_EXE_simulate");

#[test]
fn cases() {
    for (case, input, command) in [
        ("simulate/every-procedure", "simulate/every-procedure/input.json", "campaign"),
        ("simulate/magsat-axes", "plans/magsat-axes.json", "campaign"),
        ("simulate/replay", "axescal/table-4/expected.json", "replay"),
    ] {
        golden(case, input, |input| {
            let run = testkit::run(SIMULATE, &[command, "-q"], input);
            assert_eq!(run.code, 0, "{}", run.stderr);
            run.stdout
        });
    }
}

#[test]
fn examples_run_and_completions_and_man_pages_are_there() {
    testkit::examples(SIMULATE, &["campaign", "observatory", "flight", "replay", "sweep"]);
    testkit::manual(SIMULATE);
}
