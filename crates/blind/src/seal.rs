//! Truths are sealed before anything is answered, and opened once.
//!
//! A folder of cases holds the documents, what whoever answers is told besides (`arguments.json`), the digest
//! of each truth (`seals.txt`) and the answers; the truths are in a file apart, which whoever answers need
//! not have. The digest of `seals.txt` is the commitment. The first opening notes the digests of the answers
//! that are there (`opened.json`); answers that come later are refused.

use concealed::case::{Case, Truth};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::Error;
use crate::folder::{self, Arguments, Folder, digest, read, write};

/// Truths as they were sealed: the text of each by its case.
pub type Truths = BTreeMap<String, String>;

/// Writes the documents and the digests of the truths to a folder, and the truths to a file.
pub fn seal(folder: &Folder, cases: &[Case], truths: &Path) -> Result<(), Error> {
    let mut texts = Truths::new();
    for Case { document, truth } in cases {
        folder.write(&truth.case, document)?;
        texts.insert(truth.case.clone(), json(truths, truth)?);
    }
    let told = cases.iter().map(|case| (case.truth.case.clone(), arguments(&case.truth)));
    let told: Arguments = told.filter(|(_, arguments)| !arguments.is_empty()).collect();
    if !told.is_empty() {
        folder.write_arguments(&told)?;
    }
    let lines = texts.iter().map(|(case, text)| format!("{}  {case}\n", digest(text.as_bytes())));
    write(&seals(folder), &lines.collect::<String>())?;
    write(truths, &(json(truths, &texts)? + "\n"))
}

/// What whoever answers is told for a case: the entries that are taken out of its catalogue.
pub fn arguments(truth: &Truth) -> Vec<String> {
    truth.without.iter().map(|name| format!("--without={name}")).collect()
}

/// SHA-256 of the seals: whoever has it can check later that nothing was changed.
pub fn commitment(folder: &Folder) -> Result<String, Error> {
    Ok(digest(read(&seals(folder))?.as_bytes()))
}

/// The cases with the digests of their truths.
pub fn stored(folder: &Folder) -> Result<BTreeMap<String, String>, Error> {
    let text = read(&seals(folder))?;
    let pair = |line: &str| line.split_once("  ").map(|(seal, case)| (case.to_string(), seal.to_string()));
    Ok(text.lines().filter_map(pair).collect())
}

/// Opens the truths for some answers.
///
/// # Errors
///
/// A truth that is not the one that was sealed; a document without an answer; answers that were not there
/// when the truths were first opened.
pub fn open(folder: &Folder, truths: &Path, answers: &Path) -> Result<Vec<Truth>, Error> {
    let texts: Truths = folder::value(truths)?;
    let stored = stored(folder)?;
    let mut opened = Vec::new();
    for (case, sealed) in &stored {
        let text = texts.get(case).map_or("", String::as_str);
        let found = digest(text.as_bytes());
        if found != *sealed {
            return Err(refused(format!(
                "{}: the truth of {case} has SHA-256 {found}; expected {sealed}, as seals.txt has it. Make the set again",
                truths.display()
            )));
        }
        opened.push(serde_json::from_str(text).map_err(|source| Error::file(truths, "read", source.into()))?);
    }
    let note = folder.path().join("opened.json");
    let own = answers.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let now = digest_of_answers(answers, &stored)?;
    if note.is_file() {
        let known: BTreeMap<String, String> = folder::value(&note)?;
        if known.get(&own) != Some(&now) {
            return Err(refused(format!(
                "{}: these answers were not there when the truths were opened ({}); make a fresh set for them with blind make",
                answers.display(),
                note.display()
            )));
        }
    } else {
        let mut there = BTreeMap::from([(own, now)]);
        for other in folder.answers_there()? {
            // Answers that are not complete are not answers yet.
            if let Ok(digest) = digest_of_answers(&other, &stored) {
                let name = other.file_name().map(|name| name.to_string_lossy().into_owned());
                there.insert(name.unwrap_or_default(), digest);
            }
        }
        write(&note, &(json(&note, &there)? + "\n"))?;
    }
    Ok(opened)
}

fn refused(words: String) -> Error {
    common::Error::Request(words).into()
}

fn digest_of_answers(answers: &Path, stored: &BTreeMap<String, String>) -> Result<String, Error> {
    let mut all = String::new();
    for case in stored.keys() {
        all += &digest(read(&answers.join(format!("{case}.json")))?.as_bytes());
    }
    Ok(digest(all.as_bytes()))
}

fn seals(folder: &Folder) -> PathBuf {
    folder.path().join("seals.txt")
}

fn json(path: &Path, value: &impl serde::Serialize) -> Result<String, Error> {
    serde_json::to_string_pretty(value)
        .map_err(|source| Error::file(path, "written", std::io::Error::other(source)))
}
