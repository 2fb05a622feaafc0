//! Completions that go on with those of the program that is named: its options are its own, and are asked of
//! it.

use super::PROGRAMS;

/// The script for a shell; None where the shell has none of its own, and the names of the programs are all
/// that is completed.
pub fn script(shell: &str) -> Option<String> {
    let script = match shell {
        "bash" => include_str!("completions/bash"),
        "zsh" => include_str!("completions/zsh"),
        "fish" => include_str!("completions/fish"),
        _ => return None,
    };
    Some(script.replace("PROGRAMS", &PROGRAMS.map(|program| program.name).join(" ")))
}
