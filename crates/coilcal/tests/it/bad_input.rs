//! Every document of `fixtures/bad/coilcal` brings its message, its exit code, and nothing on standard
//! output.

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/coilcal", env!("CARGO_BIN_EXE_coilcal")) >= 9);
}
