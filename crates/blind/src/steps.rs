//! The steps of a proof, each a run of its own: make, answer, score.

use concealed::case::Case;
use concealed::sets::Set;
use testkit::programs::Programs;

use crate::Error;
use crate::arguments::{Answer, Make, Scoring};
use crate::campaigns::{self, Campaign};
use crate::folder::{Asked, Folder};
use crate::history;
use crate::hosted;
use crate::hosts;
use crate::methods;
use crate::page::{self, Besides};
use crate::score::Score;
use crate::seal;

/// Makes cases and seals their truths. Gives the commitment.
pub fn make(asked: &Make) -> Result<String, Error> {
    let seed = match asked.seed {
        Some(seed) => seed,
        // As large as a number in JSON that every reader takes.
        None => getrandom::u32().map(u64::from).map_err(|error| {
            Error::Common(common::Error::Request(format!("the system gave no random number: {error}")))
        })?,
    };
    let sets: &[Set] = if asked.set.is_empty() { &Set::SCORE } else { &asked.set };
    let count = |set: Set| match (set, asked.cases) {
        // Every name is taken out, whatever else there is.
        (Set::Removed, _) | (_, None) => set.round() * asked.rounds,
        (_, Some(most)) => most.min(set.round() * asked.rounds),
    };
    let mut cases: Vec<Case> = sets.iter().flat_map(|set| set.cases(seed, count(*set))).collect();
    let folder = Folder::at(&asked.output)?;
    if let Some(recordings) = &asked.recordings {
        cases.extend(hosts::cases(&folder, recordings, asked, seed)?);
    }
    seal::seal(&folder, &cases, &asked.truths)?;
    seal::commitment(&folder)
}

/// Has diagnose answer every document, and the methods beside it. What ends with an error, or takes too long,
/// stands as an answer without a diagnosis.
pub fn answer(asked: &Answer) -> Result<usize, Error> {
    let programs = Programs::find(asked.programs.as_deref())?;
    let folder = Folder::at(&asked.folder)?;
    let stored = seal::stored(&folder)?;
    folder.answer_all(&Asked::diagnose(&programs), stored.keys())?;
    methods::answer(&folder, &programs, stored.keys())?;
    Ok(stored.len())
}

/// Opens the truths, scores the answers of a build and writes the page.
pub fn score(asked: &Scoring) -> Result<Score, Error> {
    let programs = Programs::find(asked.programs.as_deref())?;
    let folder = Folder::at(&asked.folder)?;
    let diagnose = Asked::diagnose(&programs);
    let answers = folder.answers(diagnose.name, diagnose.arguments, &programs)?;
    let truths = seal::open(&folder, &asked.truths, &answers)?;
    let score = Score::of(truths, &answers, seal::commitment(&folder)?)?;
    let others = methods::scores(&folder, &programs, &asked.truths)?;
    let campaign = Campaign {
        seed: score.outcomes.first().map_or(0, |outcome| outcome.truth.seed),
        folder: asked.folder.clone(),
        programs: asked.programs.clone(),
    };
    let section =
        |of: fn(&Campaign) -> Result<String, Error>| (!asked.cases_only).then(|| of(&campaign)).transpose();
    let besides = Besides {
        methods: methods::section(&score, &others),
        orbit: section(campaigns::orbit)?,
        month: section(campaigns::month)?,
        real: page::real::of(&score, &hosts::tried(&folder)?, &answers)?,
    };
    let (text, pictures) = page::of(&score, &besides);
    let beside = asked.output.with_extension("");
    std::fs::create_dir_all(&beside).map_err(|source| Error::file(&beside, "written", source))?;
    for (name, svg) in pictures {
        program::pipe::write(Some(&beside.join(name)), &svg)?;
    }
    program::pipe::write(Some(&asked.output), &text)?;
    history::add(&beside.join("history.md"), &score)?;
    Ok(score)
}

/// The goals in a few lines, for people.
pub fn summary(score: &Score) -> String {
    let line = |goal: crate::score::Goal| {
        format!("  {}: {} (wanted: {}): {}\n", goal.what, goal.found.words(), goal.wanted(), goal.verdict())
    };
    let lines: String = score.goals().into_iter().chain(hosted::goals(score)).map(line).collect();
    format!("blind: {} cases\n{lines}", score.cases())
}
