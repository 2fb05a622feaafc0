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
    /// Write to this file, with its plots beside it, instead of standard output
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Runs the sets and writes their page.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let programs = Programs::find(arguments.programs.as_deref())?;
    let (text, plots) = page(&arguments.data, programs, arguments.name.as_deref())?;
    if let Some(folder) = arguments.output.as_deref().and_then(Path::parent).filter(|f| *f != Path::new("")) {
        fs::create_dir_all(folder).map_err(|source| Error::file(folder, "written", source))?;
    }
    for (name, svg) in arguments.output.iter().flat_map(|_| &plots) {
        let path = arguments.output.as_deref().unwrap_or(Path::new("")).with_file_name(name);
        pipe::write(Some(&path), svg)?;
    }
    Ok(pipe::write(arguments.output.as_deref(), &text)?)
}

/// The page on real recordings, as markdown, with its plots by file name. The same recordings and programs give the same bytes.
///
/// # Errors
/// A name that no set has, a file of a set that is missing, a program that is missing. That a stage refuses is a finding.
pub fn page(
    data: &Path,
    programs: Programs,
    name: Option<&str>,
) -> Result<(String, Vec<(String, String)>), Error> {
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
    let mut top = Page { text: INTRODUCTION.to_string(), ..Page::default() };
    let headline = |page: &Option<Page>| page.as_ref().map_or("not run".into(), |page| page.headline.clone());
    let heads = sets.iter().zip(&pages).map(|(set, page)| vec![set.title.to_string(), headline(page)]);
    top.table(&["asked", "found"], &heads.collect::<Vec<_>>());
    for (set, page) in sets.iter().zip(&pages) {
        top.text += &format!("## {}\n\n", set.title);
        match page {
            Some(page) => {
                top.say(format!("{}Source: {}. `concealed real {}`", page.text, set.source, set.name))
            }
            None => top.say(format!("Not run: no folder `{}` with the recordings.", set.folder)),
        }
    }
    let plots = pages.into_iter().flatten().flat_map(|page| page.plots).collect();
    Ok((top.text.trim_end().to_string() + "\n", plots))
}

const INTRODUCTION: &str = "# Real recordings

This page is made by `cargo run --release -p concealed -- real -o docs/proof/real.md` and not by hand. Recorded by others, and not in this repository; each set goes through the programs as they are shipped. Fitted is one part; the other is
predicted without having been seen. *Levels alone* is what is known without any fit: axes and scales alike, mean levels of the fitted part.
± are standard uncertainties.

";
