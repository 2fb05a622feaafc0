//! Recordings that somebody else made, through the programs as they are shipped.
//!
//! Each set answers the question that it can answer: fitted on one part, held against another that the fit
//! never saw (a later time, another run), and told in the words that its evidence allows. The recordings are
//! not in this repository; where the folder is missing, the page says so.

mod affine;
mod by_hand;
mod by_hand_pair;
mod known;
mod markdown;
mod page;
mod plot;
mod prediction;
mod series;
mod sets;
mod split;
mod stages;

use clap::Args;
use program::pipe;
use rayon::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};

pub use affine::least_squares;
use page::Page;
pub use series::Series;
pub use sets::{SETS, Set};
pub use stages::Stages;
pub use testkit::programs::Error;
use testkit::programs::Programs;

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
    let recorded = recorded(&arguments.data, programs, arguments.name.as_deref())?;
    match &arguments.output {
        Some(output) => recorded.write(output),
        None => Ok(pipe::write(None, &recorded.text)?),
    }
}

/// What came of the sets.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// A table with a sentence for each set, as markdown.
    pub summary: String,
    /// The page, as markdown.
    pub text: String,
    /// Its plots by file name.
    pub plots: Vec<(String, String)>,
}

impl Recorded {
    /// Writes the page with its plots beside it.
    pub fn write(&self, output: &Path) -> Result<(), Error> {
        if let Some(folder) = output.parent().filter(|folder| *folder != Path::new("")) {
            fs::create_dir_all(folder).map_err(|source| Error::file(folder, "written", source))?;
        }
        for (name, svg) in &self.plots {
            pipe::write(Some(&output.with_file_name(name)), svg)?;
        }
        Ok(pipe::write(Some(output), &self.text)?)
    }
}

/// Runs the sets. The same recordings and programs give the same bytes.
///
/// # Errors
/// A name that no set has, a file of a set that is missing, a program that is missing. That a stage refuses is a finding.
pub fn recorded(data: &Path, programs: Programs, name: Option<&str>) -> Result<Recorded, Error> {
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
    let headline = |page: &Option<Page>| page.as_ref().map_or("not run".into(), |page| page.headline.clone());
    let heads = sets.iter().zip(&pages).map(|(set, page)| vec![set.title.to_string(), headline(page)]);
    let mut summary = Page::default();
    summary.table(&["question", "result"], &heads.collect::<Vec<_>>());
    let known = known::table(pages.iter().flatten().flat_map(|page| page.known.clone()));
    let predicted = sets
        .iter()
        .zip(&pages)
        .filter_map(|(set, page)| Some((set.title, page.as_ref()?.predictions.as_slice())));
    let ([hold, of], rows) = prediction::rows(predicted);
    let mut by_hand = Page::default();
    by_hand.say(format!("The programs are within 5 % of it, or better, in {hold} of {of} predictions."));
    by_hand.table(&["held out", "best by hand", "by hand, nT", "programs, nT", "ratio", "within 5 %"], &rows);
    let text = INTRODUCTION.to_string() + &summary.text + BY_HAND + &by_hand.text + KNOWN + &known;
    let mut top = Page { text, ..Page::default() };
    for (set, page) in sets.iter().zip(&pages) {
        top.text += &format!("## {}\n\n", set.title);
        match page {
            Some(page) => top.say(format!("{}Source: {}. `recorded {}`", page.text, set.source, set.name)),
            None => top.say(format!("Not run: no folder `{}` with the recordings.", set.folder)),
        }
    }
    Ok(Recorded {
        summary: summary.text,
        text: top.text.trim_end().to_string() + "\n",
        plots: pages.into_iter().flatten().flat_map(|page| page.plots).collect(),
    })
}

const INTRODUCTION: &str = "# Real recordings

This page is generated by `cargo run --release -p recorded -- -o docs/proof/real.md`. The recordings were made by others and are not in
this repository. Each set goes through the released programs: one part is fitted, the other, held out, is predicted. *Levels alone* means
no fit: equal axes and scales, and the mean levels of the fitted part.
± are standard uncertainties.

";

const BY_HAND: &str = "## By hand

The best prediction of the held-out part that a careful person reaches with a few lines of least squares. For a pair: mean levels; a 3×3 \
        matrix with an offset; the same with a straight drift, with a line in a recorded temperature, and with the test instrument's times \
        shifted by the lag of least scatter. For a vector against a scalar: the level; a level and slopes, or an ellipsoid. For each \
        component the method is chosen that, fitted to the first two thirds of the fitted part, best predicts the last third; the held-out \
        part does not influence the choice. The method is then fitted to the whole fitted part. Figures are the scatter about the mean of \
        the held-out part, for both alike; the tables of the sets show levels that wander.

";

const KNOWN: &str = "## Known from the source

Facts stated in the notes of the recordings, or shown by another instrument. No stage was told of them; whether a fact was found is decided \
        by the program that generates this page, from the output of the stage.

";
