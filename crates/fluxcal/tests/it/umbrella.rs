//! `fluxcal PROGRAM …` is `PROGRAM …`.

use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};

use crate::{FLUXCAL, beside, fixture};

#[test]
fn streams_and_exit_codes_are_the_programs_own() {
    let good = testkit::read_fixture("axescal/magsat/input.json");
    let undetermined = testkit::read_fixture("bad/coilcal/two-levels.json");
    for (arguments, input, code) in [
        (vec!["axescal"], good.as_str(), 0),
        (vec!["axescal", "-q"], "{", 2),
        (vec!["axescal", "design", "--number", "-3"], "", 2),
        (vec!["coilcal"], undetermined.as_str(), 1),
    ] {
        let (program, rest) = (beside(arguments[0]), &arguments[1..]);
        let (one, other) = (testkit::run(FLUXCAL, &arguments, input), testkit::run(&program, rest, input));
        assert_eq!((one.code, one.code), (code, other.code), "{arguments:?}: {}", one.stderr);
        assert_eq!((one.stdout, one.stderr), (other.stdout, other.stderr), "{arguments:?}");
    }
}

#[test]
fn help_of_a_program() {
    for (asked, own) in [
        (vec!["help", "axescal"], vec!["--help"]),
        (vec!["help", "axescal", "design"], vec!["design", "--help"]),
        (vec!["axescal", "-h"], vec!["-h"]),
    ] {
        let (one, other) = (testkit::run(FLUXCAL, &asked, ""), testkit::run(&beside("axescal"), &own, ""));
        assert_eq!((one.code, one.stdout), (0, other.stdout), "{asked:?}");
    }
    let help = testkit::run(FLUXCAL, &["help"], "");
    assert_eq!((help.code, help.stdout), (0, testkit::run(FLUXCAL, &["--help"], "").stdout));
    assert_eq!(testkit::run(FLUXCAL, &["--version"], "").stdout.trim(), "fluxcal 0.1.0");
}

#[test]
fn an_unknown_name_is_answered_with_the_nearest() {
    for (arguments, said) in [
        (vec!["axecal", "x.json"], "axecal; did you mean axescal?"),
        (vec!["help", "diagnos"], "diagnos; did you mean diagnose?"),
        (vec!["xyz"], "xyz."),
    ] {
        let run = testkit::run(FLUXCAL, &arguments, "");
        let said = format!("fluxcal: no program is called {said} `fluxcal --help` lists all\n");
        assert_eq!((run.code, run.stdout.as_str(), run.stderr), (2, "", said));
    }
    let none = testkit::run(FLUXCAL, &[], "");
    assert!(none.code == 2 && none.stderr.contains("Programs:"), "{}", none.stderr);
}

/// Alone in a folder it finds the programs on the PATH, and says what is missing where they are not there
/// either.
#[cfg(unix)]
#[test]
fn a_program_is_found_on_the_path() {
    let folder = tempfile::tempdir().expect("a folder");
    let alone = folder.path().join("fluxcal");
    fs::copy(FLUXCAL, &alone).expect("copied");
    let programs = std::path::Path::new(FLUXCAL).parent().expect("a folder");
    let run = |path: &std::path::Path| {
        Command::new(&alone).args(["axescal", "--version"]).env("PATH", path).output().expect("run")
    };
    assert_eq!(String::from_utf8_lossy(&run(programs).stdout), "axescal 0.1.0\n");
    let missing = run(folder.path());
    let said = String::from_utf8_lossy(&missing.stderr).into_owned();
    assert_eq!(missing.status.code(), Some(2));
    let expected = "fluxcal: the program axescal is neither beside fluxcal nor on the PATH";
    assert!(said.starts_with(expected), "{said}");
}

/// A signal reaches the program itself, for it has taken the place of `fluxcal`.
#[cfg(unix)]
#[test]
fn signals_are_the_programs_own() {
    use std::os::unix::process::ExitStatusExt;
    let mut child = Command::new(FLUXCAL)
        .args(["diffmag", "stream", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("run");
    let mut input = child.stdin.take().expect("piped");
    input.write_all(&fs::read(fixture("diffmag/pieces/morning.csv")).expect("a fixture")).expect("taken");
    let name = || fs::read_to_string(format!("/proc/{}/comm", child.id())).unwrap_or_default();
    for _ in 0..200 {
        if name().trim() == "diffmag" {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    if cfg!(target_os = "linux") {
        assert_eq!(name().trim(), "diffmag");
    }
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &id]).status().expect("kill").success());
    assert_eq!(child.wait().expect("ended").signal(), Some(15));
}
