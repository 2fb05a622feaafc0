//! The rules, and what broke one.

use std::fmt;

/// A rule that was broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rule {
    /// No panic.
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

/// A broken rule, with what broke it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Which.
    pub rule: Rule,
    /// How.
    pub found: String,
}

impl Fault {
    /// A fault against a rule.
    pub fn new(rule: Rule, found: impl Into<String>) -> Self {
        Self { rule, found: found.into() }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}: {}", self.rule, self.found)
    }
}
