//! The command line of every program, with its completions and its man pages.

use clap::{ArgMatches, Args, Command, Parser};
use clap_complete::Shell;
use clap_mangen::Man;
use clap_mangen::roff::{Roff, roman};
use common::ExitCode;
use std::any::TypeId;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::{env, process};

use crate::{pipe, progress};

/// What a program does, its example, then all the rest.
const HELP: &str = "{about}{after-help}\n\n{usage-heading} {usage}\n\n{all-args}";

// What a program says of itself. No comment of documentation, which would take the place of the program's own
// words in its help.
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

/// Parses the arguments; as [`matches`].
pub fn parse<C: Parser>() -> C {
    C::from_arg_matches(&matches(C::command())).unwrap_or_else(|error| error.format(&mut C::command()).exit())
}

/// Parses the arguments. `--completions SHELL` and `--man FOLDER`, alone on the line, write what they name
/// and end the program.
pub fn matches(command: Command) -> ArgMatches {
    let mut command = Manual::augment_args(same_manners(command));
    let arguments: Vec<OsString> = env::args_os().collect();
    // Before the parser, which would ask for a subcommand first.
    if let Some("--completions" | "--man") = arguments.get(1).and_then(|first| first.to_str()) {
        write(command, Alone::parse_from(arguments).manual);
    }
    let matches = command.get_matches_mut();
    progress::begin(command.get_name(), is_quiet(&matches));
    matches
}

/// What holds for each command and its subcommands: the order of the help, and values of options that begin
/// with a minus sign.
fn same_manners(command: Command) -> Command {
    let command = command.help_template(HELP).mut_args(|argument| {
        if argument.is_positional() || !argument.get_action().takes_values() {
            return argument;
        }
        // The parser itself knows no -1e-3 and no -1,2.
        let is_number = argument.get_value_parser().type_id() == TypeId::of::<f64>();
        if is_number { argument.allow_hyphen_values(true) } else { argument.allow_negative_numbers(true) }
    });
    command.mut_subcommands(same_manners)
}

fn is_quiet(matches: &ArgMatches) -> bool {
    let here = matches.try_get_one::<bool>("quiet").ok().flatten().is_some_and(|quiet| *quiet);
    here || matches.subcommand().is_some_and(|(_, matches)| is_quiet(matches))
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

/// A page for a command, and one for each of its subcommands.
fn pages(command: Command, folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    let mut command = command.disable_help_subcommand(true);
    command.build();
    each_page(command, folder)
}

fn each_page(command: Command, folder: &Path) -> io::Result<()> {
    command.get_subcommands().cloned().try_for_each(|subcommand| each_page(subcommand, folder))?;
    let man = Man::new(command.clone());
    let mut page = File::create(folder.join(man.get_filename()))?;
    man.render_title(&mut page)?;
    man.render_name_section(&mut page)?;
    example(&command).to_writer(&mut page)?;
    man.render_synopsis_section(&mut page)?;
    man.render_options_section(&mut page)?;
    if command.has_subcommands() {
        man.render_subcommands_section(&mut page)?;
    }
    if command.get_version().is_some() {
        man.render_version_section(&mut page)?;
    }
    Ok(())
}

/// What stands below the first line of the help: the example line by line, then other words.
fn example(command: &Command) -> Roff {
    let mut roff = Roff::new();
    let words = command.get_after_help().map(|words| words.to_string()).unwrap_or_default();
    let (title, words) = match words.split_once(":\n") {
        Some((title @ ("Example" | "Examples"), rest)) => (title.to_uppercase(), rest),
        _ => ("NOTES".into(), words.as_str()),
    };
    if words.is_empty() {
        return roff;
    }
    roff.control("SH", [title.as_str()]);
    for line in words.lines() {
        match line.strip_prefix("  ") {
            Some(command) => {
                roff.control("nf", []);
                roff.text([roman(command)]);
                roff.control("fi", []);
            }
            None if line.is_empty() => {
                roff.control("PP", []);
            }
            None => {
                roff.text([roman(line)]);
            }
        }
    }
    roff
}
