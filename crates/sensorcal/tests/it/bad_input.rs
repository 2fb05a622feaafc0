//! Every document of `fixtures/bad/sensorcal` brings its message, its exit code, and nothing on standard
//! output.

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/sensorcal", env!("CARGO_BIN_EXE_sensorcal")) >= 30);
}
