//! Each help and each man page begins with one line of its own on what the program does, then an example.

use fluxcal::PROGRAMS;
use std::collections::HashSet;
use std::fs;

use crate::{FLUXCAL, beside, commands, run};

/// The first line of a help, and whether an example stands below it.
fn opening(help: &str) -> (String, bool) {
    let mut lines = help.lines();
    let first = lines.next().unwrap_or_default().to_string();
    let example = lines.next() == Some("") && lines.next().is_some_and(|line| line.starts_with("Example"));
    (first, example)
}

#[test]
fn every_help_says_what_its_program_does() {
    let mut seen = HashSet::new();
    for program in PROGRAMS {
        let path = beside(program.name);
        for command in commands(&path) {
            let name = format!("{} {command:?}", program.name);
            let [long, short] =
                ["--help", "-h"].map(|help| opening(&run(&path, &command, &[help], "").stdout));
            assert_eq!(long, short, "{name}");
            let (does, example) = long;
            assert!(does.chars().count() > 20 && does.starts_with(char::is_uppercase), "{name}: {does}");
            assert!(example, "{name}: no example below the first line");
            if command.is_empty() {
                assert_eq!(does, program.does, "what `fluxcal --help` says of {name}");
            }
            assert!(seen.insert(does.clone()), "{name}: {does}, which another one says too");
        }
    }
    assert!(seen.len() > 20, "{seen:?}");
}

#[test]
fn every_man_page_says_what_its_program_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut seen = HashSet::new();
    for program in PROGRAMS {
        let done = testkit::run_in(&beside(program.name), folder.path(), &["--man", program.name]);
        assert_eq!(done.code, 0, "{}", done.stderr);
        for page in fs::read_dir(folder.path().join(program.name)).expect("a folder") {
            let path = page.expect("a page").path();
            let text = fs::read_to_string(&path).expect("a page");
            let (_, below) = text.split_once(".SH NAME\n").expect("a name");
            let (does, below) = below.split_once('\n').expect("a line");
            let sections: Vec<&str> = below.lines().filter(|line| line.starts_with(".SH")).collect();
            assert!(sections[0].starts_with(".SH EXAMPLE"), "{}: {sections:?}", path.display());
            assert_eq!(sections[1..3], [".SH SYNOPSIS", ".SH OPTIONS"], "{}", path.display());
            let (_, does) = does.split_once(" \\- ").expect("name and words");
            assert!(seen.insert(does.to_string()), "{}: {does}, which another one says too", path.display());
        }
    }
    assert!(seen.len() > 20, "{seen:?}");
}

#[test]
fn the_command_lists_all_programs() {
    testkit::manual(FLUXCAL);
    let help = testkit::run(FLUXCAL, &["--help"], "").stdout;
    let words: Vec<&str> = help.split_whitespace().collect();
    let help = words.join(" ");
    for program in PROGRAMS {
        assert!(help.contains(&format!("{} {}", program.name, program.does)), "{}: {help}", program.name);
    }
}

#[test]
fn the_example_runs() {
    testkit::examples(FLUXCAL, &[]);
}
