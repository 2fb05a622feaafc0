//! What no program may do, whatever it reads.

pub mod json;
mod words;

use crate::commands::Writes;
use crate::finding::{Fault, Rule};
use crate::run::{End, Ended};
use json::Schemas;

pub struct Run {
    pub asked: String,
    pub ended: Ended,
    /// Files that are new or of another size.
    pub changed: Vec<String>,
    /// What it wrote, if it succeeded: standard output or a file.
    pub written: Vec<u8>,
}

/// All faults of a run that writes such a thing where it succeeds. What it read and its command line may be
/// repeated in its words.
pub fn faults(run: &Run, writes: Writes, read: &[u8], schemas: &Schemas) -> Vec<Fault> {
    let Run { asked, ended, changed, written } = run;
    let mut faults = Vec::new();
    if let Some(line) = ended.stderr.lines().find(|line| line.contains("panicked at")) {
        let message = ended.stderr.lines().skip_while(|other| *other != line).nth(1).unwrap_or_default();
        faults.push(Fault::new(Rule::Panic, format!("{} {message}", line.trim())));
    }
    let last = ended.stderr.lines().last().unwrap_or_default();
    match ended.end {
        End::Hang => faults.push(Fault::new(Rule::Hang, "not done in its time")),
        End::Signal(signal) => faults.push(Fault::new(Rule::Signal, format!("signal {signal}: {last}"))),
        End::Code(0) => {
            let none = |text: &str, place: &str| {
                let found = words::no_number(text, read, asked)?;
                Some(Fault::new(Rule::NotANumber, format!("{place}: {found}")))
            };
            faults.extend(none(&ended.stderr, "on standard error"));
            if writes != Writes::Text {
                faults.extend(schemas.faults(writes, written, read));
            } else if !written.starts_with(b"PAR1") {
                faults.extend(none(&words::shown(&String::from_utf8_lossy(written)), "in what it wrote"));
            }
        }
        End::Code(1 | 2) => faults.extend(words::message(&ended.stderr, read, asked)),
        End::Code(101) if !faults.is_empty() => {}
        End::Code(code) => faults.push(Fault::new(Rule::Code, format!("exit code {code}: {last}"))),
    }
    let is_done = ended.end == End::Code(0);
    if !is_done && !ended.stdout.is_empty() {
        let found = format!("{} bytes on standard output beside a failure", ended.stdout.len());
        faults.push(Fault::new(Rule::LeftBehind, found));
    }
    let beside = if is_done { "what is done" } else { "a failure" };
    let left = changed.iter().filter(|name| !is_done || name.ends_with(".part"));
    faults.extend(left.map(|name| Fault::new(Rule::LeftBehind, format!("{name} beside {beside}"))));
    faults
}
