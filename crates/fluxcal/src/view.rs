//! `fluxcal view`: files of readings, or a document, as a page in the browser.
//!
//! `ingest` reads the files, each series into a recording of its own, and `report` writes the page. Files of
//! one series have names that differ in digits alone, as those of days do.

use clap::Parser;
use std::env;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{self, Output, Stdio};

use crate::program as named;

const BEGINNING: u64 = 4096;

/// Show files of readings, folders of days, or a document, as a page in the browser
#[derive(Parser)]
#[command(
    name = "view",
    after_help = "Example:\n  fluxcal view fixtures/ingest/flx20240310a.min fixtures/ingest/flx20240310b.min"
)]
pub struct View {
    /// What ingest reads, a folder of it, or one document
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// Write the page to this file [default: a new temporary file]
    #[arg(short, long, value_name = "PAGE")]
    output: Option<PathBuf>,
    /// Do not open a browser; standard output has the page's path in any case
    #[arg(long)]
    no_browser: bool,
}

/// Writes the page and opens it: its path. Errors: what the programs refuse, in their words.
pub fn run(asked: &View) -> Result<PathBuf, String> {
    let named = &asked.files;
    let folder = tempfile::Builder::new().prefix("fluxcal-view-").tempdir();
    let folder = folder.map_err(|error| format!("no temporary folder can be made: {error}"))?;
    let mut left_out = Vec::new();
    let name = match named.as_slice() {
        [] => String::new(),
        [one] => stem(one),
        [first, others @ ..] => format!("{} and {} more", stem(first), others.len()),
    };
    let document = match named.as_slice() {
        [file] if is_document(file) => file.to_path_buf(),
        _ => {
            let read = readings(named, folder.path(), &mut left_out)?;
            // The page is titled by its document's name.
            let titled = folder.path().join(format!("{name}.json"));
            fs::rename(&read, &titled).map_err(|error| format!("{}: {error}", read.display()))?;
            titled
        }
    };
    let page = match &asked.output {
        Some(page) => page.clone(),
        None => {
            // A temporary file that stays.
            let prefix = format!("fluxcal-{}-", name.replace(' ', "-"));
            let made = tempfile::Builder::new().prefix(&prefix).suffix(".html").tempfile();
            let kept = made.and_then(|made| Ok(made.into_temp_path().keep()?));
            kept.map_err(|error| format!("no temporary file can be made: {error}"))?
        }
    };
    done(&ran("report", ["-q".into(), "-o".into(), page.clone().into(), document.into()])?)?;
    for one in left_out {
        program::pipe::say(&format!("fluxcal view: left out {one}"));
    }
    let opened = !asked.no_browser && open(&page);
    let done = if opened { "opened" } else { "open in a browser:" };
    program::pipe::say(&format!("fluxcal view: {done} {}", page.display()));
    Ok(page)
}

/// A document of what the files hold, in a folder that is thrown away.
fn readings(named: &[PathBuf], folder: &Path, left_out: &mut Vec<String>) -> Result<PathBuf, String> {
    let mut all: Option<PathBuf> = None;
    let mut names: Vec<String> = Vec::new();
    for (from_folder, files) in series(named)? {
        if let Some(document) = files.iter().find(|file| is_document(file)) {
            let words = "is a document; view one document alone, or files of readings";
            return Err(format!("{} {words}", document.display()));
        }
        let mut name = stem(&files[0]);
        if names.contains(&name) {
            name = format!("{name}-{}", names.len() + 1);
        }
        names.push(name.clone());
        let written = folder.join(format!("{name}.series.json"));
        match ingested(&files, &name, all.as_deref(), &written) {
            Ok(words) => {
                program::pipe::say(words.trim_end());
                all = Some(written);
            }
            // Beside its days a folder has notes.
            Err(words) if from_folder => left_out.push(words),
            Err(words) => return Err(words),
        }
    }
    all.ok_or_else(|| match left_out.first() {
        Some(first) => format!("no file that ingest reads; the first one: {first}"),
        None => "no file to view".into(),
    })
}

