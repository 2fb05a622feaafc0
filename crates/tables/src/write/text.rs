use rayon::prelude::*;
use std::io::{self, BufWriter, Write};
use std::ops::Range;

/// Rows that are put into words at once.
const PIECE: usize = 1 << 12;
/// Pieces in memory.
const PIECES: usize = 64;

/// CSV or NDJSON.
pub struct Text {
    output: BufWriter<Box<dyn Write + Send>>,
    words: Words,
}

/// What stands around the numbers of a row.
struct Words {
    /// Before the value of each column.
    before: Vec<String>,
    /// For a missing value.
    missing: &'static str,
    end: &'static str,
}

impl Text {
    pub fn csv(output: impl Write + Send + 'static, columns: &[&str]) -> io::Result<Self> {
        let mut output = BufWriter::new(Box::new(output) as Box<dyn Write + Send>);
        let mut header = csv::Writer::from_writer(&mut output);
        header.write_record(columns)?;
        header.flush()?;
        drop(header);
        let before = (0..columns.len()).map(|column| if column == 0 { "" } else { "," }.into()).collect();
        // An empty line would be none: so a missing value that stands alone is quoted.
        let missing = if columns.len() == 1 { "\"\"" } else { "" };
        Ok(Text { output, words: Words { before, missing, end: "\n" } })
    }

    pub fn ndjson(output: impl Write + Send + 'static, columns: &[&str]) -> Self {
        let output = BufWriter::new(Box::new(output) as Box<dyn Write + Send>);
        let before = columns.iter().enumerate().map(|(column, name)| {
            let begin = if column == 0 { '{' } else { ',' };
            format!("{begin}{}:", serde_json::Value::from(*name))
        });
        Text { output, words: Words { before: before.collect(), missing: "null", end: "}\n" } }
    }

    pub fn write(&mut self, columns: &[&[f64]]) -> io::Result<()> {
        let (rows, words) = (columns[0].len(), &self.words);
        for first in (0..rows).step_by(PIECES * PIECE) {
            let starts: Vec<_> = (first..rows).step_by(PIECE).take(PIECES).collect();
            let pieces: Vec<_> = starts
                .into_par_iter()
                .map(|start| words.rows(columns, start..rows.min(start + PIECE)))
                .collect();
            for piece in pieces {
                self.output.write_all(&piece)?;
            }
        }
        Ok(())
    }

    pub fn finish(mut self) -> io::Result<()> {
        self.output.flush()
    }
}

impl Words {
    fn rows(&self, columns: &[&[f64]], rows: Range<usize>) -> Vec<u8> {
        let mut text = Vec::with_capacity(rows.len() * columns.len() * 16);
        let mut buffer = zmij::Buffer::new();
        for row in rows {
            for (before, column) in self.before.iter().zip(columns) {
                text.extend_from_slice(before.as_bytes());
                let value = column[row];
                let number = if value.is_nan() { self.missing } else { buffer.format_finite(value) };
                text.extend_from_slice(number.as_bytes());
            }
            text.extend_from_slice(self.end.as_bytes());
        }
        text
    }
}
