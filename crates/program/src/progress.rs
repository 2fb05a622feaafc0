//! What a program is doing, on standard error, where that is a terminal and it takes more than two seconds.
//!
//! A process has one line for it. Without a terminal, or with `--quiet`, nothing is shown and all of this
//! does nothing.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};
use std::sync::OnceLock;
use std::thread;
use std::time::Duration;

/// What takes less is not spoken of.
const AFTER: Duration = Duration::from_secs(2);
/// From one picture to the next.
const TICK: Duration = Duration::from_millis(120);

static LINE: OnceLock<ProgressBar> = OnceLock::new();

/// Begins to count the time of a program.
pub(crate) fn begin(name: &str, quiet: bool) {
    if quiet || !io::stderr().is_terminal() {
        return;
    }
    let line = LINE.get_or_init(|| ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden()));
    line.set_prefix(name.to_string());
    tell("working");
    thread::spawn(move || {
        thread::sleep(AFTER);
        if !line.is_finished() {
            line.set_draw_target(ProgressDrawTarget::stderr());
            line.enable_steady_tick(TICK);
        }
    });
}

/// Says what is being done.
pub fn tell(words: &str) {
    show("{spinner} {prefix}: {msg} ({elapsed})", None);
    LINE.get().iter().for_each(|line| line.set_message(words.to_string()));
}

/// What is being done has so many steps.
pub fn steps(length: usize) {
    if length < 2 {
        return;
    }
    show("{prefix}: {bar:40} {pos} of {len}, {eta} left", Some(length as u64));
}

/// A step is done.
pub fn step() {
    LINE.get().iter().for_each(|line| line.inc(1));
}

/// Takes the line away, before anything else is written to the terminal.
pub fn end() {
    LINE.get().iter().for_each(|line| line.finish_and_clear());
}

/// The same where what is written to standard output goes to a terminal.
pub fn give_way() {
    if io::stdout().is_terminal() {
        end();
    }
}

fn show(template: &str, length: Option<u64>) {
    if let Some(line) = LINE.get() {
        line.set_style(ProgressStyle::with_template(template).expect("a good template"));
        line.set_position(0);
        match length {
            Some(length) => line.set_length(length),
            None => line.unset_length(),
        }
    }
}