/// Files of one series as a recording: what was said of it.
fn ingested(files: &[PathBuf], id: &str, added_to: Option<&Path>, written: &Path) -> Result<String, String> {
    let read = |map: Option<&Path>| {
        let mut arguments: Vec<OsString> = vec!["--id".into(), id.into(), "-o".into(), written.into()];
        for (option, file) in [("--add", added_to), ("--map", map)] {
            arguments.extend(file.into_iter().flat_map(|file| [OsString::from(option), file.into()]));
        }
        arguments.extend(files.iter().map(Into::into));
        ran("ingest", arguments)
    };
    let plain = read(None)?;
    let Err(refused) = done(&plain) else { return Ok(told(&plain)) };
    // Files of columns whose header does not say all have a mapping that can be guessed.
    let map = written.with_extension("map.json");
    let guessed = ran("ingest", ["guess".into(), "-o".into(), map.clone().into(), (&files[0]).into()])?;
    if !guessed.status.success() {
        return Err(refused);
    }
    let mapped = read(Some(&map))?;
    done(&mapped).map_err(|_| refused)?;
    Ok(told(&guessed) + &told(&mapped))
}

/// The files that are named, those of one series together, and whether they come from a folder.
fn series(named: &[PathBuf]) -> Result<Vec<(bool, Vec<PathBuf>)>, String> {
    let mut all: Vec<(String, bool, Vec<PathBuf>)> = Vec::new();
    for path in named {
        let (from_folder, files) =
            if path.is_dir() { (true, within(path)?) } else { (false, vec![path.to_path_buf()]) };
        for file in files {
            let name: String = file.to_string_lossy().chars().filter(|one| !one.is_ascii_digit()).collect();
            match all.iter_mut().find(|(of, ..)| *of == name) {
                Some((.., files)) => files.push(file),
                None => all.push((name, from_folder, vec![file])),
            }
        }
    }
    Ok(all.into_iter().map(|(_, from_folder, files)| (from_folder, files)).collect())
}

/// The files of a folder by name, without hidden ones.
fn within(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let hidden = |path: &Path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
    let entries = fs::read_dir(folder).and_then(|entries| {
        entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<Vec<PathBuf>, _>>()
    });
    let mut files = entries.map_err(|error| format!("{}: cannot be read: {error}", folder.display()))?;
    files.retain(|path| path.is_file() && !hidden(path));
    files.sort();
    Ok(files)
}

fn is_document(file: &Path) -> bool {
    let mut text = Vec::new();
    let read = File::open(file).and_then(|file| file.take(BEGINNING).read_to_end(&mut text));
    read.is_ok()
        && text.trim_ascii_start().starts_with(b"{")
        && String::from_utf8_lossy(&text).contains("\"fluxcal\"")
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "page".into(), |stem| stem.to_string_lossy().into_owned())
}

fn ran(name: &str, arguments: impl IntoIterator<Item = OsString>) -> Result<Output, String> {
    let path = named(name).map(|program| program.path()).unwrap_or_default();
    let output = process::Command::new(&path).args(arguments).stdin(Stdio::null()).output();
    output.map_err(|error| {
        format!("{}: cannot be run: {error}; install all programs in one folder", path.display())
    })
}

fn done(output: &Output) -> Result<(), String> {
    if output.status.success() { Ok(()) } else { Err(told(output).trim_end().into()) }
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Opens a page with the system's browser, where there is a screen.
fn open(page: &Path) -> bool {
    let set = |name: &str| env::var_os(name).filter(|value| !value.is_empty());
    let mut command = match set("BROWSER") {
        Some(browser) => process::Command::new(browser),
        None if cfg!(target_os = "macos") => process::Command::new("open"),
        None if cfg!(windows) => process::Command::new("explorer"),
        None if set("DISPLAY").or(set("WAYLAND_DISPLAY")).is_some() => process::Command::new("xdg-open"),
        None => return false,
    };
    command.arg(page).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().is_ok()
}
