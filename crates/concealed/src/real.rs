//! Recordings that somebody else made, through the programs as they are shipped.
//!
//! Each set answers the question that it can answer: fitted on one part, held against another that the fit never saw (a later time, another
//! run), and told in the words that its evidence allows. The recordings are not in this repository; where the folder is missing, the page
//! says so.

mod affine;
mod by_hand;
mod page;
mod plot;
mod series;
mod sets;
mod split;
mod stages;

use clap::Args;
use common::pipe;
use rayon::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};

use crate::Error;
use crate::programs::Programs;
use page::Page;
pub use sets::{SETS, Set};
use stages::Stages;

/// What is asked of real recordings.
#[derive(Args, Clone, Debug)]
pub struct Arguments {
    /// A set, by its name; absent: all
    #[arg(value_name = "NAME")]
    pub name: Option<String>,
    /// The folder of the recordings
    #[arg(long, value_name = "FOLDER", default_value = "../shared/data")]
    pub data: PathBuf,
    /// Where the stages' programs are; absent: beside this one
    #[arg(long, value_name = "FOLDER")]
    pub programs: Option<PathBuf>,
    /// Where plots go; absent: none are written
    #[arg(long, value_name = "FOLDER")]
    pub plots: Option<PathBuf>,
    /// Write to this file instead of standard output
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Runs the sets and writes their section of the page.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let programs = Programs::find(arguments.programs.as_deref())?;
    let text = section(&arguments.data, programs, arguments.name.as_deref(), arguments.plots.as_deref())?;
    Ok(pipe::write(arguments.output.as_deref(), &text)?)
}

/// The section on real recordings, as markdown; plots go to the folder `plots` under the names by which the section shows them
/// (`proof/….svg`). The same recordings and programs give the same bytes.
///
/// # Errors
/// A name that no set has, a file of a set that is missing, a program that is missing. That a stage refuses is a finding.
pub fn section(
    data: &Path,
    programs: Programs,
    name: Option<&str>,
    plots: Option<&Path>,
) -> Result<String, Error> {
    let sets: Vec<&Set> = SETS.iter().filter(|set| name.is_none_or(|name| name == set.name)).collect();
    if sets.is_empty() {
        let names: Vec<&str> = SETS.iter().map(|set| set.name).collect();
        let words = format!("no set of that name; expected one of {}", names.join(", "));
        return Err(Error::Common(common::Error::Request(words)));
    }
    let stages = Stages::new(programs, data)?;
    let found = |set: &&Set| -> Result<Option<Page>, Error> {
        if data.join(set.folder).is_dir() { (set.run)(&stages).map(Some) } else { Ok(None) }
    };
    let pages = sets.par_iter().map(found).collect::<Result<Vec<_>, Error>>()?;
    let mut text = INTRODUCTION.to_string();
    for (set, page) in sets.iter().zip(&pages) {
        text += &format!("### {}\n\n", set.title);
        match page {
            Some(page) => {
                text += &format!("{}Source: {}. `concealed real {}`\n\n", page.text, set.source, set.name)
            }
            None => text += &format!("Not run: no folder `{}` with the recordings.\n\n", set.folder),
        }
    }
    if let Some(folder) = plots {
        fs::create_dir_all(folder).map_err(|source| Error::file(folder, "written", source))?;
        for (name, svg) in pages.iter().flatten().flat_map(|page| &page.plots) {
            pipe::write(Some(&folder.join(name)), svg)?;
        }
    }
    Ok(text.trim_end().to_string() + "\n")
}

const INTRODUCTION: &str = "## Real recordings

Recorded by others, and not in this repository; each set goes through the programs as they are shipped. Fitted is one part; the other is
predicted without having been seen. *Levels alone* is what is known without any fit: axes and scales alike, mean levels of the fitted part.
± are standard uncertainties.

";
