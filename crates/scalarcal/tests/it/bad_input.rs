//! Every document of `fixtures/bad/scalarcal` brings its message, its exit code, and nothing on standard output.

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/scalarcal", env!("CARGO_BIN_EXE_scalarcal")) >= 9);
}
