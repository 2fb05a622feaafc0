//! `fluxcal`: runs the program that is named, with its arguments, streams, exit code and signals unchanged.

use clap::{Arg, Command, CommandFactory, FromArgMatches};
use fluxcal::view::{self, View};
use fluxcal::{PROGRAMS, Program, nearest, program, script};
use program::{manual, pipe};
use std::env;
use std::ffi::OsString;
use std::io;
use std::process::{self, ExitCode};

/// The exit code of a request that is wrong, as that of all programs.
const REFUSED: u8 = 2;

fn main() -> ExitCode {
    let mut arguments: Vec<OsString> = env::args_os().skip(1).collect();
    let helped = arguments.len() > 1 && arguments[0] == "help";
    if helped {
        arguments.remove(0);
        arguments.push("--help".into());
    }
    if let [option, shell] = arguments.as_slice()
        && option == "--completions"
        && let Some(script) = script(&shell.to_string_lossy())
    {
        return match pipe::write(None, &script) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => refused(&error.to_string()),
        };
    }
    let name = arguments.first().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    match program(&name) {
        Some(program) => run(program, &arguments[1..]),
        None if name == "view" => show(),
        None if name.is_empty() || name.starts_with('-') || name == "help" => {
            manual::matches(command());
            ExitCode::SUCCESS
        }
        None => {
            let meant = nearest(&name).map(|program| format!("; did you mean {}?", program.name));
            let meant = meant.unwrap_or_else(|| ".".into());
            refused(&format!("no program is called {name}{meant} `fluxcal --help` lists all"))
        }
    }
}

/// `fluxcal view`; standard output has the page's path.
fn show() -> ExitCode {
    let matches = manual::matches(command());
    let asked = matches.subcommand_matches("view").and_then(|asked| View::from_arg_matches(asked).ok());
    let page = asked.map_or(Err("no file to view".into()), |asked| view::run(&asked));
    let written = page.and_then(|page| {
        pipe::write(None, &format!("{}\n", page.display())).map_err(|error| error.to_string())
    });
    written.map_or_else(|words| refused(&words), |()| ExitCode::SUCCESS)
}

fn command() -> Command {
    let passed_on = |program: &Program| {
        let arguments =
            Arg::new("arguments").value_name("ARGUMENTS").num_args(0..).help("Passed on to the program");
        Command::new(program.name)
            .about(program.does)
            .after_help(format!("See {}(1), or `fluxcal help {}`.", program.name, program.name))
            .arg(arguments)
    };
    Command::new("fluxcal")
        .version(env!("CARGO_PKG_VERSION"))
        .about("Calibrate vector magnetometers: run one of the programs below")
        .after_help(
            "Example:\n  \
            fluxcal simulate campaign fixtures/plans/magsat-axes.json | fluxcal axescal > result.json\n  \
            fluxcal view result.json\n  \
            fluxcal help axescal\n\n\
            `fluxcal axescal …` is `axescal …`: arguments, streams, exit codes and signals are the program's own.",
        )
        .subcommand_value_name("PROGRAM")
        .subcommand_help_heading("Programs")
        .arg_required_else_help(true)
        .subcommands(PROGRAMS.iter().map(passed_on))
        .subcommand(View::command())
}

/// Becomes the program; where a system knows no such thing, runs it and ends as it did.
fn run(program: Program, arguments: &[OsString]) -> ExitCode {
    let path = program.path();
    let mut command = process::Command::new(&path);
    command.args(arguments);
    #[cfg(unix)]
    let failed = std::os::unix::process::CommandExt::exec(&mut command);
    #[cfg(not(unix))]
    let failed = match command.status() {
        Ok(status) => process::exit(status.code().unwrap_or(REFUSED.into())),
        Err(failed) => failed,
    };
    if failed.kind() == io::ErrorKind::NotFound {
        let name = program.name;
        return refused(&format!(
            "the program {name} is neither beside fluxcal nor on the PATH; install all programs in one folder (`just install`)"
        ));
    }
    refused(&format!("{}: cannot be run: {failed}", path.display()))
}

fn refused(words: &str) -> ExitCode {
    pipe::say(&format!("fluxcal: {words}"));
    ExitCode::from(REFUSED)
}
