//! The rules, and a case that broke one, as it is told and kept.

use std::fmt;
use std::fs;
use std::path::Path;

use crate::Error;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rule {
    Panic,
    /// No end by a signal.
    Signal,
    /// An end within the time.
    Hang,
    /// The exit codes are 0, 1 and 2.
    Code,
    /// Nothing is written or left behind where a program fails, and nothing half done ever.
    LeftBehind,
    /// A failure is told in words that are not those of the program's insides.
    Message,
    /// Numbers are numbers: in documents, pages, tables and words.
    NotANumber,
    /// What is written is what its schema says.
    Schema,
    /// What a program writes, the next one reads.
    Refused,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    pub rule: Rule,
    pub found: String,
}

impl Fault {
    pub fn new(rule: Rule, found: impl Into<String>) -> Self {
        Self { rule, found: found.into() }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}: {}", self.rule, self.found)
    }
}

/// A case and what it broke.
#[derive(Clone, Debug)]
pub struct Finding {
    pub(crate) seed: u64,
    pub(crate) case: u64,
    /// The fixture, and what was changed.
    pub(crate) told: String,
    pub(crate) commands: Vec<String>,
    pub(crate) faults: Vec<Fault>,
    pub(crate) stderr: String,
    /// The files that it was given, by name.
    pub(crate) files: Vec<(String, Vec<u8>)>,
}

impl Finding {
    /// What makes findings alike: the program, the rules and the words without their numbers.
    pub fn likeness(&self) -> String {
        let command = self.commands.last().and_then(|command| command.split(' ').next()).unwrap_or_default();
        let faults: Vec<String> = self.faults.iter().map(ToString::to_string).collect();
        let text = format!("{command} {}", faults.join("; "));
        text.chars().filter(|c| !c.is_ascii_digit()).take(120).collect()
    }

    /// As people read it.
    pub fn text(&self) -> String {
        let mut text = format!("seed {}, case {} ({})\n", self.seed, self.case, self.told);
        for command in &self.commands {
            text += &format!("  {command}\n");
        }
        for fault in &self.faults {
            text += &format!("  {fault}\n");
        }
        text + &format!("  again: fuzz --seed {} --case {}\n", self.seed, self.case)
    }

    /// Writes the files and what is told of them into a folder of the case.
    pub fn keep(&self, folder: &Path) -> Result<(), Error> {
        let folder = folder.join(format!("{}-{}", self.seed, self.case));
        fs::create_dir_all(&folder).map_err(|e| Error::file(&folder, "written", e))?;
        let write = |name: &str, bytes: &[u8]| {
            let path = folder.join(name);
            fs::write(&path, bytes).map_err(|e| Error::file(path, "written", e))
        };
        write("finding.txt", format!("{}\n{}", self.text(), self.stderr).as_bytes())?;
        self.files.iter().try_for_each(|(name, bytes)| write(name, bytes))
    }
}
