//! The command's words.

const FUZZ: &str = env!("CARGO_BIN_EXE_fuzz");

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
    assert!(run.stderr.contains("build all of them"), "{}", run.stderr);
}
