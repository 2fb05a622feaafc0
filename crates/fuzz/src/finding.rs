//! A case that broke a rule, as it is told and kept.

use std::fs;
use std::path::Path;

use crate::Error;
use crate::check::Fault;

/// A case and what it broke.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The seed of the run.
    pub seed: u64,
    /// The case.
    pub case: u64,
    /// The fixture, and what was changed.
    pub told: String,
    /// The command lines, the last of which broke the rules.
    pub commands: Vec<String>,
    /// How.
    pub faults: Vec<Fault>,
    /// What the program said.
    pub stderr: String,
    /// The files that it was given, by name.
    pub files: Vec<(String, Vec<u8>)>,
}

impl Finding {
    /// What makes findings alike: the program, the rules and the words without their numbers.
    pub fn likeness(&self) -> String {
        let command =
            self.commands.last().map_or("", |command| command.split(' ').next().unwrap_or_default());
        let faults: Vec<String> = self.faults.iter().map(ToString::to_string).collect();
        let text = format!("{command} {}", faults.join("; "));
        let text: String = text.chars().filter(|c| !c.is_ascii_digit()).take(120).collect();
        text
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
