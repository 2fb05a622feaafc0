//! Cases one after another on all cores, so many or until the time is over.

use std::collections::BTreeMap;
use std::fs::{self, DirEntry};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crate::Error;
use crate::case::{self, Case};
use crate::check::json::Schemas;
use crate::check::{self, Run};
use crate::commands::{self, Writes};
use crate::corpus::{self, Corpus};
use crate::draw::Draw;
use crate::finding::{Fault, Finding, Rule};
use crate::follow;
use crate::kind::FileKind;
use crate::programs::Programs;
use crate::run::{self, End};

/// How many further programs may read what one wrote.
const FURTHER: usize = 3;
/// The largest document that goes on, bytes: what a campaign of minutes writes, not one of a million
/// readings.
const LARGEST: usize = 8_000_000;
/// Stack of each worker: values are nested up to 3000 deep, and are dropped one within the other.
const STACK: usize = 1 << 26;

/// What is run.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Where all choices come from.
    pub seed: u64,
    /// The cases by their numbers.
    pub cases: Range<u64>,
    /// How long no longer; absent: until all cases are done.
    pub time: Option<Duration>,
    /// Processor time of one program, s. Other work on the machine does not add to it.
    pub processor_s: u64,
    /// The cases of one program alone, as they are numbered among all.
    pub only: Option<String>,
    /// Where the files of findings are kept.
    pub keep: Option<PathBuf>,
}

/// What was run, and what was found.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    /// Cases.
    pub cases: u64,
    /// Runs by program and how they ended.
    pub runs: BTreeMap<(String, String), u64>,
    /// All that broke a rule, in the order of cases.
    pub findings: Vec<Finding>,
}

/// Programs, fixtures and schemas.
pub struct Session {
    programs: Programs,
    corpus: Corpus,
    schemas: Schemas,
}

impl Session {
    /// With the fixtures of the workspace.
    pub fn new(programs: Programs) -> Result<Self, Error> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut corpus = Corpus::read(&root.join("fixtures"))?;
        corpus::add_made(&mut corpus, &programs)?;
        Ok(Self { programs, corpus, schemas: Schemas::read(&root.join("schemas"))? })
    }

    /// Runs cases, and tells each finding as it comes by `tell`.
    pub fn run(&self, settings: &Settings, tell: impl Fn(&Finding) + Sync) -> Result<Summary, Error> {
        let (next, begun) = (AtomicU64::new(settings.cases.start), Instant::now());
        let summary = Mutex::new(Summary::default());
        let work = || -> Result<(), Error> {
            while settings.time.is_none_or(|time| begun.elapsed() < time) {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if !settings.cases.contains(&number) {
                    break;
                }
                let Some(done) = self.case(settings, number)? else { continue };
                if let Some(finding) = &done.finding {
                    tell(finding);
                    settings.keep.iter().try_for_each(|folder| finding.keep(folder))?;
                }
                let mut summary = summary.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
                summary.cases += 1;
                done.runs.into_iter().for_each(|run| *summary.runs.entry(run).or_default() += 1);
                summary.findings.extend(done.finding);
            }
            Ok(())
        };
        let cores = thread::available_parallelism().map_or(1, usize::from);
        thread::scope(|scope| {
            let workers: Vec<_> = (0..cores)
                .map(|_| thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work))
                .collect::<Result<_, _>>()
                .map_err(|e| Error::Request(format!("no thread: {e}")))?;
            let mut ended = workers.into_iter().map(|worker| worker.join());
            ended.try_for_each(|ended| {
                ended.unwrap_or_else(|_| Err(Error::Request("a thread panicked; see above".into())))
            })
        })?;
        let mut summary = summary.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
        summary.findings.sort_by_key(|finding| finding.case);
        Ok(summary)
    }

    /// One case with the programs after it. Absent: it is not one of those that are asked for.
    fn case(&self, settings: &Settings, number: u64) -> Result<Option<Done>, Error> {
        let mut draw = Draw::new(settings.seed, number);
        let line = case::line(&mut draw);
        if settings.only.as_deref().is_some_and(|only| only != line.program()) {
            return Ok(None);
        }
        let case = Case::make(line, &self.corpus, &mut draw);
        let mut place = Place::new(&self.programs, settings.processor_s)?;
        let mut files = case.files;
        place.clear(&files)?;
        let stdin = case.on_stdin.then(|| place.folder.join(line.kind.file()));
        let first = place.run(&case.words, stdin.as_deref())?;
        let mut read = files[0].1.clone();
        let mut faults = self.judge(&place, &first, line.writes, &read);
        if first.ended.end == End::Code(0) && place.folder.join("out-truth.json").is_file() {
            let truth = fs::read(place.folder.join("out-truth.json")).unwrap_or_default();
            faults.extend(self.schemas.of_truth(&truth));
        }
        let mut last = first;
        let mut program = line.program();
        let mut writes = line.writes;
        let mut is_document = line.kind == FileKind::Document;
        for _ in 0..FURTHER {
            let after = match (writes, program) {
                (Writes::Piece, "scalarcal") => "scalarcal merge",
                (Writes::Piece, _) => "diffmag merge",
                _ => commands::next(program),
            };
            let reads_on = matches!(writes, Writes::Document | Writes::Piece) && !after.is_empty();
            let is_done = faults.is_empty() && last.ended.end == End::Code(0);
            let goes_on = is_done && reads_on && last.written.len() <= LARGEST;
            if !goes_on || draw.chance(25) {
                break;
            }
            let next = draw.part(after);
            let written = last.written.clone();
            files.push(("next.json".into(), written.clone()));
            let words: Vec<String> = next.split(' ').chain(["next.json"]).map(String::from).collect();
            place.clear(&files)?;
            let done = place.run(&words, None)?;
            let was_document = writes == Writes::Document;
            writes = if next.starts_with("report") { Writes::Text } else { Writes::Document };
            faults = self.judge(&place, &done, writes, &written);
            if done.ended.end == End::Code(2) {
                // Whether the fault was there before.
                let mut then = None;
                if is_document {
                    place.clear(&[("next.json".into(), read.clone())])?;
                    then = Some(place.run(&words, None)?.ended);
                    place.commands.pop();
                }
                faults.extend(follow::refused((&read, then.as_ref()), (&written, &done.ended.stderr)));
            }
            is_document = was_document;
            (program, read, last) = (commands::program(next), written, done);
        }
        let finding = (!faults.is_empty()).then_some(Finding {
            seed: settings.seed,
            case: number,
            told: case.told,
            commands: place.commands,
            faults,
            stderr: last.ended.stderr,
            files,
        });
        Ok(Some(Done { runs: place.runs, finding }))
    }

    fn judge(&self, place: &Place<'_>, done: &Run, writes: Writes, read: &[u8]) -> Vec<Fault> {
        let mut faults = check::faults(done, writes, read, &self.schemas);
        // A long line of the input is repeated in part; the folder's name is never said.
        if done.ended.stderr.contains(&*place.folder.to_string_lossy()) && faults.is_empty() {
            faults.push(Fault::new(Rule::Message, "a path that nobody gave"));
        }
        faults
    }
}

