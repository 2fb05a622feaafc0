//! The example in the help text runs as it stands.

#[test]
fn examples_run() {
    testkit::examples(env!("CARGO_BIN_EXE_baselines"), &[]);
}
