use std::env;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

use crate::{Run, fixture, run, run_in};

/// Runs the examples in the help text of a program, and of each of its subcommands, as they stand, in an
/// empty folder where only the fixtures are; they find the workspace's programs beside it. Gives the folder
/// with what they wrote.
#[cfg(unix)]
pub fn examples(program: &str, subcommands: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let fixtures = fixture("").canonicalize().expect("fixtures");
    std::os::unix::fs::symlink(fixtures, folder.path().join("fixtures")).expect("a link");
    let programs = Path::new(program).parent().expect("a folder");
    let path = format!("{}:{}", programs.display(), env::var("PATH").expect("a path"));
    let own = [vec!["--help"]];
    for arguments in own.into_iter().chain(subcommands.iter().map(|name| vec![*name, "--help"])) {
        let help = run(program, &arguments, "").stdout;
        let example: Vec<&str> = help
            .lines()
            .skip_while(|line| !line.starts_with("Example"))
            .skip(1)
            .take_while(|line| line.starts_with("  "))
            .collect();
        assert!(!example.is_empty(), "{arguments:?}: {help}");
        let output = Command::new("bash")
            .args(["-e", "-o", "pipefail", "-c", &example.join("\n")])
            .current_dir(folder.path())
            .env("PATH", &path)
            .output()
            .expect("a shell");
        let done = Run::of(output);
        assert_eq!(done.code, 0, "{example:?} (are all programs of the workspace built?): {}", done.stderr);
    }
    folder
}

/// A program prints completions and writes man pages; its help begins with what it does and an example.
pub fn manual(program: &str) {
    let name = Path::new(program).file_name().and_then(|name| name.to_str()).expect("a name");
    let help = run(program, &["--help"], "").stdout;
    let mut lines = help.lines().skip(1);
    let below = (lines.next(), lines.next().map(|line| line.starts_with("Example")));
    assert_eq!(below, (Some(""), Some(true)), "one line on what it does, then an example: {help}");
    for (shell, option) in [("bash", "--man"), ("zsh", "--man"), ("fish", "-l man")] {
        let completions = run(program, &["--completions", shell], "");
        assert_eq!(completions.code, 0, "{}", completions.stderr);
        assert!(completions.stdout.contains(name) && completions.stdout.contains(option), "{shell}");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let done = run_in(program, folder.path(), &["--man", "pages"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let page = std::fs::read_to_string(folder.path().join(format!("pages/{name}.1"))).expect("a page");
    assert!(page.contains(".SH NAME") && page.contains(".SH EXAMPLE"), "{page}");
    assert_eq!(run(program, &["--completions", "sh"], "").code, 2);
}
