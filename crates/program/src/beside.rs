//! Recordings whose readings stand in a file beside the document (`table`).

use common::{Column, Document, Error, Recording};
use std::path::Path;
use tables::Reader;

/// Reads the tables of the recordings that follow one of these procedures into their columns. `folder` is that of the document.
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
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    for batch in reader {
        let batch = batch.map_err(refused)?;
        columns.iter_mut().zip(batch.columns).for_each(|(column, more)| column.extend(more));
    }
    recording.columns = names.into_iter().zip(columns.into_iter().map(Column)).collect();
    recording.in_range(path.trim_end_matches(".table"))
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
