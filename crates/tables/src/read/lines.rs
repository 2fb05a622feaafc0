use memchr::{memchr, memchr_iter, memrchr};
use std::io::Read;
use std::mem;
use std::sync::Arc;

use crate::{Error, LINE_LIMIT, Place, fault};

/// Bytes that are read at once.
const BLOCK: usize = 1 << 18;
/// A chunk is cut when it has so many bytes, even if it has fewer lines than wanted.
const CHUNK_BYTES: usize = 1 << 25;
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// Text, cut into chunks of whole lines.
pub struct Lines<R> {
    input: R,
    /// As it is named in errors.
    pub source_name: Arc<str>,
    /// Read, but not yet given.
    rest: Vec<u8>,
    /// Number of the line that comes next, from 1.
    line: u64,
    ended: bool,
    /// Bytes that a chunk will probably need.
    usual: usize,
}

/// Whole lines of text.
pub struct Chunk {
    /// The text, the ends of its lines included.
    pub bytes: Vec<u8>,
    /// Number of its first line, from 1.
    pub first_line: u64,
    /// How many lines.
    pub lines: usize,
}

impl<R: Read> Lines<R> {
    pub fn new(input: R, source_name: &str) -> Self {
        Lines {
            input,
            source_name: source_name.into(),
            rest: Vec::new(),
            line: 1,
            ended: false,
            usual: BLOCK,
        }
    }

    /// The next lines, `lines` of them unless the text ends or they are very long; none at the end.
    pub fn chunk(&mut self, lines: usize) -> Result<Option<Chunk>, Error> {
        let mut bytes = mem::take(&mut self.rest);
        let (mut searched, mut found) = (0, 0);
        let end = loop {
            let ends = memchr_iter(b'\n', &bytes[searched..]).count();
            if found + ends >= lines {
                let last = memchr_iter(b'\n', &bytes[searched..]).nth(lines - found - 1);
                found = lines;
                break searched + last.map_or(0, |last| last + 1);
            }
            found += ends;
            searched = bytes.len();
            if self.ended {
                found += usize::from(bytes.last().is_some_and(|last| *last != b'\n'));
                break searched;
            }
            if searched >= CHUNK_BYTES {
                break memrchr(b'\n', &bytes).map_or(searched, |last| last + 1);
            }
            bytes.reserve(self.usual.saturating_sub(searched));
            self.read_block(&mut bytes, self.line + found as u64)?;
        };
        if end == 0 {
            return Ok(None);
        }
        self.usual = end + BLOCK;
        self.rest.extend_from_slice(&bytes[end..]);
        bytes.truncate(end);
        let first_line = self.line;
        self.line += found as u64;
        Ok(Some(Chunk { bytes, first_line, lines: found }))
    }

    /// Puts a chunk back.
    pub fn put_back(&mut self, chunk: Chunk) {
        self.line = chunk.first_line;
        let rest = mem::replace(&mut self.rest, chunk.bytes);
        self.rest.extend(rest);
    }

    /// Appends a block; `line` is the number of the line that it goes on with.
    fn read_block(&mut self, bytes: &mut Vec<u8>, line: u64) -> Result<(), Error> {
        let start = bytes.len();
        let begun = start - memrchr(b'\n', bytes).map_or(0, |end| end + 1);
        let read = (&mut self.input)
            .take(BLOCK as u64)
            .read_to_end(bytes)
            .map_err(|source| Error::file(&*self.source_name, "read", source))?;
        self.ended = read < BLOCK;
        if line == 1 && start == 0 && bytes.starts_with(BYTE_ORDER_MARK) {
            bytes.drain(..BYTE_ORDER_MARK.len());
        }
        if begun + memchr(b'\n', &bytes[start..]).unwrap_or(bytes.len() - start) > LINE_LIMIT {
            return Err(fault(
                &self.source_name,
                Place::Line(line),
                format!("a line of more than {LINE_LIMIT} bytes"),
                "a row of numbers on each line",
            ));
        }
        Ok(())
    }
}

impl Chunk {
    /// The chunk as text; an error names the line and byte that is none.
    pub fn utf8(&self, source_name: &str) -> Result<&str, Error> {
        std::str::from_utf8(&self.bytes).map_err(|error| {
            let at = error.valid_up_to();
            let start = memrchr(b'\n', &self.bytes[..at]).map_or(0, |end| end + 1);
            let found = format!("byte {} of the line, which is not UTF-8", at - start + 1);
            fault(source_name, Place::Line(self.line_at(at)), found, "text in UTF-8")
        })
    }

    /// Number of the line with the byte at `at`.
    pub fn line_at(&self, at: usize) -> u64 {
        self.first_line + memchr_iter(b'\n', &self.bytes[..at]).count() as u64
    }
}
