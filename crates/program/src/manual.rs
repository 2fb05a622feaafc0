//! The command line of every program, with its completions and its man pages.

use clap::{Args, Command, Parser};
use clap_complete::Shell;
use common::ExitCode;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::{env, io, process};

use crate::pipe;

// What a program says of itself. No comment of documentation, which would take the place of the program's own words in its help.
#[derive(Args, Debug)]
#[command(next_help_heading = "Manual")]
struct Manual {
    /// Print completions for a shell
    #[arg(long, value_name = "SHELL", exclusive = true)]
    completions: Option<Shell>,
    /// Write man pages into a folder
    #[arg(long, value_name = "FOLDER", exclusive = true)]
    man: Option<PathBuf>,
}

#[derive(Parser)]
struct Alone {
    #[command(flatten)]
    manual: Manual,
}

/// Parses the arguments. `--completions SHELL` and `--man FOLDER`, alone on the line, write what they name and end the program.
pub fn parse<C: Parser>() -> C {
    let mut command = Manual::augment_args(C::command());
    let arguments: Vec<OsString> = env::args_os().collect();
    // Before the parser, which would ask for a subcommand first.
    if let Some("--completions" | "--man") = arguments.get(1).and_then(|first| first.to_str()) {
        write(command, Alone::parse_from(arguments).manual);
    }
    let matches = command.get_matches_mut();
    C::from_arg_matches(&matches).unwrap_or_else(|error| error.format(&mut command).exit())
}

/// Writes completions or man pages.
fn write(mut command: Command, asked: Manual) -> ! {
    let name = command.get_name().to_string();
    if let Some(shell) = asked.completions {
        let mut text = Vec::new();
        clap_complete::generate(shell, &mut command, name.clone(), &mut text);
        if let Err(error) = pipe::write(None, &String::from_utf8_lossy(&text)) {
            pipe::say(&format!("{name}: {error}"));
            process::exit(ExitCode::Refused as i32);
        }
    }
    if let Some(folder) = asked.man
        && let Err(error) = pages(command, &folder)
    {
        pipe::say(&format!("{name}: {}: cannot be written ({error})", folder.display()));
        process::exit(ExitCode::Refused as i32);
    }
    process::exit(0)
}

fn pages(command: Command, folder: &Path) -> io::Result<()> {
    std::fs::create_dir_all(folder)?;
    clap_mangen::generate_to(command, folder)
}
