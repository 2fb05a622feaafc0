//! All fixtures, by what they are.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

use crate::Error;
use crate::draw::Draw;
use crate::kind::FileKind;
use crate::programs::Programs;
use crate::run::{self, End};

/// A file to begin with.
#[derive(Clone, Debug)]
pub struct Seed {
    /// Its path below `fixtures`, or how it was made.
    pub name: String,
    pub kind: FileKind,
    pub bytes: Vec<u8>,
    /// The same, where it is one JSON value.
    pub value: Option<Value>,
}

impl Seed {
    pub fn new(name: impl Into<String>, kind: FileKind, bytes: Vec<u8>) -> Self {
        let value = if kind.is_json() { serde_json::from_slice(&bytes).ok() } else { None };
        Self { name: name.into(), kind, bytes, value }
    }
}

#[derive(Clone, Debug, Default)]
pub struct Corpus {
    pub fixtures: PathBuf,
    pub seeds: Vec<Seed>,
}

impl Corpus {
    /// All files below a folder that a program reads.
    pub fn read(fixtures: &Path) -> Result<Self, Error> {
        let fixtures = fs::canonicalize(fixtures).map_err(|e| Error::file(fixtures, "read", e))?;
        let mut files = Vec::new();
        below(&fixtures, &mut files)?;
        files.sort();
        let mut seeds = Vec::new();
        for path in files {
            let name = path.strip_prefix(&fixtures).unwrap_or(&path).to_string_lossy().replace('\\', "/");
            let bytes = fs::read(&path).map_err(|e| Error::file(&path, "read", e))?;
            if let Some(kind) = FileKind::of(&name, &bytes) {
                seeds.push(Seed::new(name, kind, bytes));
            }
        }
        seeds.push(Seed::new("orientations", FileKind::Orientations, ORIENTATIONS.into()));
        Ok(Self { fixtures, seeds })
    }

    /// One for a program: mostly a good one that was made for it, sometimes a bad one or any of its kind.
    pub fn choose(&self, kind: FileKind, program: &str, draw: &mut Draw) -> &Seed {
        let is_near = |seed: &Seed| near(program).iter().any(|part| seed.name.contains(part));
        let any: Vec<&Seed> = self.seeds.iter().filter(|seed| seed.kind == kind).collect();
        let near = any.iter().copied().filter(|seed| is_near(seed));
        let (bad, good): (Vec<&Seed>, Vec<&Seed>) = near.partition(|seed| seed.name.contains("bad/"));
        let choices: [(usize, &[&Seed]); 3] = [(80, &good), (8, &bad), (12, &any)];
        let list = *draw.weighted::<&[&Seed]>(&choices);
        let list = if list.is_empty() { &any } else { list };
        list[draw.below(list.len())]
    }

    pub fn any_value(&self, kind: FileKind, draw: &mut Draw) -> Option<&Value> {
        let own = self.seeds.iter().filter(|seed| seed.kind == kind);
        let all: Vec<&Value> = own.filter_map(|seed| seed.value.as_ref()).collect();
        if all.is_empty() { None } else { Some(*draw.of(&all)) }
    }
}

/// What stands in the names of fixtures with something for a program.
fn near(program: &str) -> &'static [&'static str] {
    match program {
        "coilcal" => &["coilcal/", "simulate/every-procedure/expected", "specs/calibrated/input", "made"],
        "sensorcal" => &["sensorcal/", "simulate/every-procedure/expected", "specs/calibrated/input"],
        "axescal" => &["axescal/", "nasa-1977/", "simulate/", "bad/axes", "made"],
        "diffmag" => &["diffmag/", "ingest/", "made"],
        "absolute" => &["absolute/", "ingest/absolute"],
        "starcal" => &["starcal/", "scalarcal/three-orbits"],
        "diagnose" => &["diagnose/", "correct/flight", "simulate/replay"],
        "correct" => &["correct/", "diagnose/warm", "axescal/magsat"],
        "report" => &["expected", "specs/", "bad/report/"],
        "simulate" => &["plans/", "simulate/", "diagnose/", "correct/flight", "campaign_plan"],
        "series" => &["ingest/", "diffmag/", "made"],
        "ingest" => &["ingest/", "real/", "tables/"],
        _ => &[],
    }
}

fn below(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), Error> {
    for entry in fs::read_dir(folder).map_err(|e| Error::file(folder, "read", e))? {
        let path = entry.map_err(|e| Error::file(folder, "read", e))?.path();
        if path.is_dir() {
            below(&path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
}

const ORIENTATIONS: &str = "[[[1,0,0],[0,1,0],[0,0,1]],[[0,1,0],[-1,0,0],[0,0,1]],[[-1,0,0],[0,-1,0],[0,0,1]],\
    [[0,-1,0],[1,0,0],[0,0,1]],[[1,0,0],[0,0,1],[0,-1,0]],[[0,0,1],[0,1,0],[-1,0,0]]]";

/// Processor time of a program that makes one, s: the builds of tests are not optimised.
const PROCESSOR_S: u64 = 600;
/// Each with the command line that makes it.
const MADE: [(FileKind, &str); 5] = [
    (FileKind::Piece, "diffmag stream --partial fixtures/diffmag/pieces/morning.csv"),
    (FileKind::Piece, "diffmag stream --partial fixtures/diffmag/pieces/evening.csv"),
    (FileKind::Piece, "scalarcal stream --partial fixtures/scalarcal/pieces/morning.csv"),
    (FileKind::Document, "simulate campaign fixtures/plans/magsat-axes.json"),
    (FileKind::Mapping, "ingest guess fixtures/ingest/field.csv"),
];

/// Adds files that only the programs can make.
pub fn add_made(corpus: &mut Corpus, programs: &Programs) -> Result<(), Error> {
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
