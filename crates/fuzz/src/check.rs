//! What no program may do, whatever it reads.

mod fault;
pub mod json;
pub mod words;

pub use fault::{Fault, Rule};

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::Error;
use crate::commands::Writes;
use crate::run::{End, Ended};
use json::Schemas;

/// The files of a folder, with their sizes.
pub type Listing = BTreeMap<String, u64>;

/// The files of a folder.
pub fn listing(folder: &Path) -> Result<Listing, Error> {
    let failed = |e| Error::file(folder, "read", e);
    let mut files = Listing::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let size = entry.metadata().map_err(failed)?.len();
        files.insert(entry.file_name().to_string_lossy().into_owned(), size);
    }
    Ok(files)
}

/// What a run is judged by.
pub struct Judged<'a> {
    /// What the program did.
    pub ended: &'a Ended,
    /// The files before it ran.
    pub before: &'a Listing,
    /// The files after it ran.
    pub after: &'a Listing,
    /// What it writes where it succeeds.
    pub writes: Writes,
    /// What it wrote, if it succeeded: standard output or a file.
    pub written: &'a [u8],
    /// What it read: what stands there may be repeated.
    pub read: &'a [u8],
    /// Its command line, as one text.
    pub asked: &'a str,
}

/// All faults of a run.
pub fn faults(judged: &Judged<'_>, schemas: &Schemas) -> Vec<Fault> {
    let Judged { ended, before, after, .. } = judged;
    let mut faults = Vec::new();
    if let Some(line) = ended.stderr.lines().find(|line| line.contains("panicked at")) {
        let message = ended.stderr.lines().skip_while(|other| *other != line).nth(1).unwrap_or_default();
        faults.push(Fault::new(Rule::Panic, format!("{} {message}", line.trim())));
    }
    let last = ended.stderr.lines().last().unwrap_or_default();
    match ended.end {
        End::Hang => faults.push(Fault::new(Rule::Hang, "not done in its time")),
        End::Signal(signal) => faults.push(Fault::new(Rule::Signal, format!("signal {signal}: {last}"))),
        End::Code(0) => succeeded(judged, schemas, &mut faults),
        End::Code(1 | 2) => faults.extend(words::message(&ended.stderr, judged.read, judged.asked)),
        End::Code(101) if !faults.is_empty() => {}
        End::Code(code) => faults.push(Fault::new(Rule::Code, format!("exit code {code}: {last}"))),
    }
    if ended.end != End::Code(0) {
        if !ended.stdout.is_empty() {
            let bytes = ended.stdout.len();
            faults.push(Fault::new(
                Rule::LeftBehind,
                format!("{bytes} bytes on standard output beside a failure"),
            ));
        }
        let changed = after.iter().filter(|(name, size)| before.get(*name) != Some(*size));
        faults.extend(
            changed.map(|(name, _)| Fault::new(Rule::LeftBehind, format!("{name} beside a failure"))),
        );
    } else if let Some(name) = after.keys().find(|name| name.ends_with(".part")) {
        faults.push(Fault::new(Rule::LeftBehind, format!("{name} beside what is done")));
    }
    faults
}

/// What holds of a program that succeeded.
fn succeeded(judged: &Judged<'_>, schemas: &Schemas, faults: &mut Vec<Fault>) {
    let none = words::no_number(&judged.ended.stderr, judged.read, judged.asked);
    faults.extend(none.map(|found| Fault::new(Rule::NotANumber, format!("on standard error: {found}"))));
    if judged.writes == Writes::Text {
        if !judged.written.starts_with(b"PAR1") {
            let text = String::from_utf8_lossy(judged.written);
            let none = words::no_number(&text, judged.read, judged.asked);
            faults
                .extend(none.map(|found| Fault::new(Rule::NotANumber, format!("in what it wrote: {found}"))));
        }
    } else {
        faults.extend(schemas.faults(judged.writes, judged.written, judged.read));
    }
}
