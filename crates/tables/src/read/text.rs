use std::io::Read;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};

use super::ahead::{ahead, pool};
use super::lines::{Chunk, Lines};
use super::reader::{Batch, Reader, rows_per_batch};
use crate::{Error, Place, fault, listed};

/// How the lines of a format are parsed.
pub trait Parse: Send + Sync + 'static {
    /// The numbers of whole lines, each a row.
    fn parse(&self, chunk: &Chunk) -> Result<Parsed, Error>;
}

/// What lines say.
pub struct Parsed {
    /// The numbers, column by column.
    pub columns: Vec<Vec<f64>>,
    /// Number of the first of the empty lines that the chunk ends with.
    pub empty_line: Option<u64>,
    /// For each column, whether it was met.
    pub met: Vec<bool>,
}

/// Parses the rest of a text on threads of its own and gives the batches in order.
pub fn read<R: Read + Send + 'static>(
    mut lines: Lines<R>,
    columns: Vec<String>,
    parser: impl Parse,
) -> Result<Reader, Error> {
    let rows = rows_per_batch(columns.len());
    let source_name = lines.source_name.clone();
    let failed = |source| Error::file(&*source_name, "read", source);
    let pool = pool(usize::MAX).map_err(failed)?;
    let waiting = pool.current_num_threads() + 1;
    let parser = Arc::new(parser);
    let jobs = std::iter::from_fn(move || lines.chunk(rows).transpose()).map(move |chunk| {
        let (sender, receiver) = sync_channel(1);
        let parser = parser.clone();
        // A receiver that has gone wants no more.
        pool.spawn_fifo(move || drop(sender.send(chunk.and_then(|chunk| parser.parse(&chunk)))));
        receiver
    });
    let parsed = ahead(waiting, jobs).map_err(failed)?;
    let batches = Batches {
        parsed,
        met: vec![false; columns.len()],
        first_row: 0,
        empty_line: None,
        names: columns.clone(),
        source_name,
    };
    Ok(Reader { columns, batches: Box::new(batches), failed: false })
}

struct Batches {
    parsed: Receiver<Receiver<Result<Parsed, Error>>>,
    names: Vec<String>,
    met: Vec<bool>,
    first_row: u64,
    empty_line: Option<u64>,
    source_name: Arc<str>,
}

impl Batches {
    fn batch(&mut self, parsed: Parsed) -> Result<Batch, Error> {
        let batch = Batch { first_row: self.first_row, columns: parsed.columns };
        if let (Some(line), true) = (self.empty_line, batch.rows() > 0) {
            return Err(empty_line(&self.source_name, line));
        }
        self.first_row += batch.rows() as u64;
        self.empty_line = self.empty_line.or(parsed.empty_line);
        self.met.iter_mut().zip(parsed.met).for_each(|(met, now)| *met |= now);
        Ok(batch)
    }

    /// Of a fault and empty lines before it, what comes first.
    fn first_fault(&self, error: Error) -> Error {
        match (self.empty_line, &error) {
            (Some(line), Error::Request(_)) => empty_line(&self.source_name, line),
            _ => error,
        }
    }

    /// What is said at the end of a table in which a wanted key is nowhere: a name misspelt, more likely than
    /// a column of missing values.
    fn never_met(&mut self) -> Option<Error> {
        let absent: Vec<_> = (0..self.met.len()).filter(|column| !self.met[*column]).collect();
        self.met.clear();
        if absent.is_empty() || self.first_row == 0 {
            return None;
        }
        let absent: Vec<_> = absent.into_iter().map(|column| self.names[column].clone()).collect();
        Some(fault(
            &self.source_name,
            Place::Whole,
            format!("no line with the key {}", listed(&absent, 30)),
            "it in one at least",
        ))
    }
}

impl Iterator for Batches {
    type Item = Result<Batch, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        while let Ok(parsed) = self.parsed.recv() {
            let batch = match parsed.recv() {
                Ok(Ok(parsed)) => self.batch(parsed),
                Ok(Err(error)) => Err(self.first_fault(error)),
                Err(_) => {
                    Err(Error::Request(format!("{}: a thread that parsed it has stopped", self.source_name)))
                }
            };
            if batch.as_ref().map_or(true, |batch| batch.rows() > 0) {
                return Some(batch);
            }
        }
        self.never_met().map(Err)
    }
}

/// The error for an empty line that is followed by others.
pub fn empty_line(source_name: &str, line: u64) -> Error {
    fault(source_name, Place::Line(line), "an empty line", "a row on each line but the last")
}
