//! Files to begin with that only the programs can make.

use std::fs;

use crate::Error;
use crate::corpus::{Corpus, Seed};
use crate::kind::FileKind;
use crate::programs::Programs;
use crate::run::{self, End};

/// Processor time of one of them, s: the builds of tests are not optimised.
const PROCESSOR_S: u64 = 600;
/// Each with the command line that makes it.
const MADE: [(FileKind, &str); 5] = [
    (FileKind::Piece, "diffmag stream --partial fixtures/diffmag/pieces/morning.csv"),
    (FileKind::Piece, "diffmag stream --partial fixtures/diffmag/pieces/evening.csv"),
    (FileKind::Piece, "scalarcal stream --partial fixtures/scalarcal/pieces/morning.csv"),
    (FileKind::Document, "simulate campaign fixtures/plans/magsat-axes.json"),
    (FileKind::Mapping, "ingest guess fixtures/ingest/field.csv"),
];

/// Adds them to the fixtures.
pub fn add(corpus: &mut Corpus, programs: &Programs) -> Result<(), Error> {
    let folder = tempfile::tempdir().map_err(|e| Error::file("a temporary folder", "written", e))?;
    let fixtures = format!("{}/", corpus.fixtures.display());
    for (kind, line) in MADE {
        let words: Vec<String> =
            line.split(' ').map(|word| word.replacen("fixtures/", &fixtures, 1)).collect();
        let (program, folder) = (programs.path(&words[0]), folder.path());
        let done = run::run(&program, &words[1..], (folder, folder), None, PROCESSOR_S)?;
        if done.end != End::Code(0) {
            return Err(Error::Request(format!("{line}: {:?}, {}", done.end, done.stderr.trim())));
        }
        corpus.seeds.push(Seed::new(format!("made by {line}"), kind, done.stdout));
    }
    // What the programs made depends on their version; the folder is empty again.
    fs::remove_dir_all(folder.path()).map_err(|e| Error::file(folder.path(), "written", e))
}
