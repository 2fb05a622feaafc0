//! The binaries in a pipe, as a person or a script would run them.

use serde_json::Value;
use std::fs;
use std::process::{Command, Stdio};

const AXESCAL: &str = env!("CARGO_BIN_EXE_axescal");

fn nasa() -> String {
    testkit::read_fixture("nasa-1977/table-4.json")
}

#[test]
fn document_in_document_out() {
    let run = testkit::run(AXESCAL, &[], &nasa());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let after: Value = serde_json::from_str(&run.stdout).expect("JSON");
    let history = &after["history"][0];
    assert_eq!(history["stage"], "axescal");
    assert_eq!(history["input_sha256"].as_str().expect("a digest").len(), 64);
    let said = "outlier: orientation 4 (\"orientation-4\", row 0), coil x, sensor y";
    assert!(run.stderr.contains(said), "{}", run.stderr);
}

#[test]
fn the_same_input_gives_the_same_bytes_on_any_number_of_threads() {
    let runs: Vec<String> = ["1", "2", "7"]
        .iter()
        .map(|threads| {
            let output = Command::new(AXESCAL)
                .args(["design", "--number", "5"])
                .env("RAYON_NUM_THREADS", threads)
                .output()
                .expect("ran");
            String::from_utf8(output.stdout).expect("UTF-8")
        })
        .collect();
    assert!(runs[0].contains("worst_arcsec") && runs.iter().all(|run| *run == runs[0]));
    let twice = [testkit::run(AXESCAL, &[], &nasa()).stdout, testkit::run(AXESCAL, &[], &nasa()).stdout];
    assert_eq!(twice[0], twice[1]);
}

#[test]
fn a_stage_can_be_run_again_on_what_it_wrote() {
    let first = testkit::run(AXESCAL, &["--quiet"], &nasa());
    assert_eq!(first.stderr, "");
    let again = testkit::run(AXESCAL, &["--quiet"], &first.stdout);
    let axes = |text: &str| serde_json::from_str::<Value>(text).expect("JSON")["calibration"]["axes"].clone();
    assert_eq!(axes(&first.stdout), axes(&again.stdout));
    let history = serde_json::from_str::<Value>(&again.stdout).expect("JSON")["history"].clone();
    assert_eq!(history.as_array().map(Vec::len), Some(2));
}

#[test]
fn files_instead_of_a_pipe() {
    let folder = tempfile::tempdir().expect("a folder");
    let (input, output) = (folder.path().join("in.json"), folder.path().join("out.json"));
    fs::write(&input, nasa()).expect("written");
    let path = |path: &std::path::Path| path.to_str().expect("UTF-8").to_string();
    let run = testkit::run(AXESCAL, &[&path(&input), "-o", &path(&output)], "");
    assert_eq!((run.code, run.stdout.as_str()), (0, ""));
    let piped = testkit::run(AXESCAL, &[], &nasa());
    assert_eq!(fs::read_to_string(&output).expect("there"), piped.stdout);

    // A failure leaves what was there before.
    fs::write(&input, "{").expect("written");
    let failed = testkit::run(AXESCAL, &[&path(&input), "-o", &path(&output)], "");
    assert_eq!(failed.code, 2);
    assert_eq!(fs::read_to_string(&output).expect("there"), piped.stdout);
    assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 2);
    let absent = testkit::run(AXESCAL, &["absent.json"], "");
    let said = "axescal: absent.json: cannot be read";
    assert!(absent.code == 2 && absent.stderr.starts_with(said), "{}", absent.stderr);
}

#[test]
fn a_reader_that_goes_is_no_error() {
    let mut child = Command::new(AXESCAL)
        .arg("-q")
        .arg(testkit::fixture("nasa-1977/table-4.json"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("ended");
    assert!(output.status.success() && output.stderr.is_empty());
}

#[test]
fn design_from_a_file_of_orientations() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("mine.json");
    let path = file.to_str().expect("UTF-8");
    fs::write(&file, "[[[1,0,0],[0,1,0],[0,0,1]],[[0,1,0],[-1,0,0],[0,0,1]],[[1,0,0],[0,0,1],[0,-1,0]]]")
        .expect("written");
    let run = testkit::run(AXESCAL, &["design", "-n", "3", "--candidates", path], "");
    assert!(run.code == 0 && run.stderr.contains("3.26"), "{}", run.stderr);
    fs::write(&file, "[[[1,0,0],[0,1,0],[0,0,1]],[[0,1,0],[1,0,0],[0,0,1]]]").expect("written");
    let mirrored = testkit::run(AXESCAL, &["design", "--candidates", path], "");
    let said = "[1]: found a left-handed matrix";
    assert!(mirrored.code == 2 && mirrored.stderr.contains(said), "{}", mirrored.stderr);
    let two = testkit::run(AXESCAL, &["design", "-n", "2"], "");
    assert!(two.code == 1 && two.stderr.contains("two never suffice"), "{}", two.stderr);
}

/// No file that is read is written over by mistake; permissions stay; options are numbers.
#[test]
fn what_is_read_is_not_lost() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("campaign.json");
    let name = file.to_str().expect("a path");
    fs::write(&file, nasa()).expect("written");
    let refused = testkit::run(AXESCAL, &[name, "-o", name], "");
    assert_eq!(refused.code, 2, "{}", refused.stderr);
    assert!(refused.stderr.contains("is also read"), "{}", refused.stderr);
    assert_eq!(fs::read_to_string(&file).expect("there"), nasa());
    let private = std::os::unix::fs::PermissionsExt::from_mode(0o600);
    fs::set_permissions(&file, private).expect("set");
    let meant = testkit::run(AXESCAL, &[name, "-o", name, "--in-place"], "");
    assert_eq!(meant.code, 0, "{}", meant.stderr);
    assert!(fs::read_to_string(&file).expect("there").contains("\"axes\""));
    let mode = std::os::unix::fs::PermissionsExt::mode(&fs::metadata(&file).expect("there").permissions());
    assert_eq!(mode & 0o777, 0o600);
    for (option, said) in
        [("--noise-nt=-1", "found -1; expected zero or a number above it"), ("--drive-nt=nan", "found nan")]
    {
        let run = testkit::run(AXESCAL, &["design", option], "");
        assert!(run.code == 2 && run.stderr.contains(said), "{}", run.stderr);
    }
}
