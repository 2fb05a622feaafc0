//! What all programs have in common, and the one command that runs them. The programs are built by `cargo
//! test --workspace`.

mod completions;
mod help;
mod options;
mod streams;
mod umbrella;
mod view;

use std::path::{Path, PathBuf};

const FLUXCAL: &str = env!("CARGO_BIN_EXE_fluxcal");

/// A program of the workspace.
fn beside(name: &str) -> String {
    let path = Path::new(FLUXCAL).with_file_name(name);
    assert!(path.is_file(), "the binary `{name}` is built by `cargo test --workspace`");
    path.to_str().expect("UTF-8").into()
}

/// The commands of a program: none, and each of its subcommands, as its help lists them.
fn commands(program: &str) -> Vec<Vec<String>> {
    let help = testkit::run(program, &["--help"], "").stdout;
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let names = listed.take_while(|line| !line.trim().is_empty()).filter_map(|line| {
        let (name, _) = line.strip_prefix("  ")?.split_once(' ')?;
        (!name.is_empty() && name != "help").then(|| vec![name.to_string()])
    });
    std::iter::once(Vec::new()).chain(names).collect()
}

/// Runs a command of a program with more arguments.
fn run(program: &str, command: &[String], more: &[&str], input: &str) -> testkit::Run {
    let arguments: Vec<&str> = command.iter().map(String::as_str).chain(more.iter().copied()).collect();
    testkit::run(program, &arguments, input)
}

fn fixture(name: &str) -> String {
    let path: PathBuf = testkit::fixture(name);
    path.to_str().expect("UTF-8").into()
}
