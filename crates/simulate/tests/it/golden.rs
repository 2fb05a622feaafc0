//! A line a case: the document that a plan gives, number for number. The streams of noise are part of it: the
//! same seed gives the same campaign in every version.

use testkit::golden;

const SIMULATE: &str = env!("CARGO_BIN_EXE_simulate");

fn run(arguments: &'static [&'static str]) -> impl FnOnce(&str) -> String {
    move |input| {
        let run = testkit::run(SIMULATE, arguments, input);
        assert_eq!(run.code, 0, "{}", run.stderr);
        run.stdout
    }
}

#[test]
fn cases() {
    golden("simulate/every-procedure", "simulate/every-procedure/input.json", run(&["campaign", "-q"]));
    golden("simulate/magsat-axes", "plans/magsat-axes.json", run(&["campaign", "-q"]));
    golden("simulate/replay", "axescal/table-4/expected.json", run(&["replay", "-q"]));
}
