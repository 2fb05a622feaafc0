//! Recordings whose readings stand in a file beside the document (`table`).

use common::{Column, Document, Error, Recording};
use rayon::prelude::*;
use std::path::Path;
use tables::{Reader, Writer};

use crate::dropped;
use crate::sink::{Sink, named};

/// Rows up to which a recording keeps its readings in the document.
pub const INLINE_ROWS: usize = 10_000;

/// Readings beside a document.
#[derive(Debug)]
pub struct Table {
    /// Its path from the document's folder.
    pub path: String,
    /// Names and values.
    pub columns: Vec<(String, Vec<f64>)>,
}

impl Table {
    /// Takes the readings of a recording out of the document.
    pub fn of(recording: &mut Recording, path: String) -> Self {
        recording.table = Some(path.clone());
        let columns = std::mem::take(&mut recording.columns).into_iter();
        Table { path, columns: columns.map(|(name, column)| (name, column.into())).collect() }
    }

    /// Writes it into the document's folder, whole or not at all; CSV or NDJSON where its name says so.
    ///
    /// # Errors
    ///
    /// A path that leaves the folder; a file that cannot be written.
    pub fn write(&self, document_folder: &Path) -> Result<(), tables::Error> {
        let path = tables::beside(document_folder, &self.path)?;
        let names: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
        let columns: Vec<&[f64]> = self.columns.iter().map(|(_, values)| values.as_slice()).collect();
        let mut writer = Writer::create(&path, &names)?;
        writer.write(&columns)?;
        writer.finish()
    }
}

/// The name of the file with the readings of a recording: its id, and what was done to it where that is said.
pub fn file_name(id: &str) -> String {
    let good = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '-' | '_' | '.');
    let name: String = id.chars().map(|letter| if good(letter) { letter } else { '-' }).collect();
    match name.strip_prefix('.') {
        Some(rest) => format!("-{rest}.parquet"),
        None => format!("{name}.parquet"),
    }
}

/// Writes a document and the tables beside it, to a file or to standard output, with tables in the present
/// folder. The document is written to its end before a table gets its name, and gets its own after that.
///
/// # Errors
///
/// What cannot be written; two tables of one name.
pub fn write(output: Option<&Path>, text: &str, tables: &[Table]) -> Result<(), Error> {
    let twice =
        tables.iter().enumerate().find(|(at, one)| tables[..*at].iter().any(|other| other.path == one.path));
    if let Some((_, table)) = twice {
        return Err(Error::Request(format!(
            "the readings of two recordings would go to {}; expected ids that differ in letters, digits, \"-\", \"_\" or \".\"",
            table.path
        )));
    }
    let output = named(output);
    let mut sink = Sink::open(output)?;
    if output.is_some() {
        sink.write(text)?;
    }
    let folder = output.and_then(Path::parent).unwrap_or(Path::new(""));
    tables.iter().try_for_each(|table| table.write(folder))?;
    if output.is_none() {
        sink.write(text)?;
    }
    sink.finish()
}

/// Reads the tables of the recordings that follow one of these procedures into their columns. `folder` is
/// that of the document.
///
/// # Errors
///
/// A table beside columns; one that is not below `folder`, or cannot be read, with its line and column.
pub fn read(document: &mut Document, folder: &Path, procedures: &[&str]) -> Result<(), Error> {
    for (index, recording) in document.recordings.iter_mut().enumerate() {
        if procedures.contains(&recording.procedure.as_str()) {
            let path = format!("recordings[{index}].table");
            one(recording, folder, &path)?;
        }
    }
    Ok(())
}

fn one(recording: &mut Recording, folder: &Path, path: &str) -> Result<(), Error> {
    let Some(table) = &recording.table else { return Ok(()) };
    if !recording.columns.is_empty() {
        let found = format!("the table \"{table}\" beside columns");
        return Err(Error::document(path, found, "one of the two"));
    }
    let refused = |error: tables::Error| {
        Error::document(path, error.to_string(), "a table of numbers in or below the document's folder")
    };
    let reader = tables::beside(folder, table).and_then(|file| Reader::open(&file, None)).map_err(refused)?;
    let names = reader.columns().to_vec();
    let mut pieces: Vec<Vec<Vec<f64>>> = vec![Vec::new(); names.len()];
    for batch in reader {
        let batch = batch.map_err(refused)?;
        pieces.iter_mut().zip(batch.columns).for_each(|(column, more)| column.push(more));
    }
    let columns: Vec<Column> = pieces.into_par_iter().map(|pieces| pieces.concat().into()).collect();
    recording.columns = names.into_iter().zip(columns).collect();
    let path = path.trim_end_matches(".table");
    recording.check(path)?;
    dropped::check(recording, path)
}

/// Leaves the readings of tables to their files again.
pub fn put_back(document: &mut Document) {
    let beside = document.recordings.iter_mut().filter(|recording| recording.table.is_some());
    beside.for_each(|recording| recording.columns.clear());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(recording: &str) -> Document {
        Document::parse(&format!("{{\"fluxcal\": 1, \"recordings\": [{recording}]}}")).expect("a document")
    }

    #[test]
    fn a_table_is_read_and_put_back() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("night.csv"), "time_s,sensor_x_nt\n0,1.5\n1,\n").expect("written");
        let mut read_in = document(r#"{"id": "a", "procedure": "free_run", "table": "night.csv"}"#);
        let before = read_in.clone();
        read(&mut read_in, folder.path(), &["sensor_noise"]).expect("not asked for");
        assert_eq!(read_in, before);
        assert!(read_in.recordings[0].at_hand("recordings[0]").is_err());
        read(&mut read_in, folder.path(), &["free_run"]).expect("read");
        let readings = read_in.recordings[0].column("sensor_x_nt").expect("a column");
        assert!(readings[0] == 1.5 && readings[1].is_nan());
        assert!(read_in.recordings[0].at_hand("recordings[0]").is_ok());
        put_back(&mut read_in);
        assert_eq!(read_in, before);
    }

    #[test]
    fn two_tables_of_one_name_are_refused() {
        let one = Table { path: "a-b.parquet".into(), columns: Vec::new() };
        let tables = [one, Table { path: "a-b.parquet".into(), columns: Vec::new() }];
        let message = write(None, "{}", &tables).expect_err("refused").to_string();
        assert!(message.contains("the readings of two recordings would go to a-b.parquet"), "{message}");
    }

    #[test]
    fn faults_have_their_place() {
        let folder = tempfile::tempdir().expect("a folder");
        let message = |recording: &str| {
            read(&mut document(recording), folder.path(), &["free_run"]).expect_err("refused").to_string()
        };
        let both =
            message(r#"{"id": "a", "procedure": "free_run", "table": "a.csv", "columns": {"time_s": [0]}}"#);
        assert!(both.contains("recordings[0].table: found the table \"a.csv\" beside columns"), "{both}");
        let out = message(r#"{"id": "a", "procedure": "free_run", "table": "../a.csv"}"#);
        assert!(out.contains("has .. in it"), "{out}");
        let absent = message(r#"{"id": "a", "procedure": "free_run", "table": "a.csv"}"#);
        assert!(absent.contains("a.csv: cannot be read"), "{absent}");
    }
}
