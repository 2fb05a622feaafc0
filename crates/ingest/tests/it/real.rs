//! Real recordings of observatories and loggers, which are not in the repository (`just recordings` runs this
//! test): each row and value as pandas reads them (`fixtures/reference/ingest/read.py`; FLUXCAL_PYTHON names
//! another interpreter than python3).

use common::Document;
use ingest::{Mapping, Options, Readings};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use tables::Reader;

/// What differs only by the last digits of sines and products, nT.
const ROUNDING: f64 = 1e-10;

fn python(arguments: &[&str]) -> Result<Vec<u8>, String> {
    let script = testkit::fixture("reference/ingest/read.py");
    let program = std::env::var("FLUXCAL_PYTHON").unwrap_or_else(|_| "python3".into());
    let output = Command::new(&program).arg(script).args(arguments).output();
    let output = output.map_err(|error| format!("{program}: {error}"))?;
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.success() { Ok(output.stdout) } else { Err(said) }
}

/// Files that a pattern with one `*` at most names.
fn files(folder: &Path, pattern: &str) -> Vec<PathBuf> {
    let (below, name) = pattern.rsplit_once('/').expect("a folder");
    let (head, tail) = name.split_once('*').unwrap_or((name, ""));
    let entries = std::fs::read_dir(folder.join(below)).expect(below);
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| {
            let found = path.file_name().expect("a name").to_string_lossy().into_owned();
            if name.contains('*') { found.starts_with(head) && found.ends_with(tail) } else { found == name }
        })
        .collect();
    files.sort();
    files
}

/// Names and values of a table, whole.
fn table(path: &Path) -> BTreeMap<String, Vec<f64>> {
    let reader = Reader::open(path, None).expect("a table");
    let mut columns: Vec<(String, Vec<f64>)> =
        reader.columns().iter().map(|name| (name.clone(), Vec::new())).collect();
    for batch in reader {
        for ((_, all), part) in columns.iter_mut().zip(batch.expect("a batch").columns) {
            all.extend(part);
        }
    }
    columns.into_iter().collect()
}

/// Compares one set; its rows and values.
fn check(
    set: &str,
    files: &[PathBuf],
    mapping: Option<Mapping>,
    folder: &Path,
    place: &Path,
) -> Result<(usize, usize), String> {
    // Every set goes through a table, so that it is compared as it is written.
    let readings = Readings::Beside(Some(format!("{set}.parquet")));
    let mut options = Options { mapping, readings, ..Options::default() };
    let document = || Document { fluxcal: 1, ..Document::default() };
    let ingested = match ingest::run(document(), files, &options) {
        // The clock of the balloon's computer was set back while it ran.
        Err(error) if set == "balloon-rotation" => {
            assert!(error.to_string().contains("the clock was set back"), "{error}");
            options.sort = true;
            ingest::run(document(), files, &options)
        }
        ingested => ingested,
    };
    let ingested = ingested.map_err(|error| error.to_string())?;
    ingested.table.as_ref().expect("a table").write(place).map_err(|error| error.to_string())?;
    let found = table(&place.join(format!("{set}.parquet")));

    let peer = place.join("peer.parquet");
    python(&[set, folder.to_str().expect("UTF-8"), peer.to_str().expect("UTF-8")])?;
    let mut expected = table(&peer);
    let (s, ns) = (expected.remove("s").expect("s"), expected.remove("ns").expect("ns"));
    let start = ingested.document.recordings[0].start();
    let first = if start.is_some() { (s[0], ns[0]) } else { (0.0, 0.0) };
    let times = s.iter().zip(&ns).map(|(s, ns)| (s - first.0) + (ns - first.1) / 1e9).collect();
    expected.insert("time_s".into(), times);
    if let Some(start) = start.filter(|start| (start.unix_s - (first.0 + first.1 / 1e9)).abs() > 1e-6) {
        return Err(format!("it begins at {:?} s and not at {first:?}", start.unix_s));
    }
    if !found.keys().eq(expected.keys()) {
        return Err(format!("columns {:?} and {:?}", found.keys(), expected.keys()));
    }
    let mut worst: f64 = 0.0;
    for (name, values) in &found {
        let expected = &expected[name];
        if values.len() != expected.len() {
            return Err(format!("{} and {} rows", values.len(), expected.len()));
        }
        for (row, (value, expected)) in values.iter().zip(expected).enumerate() {
            if value.is_nan() != expected.is_nan() {
                return Err(format!("{name}, row {row}: {value} and {expected}"));
            }
            worst = worst.max(if value.is_nan() { 0.0 } else { (value - expected).abs() });
        }
    }
    println!("{set}: {} rows of {} columns, largest difference {worst:.1e}", s.len(), found.len());
    if worst > ROUNDING {
        Err(format!("they differ by {worst}"))
    } else {
        Ok((s.len(), s.len() * found.len()))
    }
}

#[test]
#[ignore = "needs the recordings: just recordings"]
fn every_row_as_pandas_reads_it() {
    let folder = testkit::recordings("");
    let sets = python(&["--list"]).unwrap_or_else(|reason| panic!("{reason}"));
    let sets: BTreeMap<String, (String, Option<String>)> = serde_json::from_slice(&sets).expect("sets");
    assert!(sets.len() >= 20);
    let place = tempfile::tempdir().expect("a folder");
    let (mut all, mut wrong) = ((0, 0), Vec::new());
    for (set, (pattern, mapping)) in sets {
        let files = files(&folder, &pattern);
        if files.is_empty() {
            wrong.push(format!("{set}: no files"));
            continue;
        }
        let mapping = mapping.map(|name| {
            let text = testkit::read_fixture(&format!("ingest/real/{name}.json"));
            Mapping::parse(&text).unwrap_or_else(|error| panic!("{name}: {error}"))
        });
        match check(&set, &files, mapping, &folder, place.path()) {
            Ok((rows, values)) => all = (all.0 + rows, all.1 + values),
            Err(why) => wrong.push(format!("{set}: {why}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    println!("{} rows, {} values", all.0, all.1);
}
