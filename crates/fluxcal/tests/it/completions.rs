//! `fluxcal PROGRAM` completes what the program itself completes; in bash, which is there wherever the tests
//! run.

use std::path::Path;
use std::process::Command;

use crate::FLUXCAL;

const TRY: &str = r#"
eval "$(fluxcal --completions bash)"
COMP_WORDS=("$@")
COMP_CWORD=$(($# - 1))
_fluxcal fluxcal "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
echo "${COMPREPLY[@]}"
"#;

/// What bash offers for the last of these words.
fn offered(words: &[&str]) -> String {
    let programs = Path::new(FLUXCAL).parent().expect("a folder").display();
    let path = format!("{programs}:{}", std::env::var("PATH").expect("a path"));
    let run =
        Command::new("bash").args(["-c", TRY, "bash"]).args(words).env("PATH", path).output().expect("bash");
    assert!(run.stderr.is_empty(), "{words:?}: {}", String::from_utf8_lossy(&run.stderr));
    String::from_utf8(run.stdout).expect("UTF-8").trim().to_string()
}

#[cfg(unix)]
#[test]
fn programs_then_their_own_options() {
    for (words, expected) in [
        (&["fluxcal", "sca"][..], "scalarcal"),
        (&["fluxcal", "help", "diffm"], "diffmag"),
        (&["fluxcal", "scalarcal", "--rob"], "--robust"),
        (&["fluxcal", "axescal", "des"], "design"),
        (&["fluxcal", "axescal", "design", "--targ"], "--target-arcsec"),
        (&["fluxcal", "report", "--paper", ""], "a4 letter"),
        (&["fluxcal", "nothing", "--"], ""),
    ] {
        assert_eq!(offered(words), expected, "{words:?}");
    }
    assert_eq!(offered(&["fluxcal", ""]).split(' ').count(), fluxcal::PROGRAMS.len() + 6);
}

/// Every shell has a script that names every program.
#[test]
fn each_shell_has_its_script() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let run = testkit::run(FLUXCAL, &["--completions", shell], "");
        assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{shell}");
        for program in fluxcal::PROGRAMS {
            assert!(run.stdout.contains(program.name), "{shell}: {}", program.name);
        }
        assert!(!run.stdout.contains("PROGRAMS"), "{shell}");
    }
}
