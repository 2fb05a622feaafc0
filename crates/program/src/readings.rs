//! Files of readings where a document is due.

use tables::Content;

/// Lines that are looked at.
const LINES: usize = 200;

/// What a file of readings is, in words; None for what may be meant as a document.
pub fn told(bytes: &[u8]) -> Option<&'static str> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    match Content::of("", bytes) {
        Ok(Content::Iaga) => Some("IAGA-2002"),
        Ok(Content::Cdf) => Some("CDF"),
        Ok(Content::Iaf) => Some("IAF"),
        Ok(Content::Parquet) => Some("Parquet"),
        Ok(Content::Delimited) => is_table(bytes).then_some("lines of values (CSV)"),
        Ok(Content::NdJson) => is_ndjson(bytes).then_some("a JSON object a line (NDJSON)"),
        Ok(Content::Document) | Err(_) => None,
    }
}

/// Whether text has a line with several values, one of them a number.
fn is_table(bytes: &[u8]) -> bool {
    let lines = bytes.split(|byte| *byte == b'\n').take(LINES);
    lines.map(String::from_utf8_lossy).any(|line| {
        let cells: Vec<&str> =
            line.split([',', ';', '\t', '|', ' ']).filter(|cell| !cell.trim().is_empty()).collect();
        cells.len() > 1 && cells.iter().any(|cell| cell.trim().parse::<f64>().is_ok())
    })
}

/// Whether each of the first lines is an object of its own.
fn is_ndjson(bytes: &[u8]) -> bool {
    let mut lines =
        bytes.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty()).take(2);
    let object = |line: &[u8]| line.starts_with(b"{") && line.ends_with(b"}");
    lines.next().is_some_and(object) && lines.next().is_some_and(object)
}

#[cfg(test)]
mod tests {
    use super::told;

    #[test]
    fn readings_and_documents() {
        assert_eq!(told(b"time,x\n0,1.5\n"), Some("lines of values (CSV)"));
        assert_eq!(told(b"1;2\n3;4\n"), Some("lines of values (CSV)"));
        assert_eq!(told(b" Format   IAGA-2002  |\n"), Some("IAGA-2002"));
        assert_eq!(told(b"PAR1"), Some("Parquet"));
        assert_eq!(told(b"\xCD\xF3\x00\x01"), Some("CDF"));
        assert_eq!(
            told(b"{\"t\": 1, \"x\": 2}\n{\"t\": 2, \"x\": 2}\n"),
            Some("a JSON object a line (NDJSON)")
        );
        assert_eq!(told(b"\xEF\xBB\xBFtime,x\n0,1.5\n"), Some("lines of values (CSV)"));
        for document in [
            "{\"fluxcal\": 1}",
            "\u{feff}{\"fluxcal\": 1}",
            "{\n\"recordings\": []}",
            "[1, 2]",
            "",
            "Dear colleague",
            "{\"a\": 1}",
        ] {
            assert_eq!(told(document.as_bytes()), None, "{document}");
        }
    }
}
