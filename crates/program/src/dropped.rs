//! Readings that a stage leaves out of the document it writes, with their digest, so that they can be checked
//! when they come back.

use common::{Document, Dropped, Error, Recording};
use sha2::{Digest, Sha256};

use crate::hexadecimal;

/// Takes the readings of the recordings that follow one of these procedures out of the document. Tables
/// beside it stay where they are.
pub fn drop(document: &mut Document, procedures: &[&str]) {
    for recording in &mut document.recordings {
        let has = recording.table.is_none() && !recording.columns.is_empty();
        if has && procedures.contains(&recording.procedure.as_str()) {
            recording.dropped = Some(Dropped {
                rows: recording.rows(),
                sha256: sha256(recording),
                extra: recording.dropped.take().map(|dropped| dropped.extra).unwrap_or_default(),
            });
            recording.columns.clear();
        }
    }
}

/// Readings that were put back are those that were left out.
///
/// # Errors
///
/// A recording whose readings have another digest.
pub fn check(recording: &Recording, path: &str) -> Result<(), Error> {
    let Some(dropped) = recording.dropped.as_ref().filter(|_| !recording.columns.is_empty()) else {
        return Ok(());
    };
    let found = sha256(recording);
    if found == dropped.sha256 {
        return Ok(());
    }
    Err(Error::document(
        format!("{path}.dropped.sha256"),
        format!("{} where the readings of \"{}\" have {found}", dropped.sha256, recording.id),
        "the readings that were left out; restore those, or remove `dropped` if they were meant to change",
    ))
}

/// As [`Dropped::sha256`].
fn sha256(recording: &Recording) -> String {
    let mut columns: Vec<_> = recording.columns.iter().collect();
    columns.sort_by_key(|(name, _)| *name);
    let mut digest = Sha256::new();
    let mut bytes = Vec::new();
    for (name, values) in columns {
        digest.update(name.as_bytes());
        digest.update([0]);
        bytes.clear();
        let bits = values.iter().map(|value| if value.is_nan() { 0x7ff8 << 48 } else { value.to_bits() });
        bytes.extend(bits.flat_map(u64::to_le_bytes));
        digest.update(&bytes);
    }
    hexadecimal(&digest.finalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document() -> Document {
        let text = r#"{"fluxcal": 1, "recordings": [
            {"id": "a", "procedure": "free_run", "columns": {"time_s": [0, 1], "sensor_x_nt": [1.5, null]}},
            {"id": "b", "procedure": "free_run", "table": "b.csv"},
            {"id": "c", "procedure": "sensor_noise", "columns": {"time_s": [0]}}]}"#;
        Document::parse(text).expect("a document")
    }

    #[test]
    fn readings_go_and_are_known_again() {
        let before = document();
        let mut after = before.clone();
        drop(&mut after, &["free_run"]);
        assert_eq!(after.recordings[1..], before.recordings[1..]);
        let left = &after.recordings[0];
        // printf
        // 'sensor_x_nt\0\0\0\0\0\0\0\xf8\x3f\0\0\0\0\0\0\xf8\x7ftime_s\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\xf0\x3f'
        // | sha256sum
        let expected = "14267f7776cf12ba0742257f8d3c56676ee9804b7efcb7a13969b880d4166b86";
        let dropped = left.dropped.as_ref().expect("a digest");
        assert_eq!((dropped.rows, dropped.sha256.as_str()), (2, expected));
        let said = left.at_hand("recordings[0]").expect_err("none at hand").to_string();
        assert!(said.contains("found 2 rows of recording \"a\" that an earlier stage left out"), "{said}");
        let mut back = left.clone();
        back.columns = before.recordings[0].columns.clone();
        assert!(check(&back, "recordings[0]").is_ok() && back.at_hand("recordings[0]").is_ok());
        back.columns.insert("time_s".into(), vec![0.0, 2.0].into());
        let said = check(&back, "recordings[0]").expect_err("others").to_string();
        assert!(
            said.contains("recordings[0].dropped.sha256: found") && said.contains("restore those"),
            "{said}"
        );
    }
}