struct Done {
    runs: Vec<(String, String)>,
    finding: Option<Finding>,
}

/// The folder of a case.
struct Place<'a> {
    programs: &'a Programs,
    processor_s: u64,
    root: tempfile::TempDir,
    folder: PathBuf,
    commands: Vec<String>,
    runs: Vec<(String, String)>,
}

impl<'a> Place<'a> {
    fn new(programs: &'a Programs, processor_s: u64) -> Result<Self, Error> {
        let root = tempfile::tempdir().map_err(|e| Error::file("a temporary folder", "written", e))?;
        let folder = root.path().join("case");
        fs::create_dir(&folder).map_err(|e| Error::file(&folder, "written", e))?;
        Ok(Self { programs, processor_s, root, folder, commands: Vec::new(), runs: Vec::new() })
    }

    /// Leaves only these files in the folder.
    fn clear(&self, files: &[(String, Vec<u8>)]) -> Result<(), Error> {
        let failed = |e| Error::file(&self.folder, "written", e);
        fs::remove_dir_all(&self.folder).and_then(|()| fs::create_dir(&self.folder)).map_err(failed)?;
        files.iter().try_for_each(|(name, bytes)| fs::write(self.folder.join(name), bytes)).map_err(failed)
    }

    fn run(&mut self, words: &[String], stdin: Option<&Path>) -> Result<Run, Error> {
        let before = sizes(&self.folder)?;
        let program = self.programs.path(&words[0]);
        let ended =
            run::run(&program, &words[1..], (&self.folder, self.root.path()), stdin, self.processor_s)?;
        let mut changed = sizes(&self.folder)?;
        changed.retain(|name, size| before.get(name) != Some(size));
        let output = words.iter().position(|word| word == "-o").and_then(|at| words.get(at + 1));
        let written = match output {
            Some(name) if ended.end == End::Code(0) => fs::read(self.folder.join(name)).unwrap_or_default(),
            _ => ended.stdout.clone(),
        };
        let asked = words.join(" ");
        let mut command: String = asked.chars().take(400).collect();
        if let Some(path) = stdin {
            command += &format!(" < {}", path.file_name().unwrap_or_default().to_string_lossy());
        }
        self.commands.push(command);
        self.runs.push((words[0].clone(), format!("{:?}", ended.end)));
        let changed = changed.into_keys().collect();
        Ok(Run { asked, ended, changed, written })
    }
}

/// The files of a folder with their sizes.
fn sizes(folder: &Path) -> Result<BTreeMap<String, u64>, Error> {
    let failed = |e| Error::file(folder, "read", e);
    let of = |entry: io::Result<DirEntry>| -> io::Result<(String, u64)> {
        let entry = entry?;
        Ok((entry.file_name().to_string_lossy().into_owned(), entry.metadata()?.len()))
    };
    fs::read_dir(folder).and_then(|entries| entries.map(of).collect()).map_err(failed)
}
