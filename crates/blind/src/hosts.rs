//! Real recordings that show nothing, and what is concealed in them.
//!
//! A candidate is a host where diagnose says `agrees` of it as it came, before anything is injected. All that
//! were tried stand in `hosts.json` beside the documents, with what diagnose said.

use concealed::case::Case;
use injected::{CANDIDATES, Candidate, Host, injected, untouched};
use program::pipe;
use rayon::prelude::*;
use recorded::Stages;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use testkit::programs::Programs;

use crate::Error;
use crate::arguments::Make;
use crate::folder::{self, Asked, Folder};
use crate::verdict::Outcome;

/// A recording that was tried.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Tried {
    /// Its name.
    pub name: String,
    /// What it is.
    pub words: String,
    /// Where it comes from.
    pub source: String,
    /// Its rows.
    pub rows: usize,
    /// Rms of what the basic model leaves of it, nT.
    pub scatter_nt: f64,
    /// What diagnose says of it as it came.
    pub said: String,
    /// Whether it is a host.
    pub host: bool,
}

/// All that were tried for a folder; none where it has no real recordings.
pub fn tried(folder: &Folder) -> Result<Vec<Tried>, Error> {
    let path = list(folder);
    if path.is_file() { folder::value(&path) } else { Ok(Vec::new()) }
}

fn list(folder: &Folder) -> PathBuf {
    folder.path().join("hosts.json")
}

/// The hosts as they came and with effects injected. A folder or a set that is missing is told and left out.
pub fn cases(folder: &Folder, recordings: &Path, asked: &Make, seed: u64) -> Result<Vec<Case>, Error> {
    if !recordings.is_dir() {
        let words =
            format!("{}: no folder of recordings; nothing is concealed in real ones", recordings.display());
        pipe::say(&format!("blind: {words}\n"));
        return Ok(Vec::new());
    }
    let programs = Programs::find(asked.programs.as_deref())?;
    let stages = Stages::new(programs.clone(), recordings)?;
    let beside = Folder::at(&folder.path().join("hosts"))?;
    let (there, missing): (Vec<&Candidate>, Vec<&Candidate>) =
        CANDIDATES.iter().partition(|candidate| recordings.join(candidate.folder).is_dir());
    for candidate in missing {
        pipe::say(&format!("blind: {} left out: no folder {}\n", candidate.name, candidate.folder));
    }
    let one = |candidate: &&'static Candidate| -> Result<Option<(Tried, Vec<Case>)>, Error> {
        let series = (candidate.read)(&stages)?;
        let Some(host) = Host::of(candidate, &series) else { return Ok(None) };
        let untouched = untouched(&host, seed);
        let (host_said, agrees) = answered(&beside, &programs, &untouched)?;
        let tried = Tried {
            name: candidate.name.into(),
            words: candidate.words.into(),
            source: candidate.source.into(),
            rows: host.rows(),
            scatter_nt: host.scatter_nt,
            said: host_said,
            host: agrees,
        };
        let mut cases = Vec::new();
        if agrees {
            cases.push(untouched);
            cases.extend((0..asked.rounds).flat_map(|round| injected(&host, seed, round, asked.each)));
        }
        Ok(Some((tried, cases)))
    };
    let all = there.par_iter().map(one).collect::<Result<Vec<_>, Error>>()?;
    let (tried, cases): (Vec<Tried>, Vec<Vec<Case>>) = all.into_iter().flatten().unzip();
    let text = serde_json::to_string_pretty(&tried)
        .map_err(|source| Error::file(list(folder), "written", std::io::Error::other(source)))?;
    folder::write(&list(folder), &(text + "\n"))?;
    Ok(cases.into_iter().flatten().collect())
}

/// What diagnose says of a host as it came, and whether that is nothing.
fn answered(folder: &Folder, programs: &Programs, untouched: &Case) -> Result<(String, bool), Error> {
    let (asked, case) = (Asked::diagnose(programs), &untouched.truth.case);
    folder.write(case, &untouched.document)?;
    let answers = folder.answers(asked.name, asked.arguments, asked.programs)?;
    match folder.answer(&asked, case, &answers) {
        Ok(_) => {
            let answer = folder::value(&answers.join(format!("{case}.json")))?;
            let outcome = Outcome::of(untouched.truth.clone(), &answer);
            Ok((outcome.said(), outcome.verdict == "agrees"))
        }
        Err(Error::Program { words, .. }) => Ok((words, false)),
        Err(error) => Err(error),
    }
}
