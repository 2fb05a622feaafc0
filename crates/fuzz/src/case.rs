//! One case: a command line, and the files that it reads.

use serde_json::{Value, json};

use crate::commands::{KINDS, LINES, Line, OPTIONS, Writes};
use crate::corpus::{Corpus, Seed};
use crate::draw::Draw;
use crate::kind::FileKind;
use crate::mutate;

#[derive(Clone, Debug)]
pub struct Case {
    pub words: Vec<String>,
    /// Files by name, that which was changed first.
    pub files: Vec<(String, Vec<u8>)>,
    /// Whether the changed file comes on standard input.
    pub on_stdin: bool,
    /// The fixture, and what was changed.
    pub told: String,
}

/// The command line of a case, which its first choices say.
pub fn line(draw: &mut Draw) -> Line {
    let kind = *draw.weighted(&KINDS);
    let lines: Vec<(usize, Line)> =
        LINES.iter().filter(|line| line.kind == kind).map(|line| (line.weight, *line)).collect();
    *draw.weighted(&lines)
}

impl Case {
    /// What the further choices make of a command line.
    pub fn make(line: Line, corpus: &Corpus, draw: &mut Draw) -> Self {
        let seed = corpus.choose(line.kind, line.program(), draw);
        let (bytes, edits) = mutate::changed(seed, corpus, draw);
        let file = line.kind.file();
        let fixtures = corpus.fixtures.to_string_lossy();
        let mut words: Vec<String> = line
            .words
            .split(' ')
            .map(|word| match word {
                "IN" => file.into(),
                "AROUND" => "around.json".into(),
                _ if word.starts_with("OUT") => word.replacen("OUT", "out", 1),
                _ => word.replacen("fixtures/", &format!("{fixtures}/"), 1),
            })
            .collect();
        if let Some((_, options)) = OPTIONS.iter().find(|(begins, _)| line.words.starts_with(begins))
            && draw.chance(if line.kind == FileKind::Orientations { 80 } else { 12 })
        {
            for word in draw.part(options).split(' ') {
                let mut word = word.to_string();
                while word.contains('#') {
                    word = word.replacen('#', draw.part(mutate::values::TYPED), 1);
                }
                // Without what no command line can hold.
                let given = mutate::values::word(draw).replace('\0', "");
                words.push(word.replace('@', &given.chars().take(2000).collect::<String>()));
            }
        }
        if line.writes == Writes::Document && !line.words.contains("OUT") {
            // A stage that reads one document from a file can replace it.
            let is_stage = line.kind == FileKind::Document && line.words.ends_with(" IN");
            let in_place = is_stage && !line.words.contains("fixtures/");
            let in_place = if in_place { "-o in.json --in-place" } else { "" };
            let to = *draw.weighted(&[(84, ""), (13, "-o out.json"), (3, in_place)]);
            words.extend(to.split_whitespace().map(String::from));
        }
        let mut files = vec![(file.to_string(), bytes)];
        if line.words.contains("AROUND") {
            files.push(("around.json".into(), around(corpus)));
        }
        let on_stdin = line.words.ends_with(" -");
        Self { words, files, on_stdin, told: format!("{}: {}", seed.name, edits.join(", ")) }
    }
}

/// A document whose readings are the changed table beside it.
fn around(corpus: &Corpus) -> Vec<u8> {
    let is_flight = |seed: &&Seed| seed.name == "correct/flight/input.json";
    let mut document =
        corpus.seeds.iter().find(is_flight).and_then(|seed| seed.value.clone()).unwrap_or_default();
    if let Some(recording) = document.pointer_mut("/recordings/0").and_then(Value::as_object_mut) {
        recording.shift_remove("columns");
        recording.insert("table".into(), json!("in.csv"));
    }
    common::to_text(&document).into_bytes()
}
