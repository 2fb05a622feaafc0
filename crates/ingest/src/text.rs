//! Files as they lie there: bytes, their kind, and the lines of those that are text.

use bytes::Bytes;
use memchr::{memchr, memchr_iter};
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::borrow::Cow;
use std::fmt::Display;
use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use crate::Error;
use tables::{Content, LINE_LIMIT, Place, fault};

const PART: usize = 1 << 22;

pub struct Source {
    /// As messages name it: as it was given.
    pub shown: String,
    /// Its name alone, as the document keeps it.
    pub name: String,
    /// What is in it; for text without byte-order mark, each line's end `\n` or `\r\n`.
    pub bytes: Bytes,
    /// SHA-256 of the file as it is, where `bytes` are not.
    original_sha256: Option<String>,
    pub kind: Content,
}

impl Source {
    /// A text of that name without anything in it.
    #[cfg(test)]
    pub fn empty(name: &str) -> Self {
        let (shown, name) = (name.to_string(), name.to_string());
        Source { shown, name, bytes: Bytes::new(), original_sha256: None, kind: Content::Delimited }
    }

    /// Reads a file, `-` for standard input. Errors: a file that cannot be read, is empty, or is neither text
    /// in UTF-8 (Latin-1 in headers) nor Parquet nor CDF.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let failed = |source| Error::file(path, "read", source);
        let (bytes, shown) = if path == Path::new("-") {
            let mut bytes = Vec::new();
            std::io::stdin().read_to_end(&mut bytes).map_err(failed)?;
            (bytes, "standard input".to_string())
        } else {
            (whole(path).map_err(failed)?, path.display().to_string())
        };
        let named = path.file_name().filter(|name| *name != "-");
        let name = named.map_or_else(|| shown.clone(), |name| name.to_string_lossy().into_owned());
        let kind = Content::of(&shown, &bytes)?;
        if kind == Content::Document {
            let expected = "a file of readings; to add recordings to a document, name it with --add";
            return Err(fault(&shown, Place::Whole, "a fluxcal document", expected));
        }
        let as_it_is = kind.is_binary() || is_plain(&bytes);
        let original_sha256 = (!as_it_is).then(|| sha256(&bytes));
        let bytes = if as_it_is { bytes } else { plain(bytes) }.into();
        Ok(Source { shown, name, bytes, original_sha256, kind })
    }

    /// SHA-256 of the file as it is, in hexadecimal.
    pub fn sha256(&self) -> String {
        self.original_sha256.clone().unwrap_or_else(|| sha256(&self.bytes))
    }

    /// A note where so many bytes at the beginning are not in UTF-8.
    pub fn latin_1(&self, header: usize) -> Option<String> {
        let read = std::str::from_utf8(&self.bytes[..header]);
        read.is_err().then(|| "the header is not in UTF-8 and was read as Latin-1".into())
    }

    /// The fault of a file without readings.
    pub fn no_row(&self) -> Error {
        self.fault(Place::Whole, "a header and no row", "rows of readings; was it copied in full?")
    }

    /// Refuses a line that by its length is no row.
    pub fn check_length(&self, number: u32, line: &[u8]) -> Result<(), Error> {
        if line.len() <= LINE_LIMIT {
            return Ok(());
        }
        Err(self.in_line(number, format!("a line of {} bytes", line.len()), "a row of values"))
    }

    /// The fault of a value in a column, from 1, of that name.
    pub fn in_field(
        &self,
        line: u32,
        (column, name): (usize, &str),
        found: impl Display,
        expected: impl Display,
    ) -> Error {
        self.fault(Place::Field { line: line.into(), column, name: name.into() }, found, expected)
    }

    pub fn in_line(&self, line: u32, found: impl Display, expected: impl Display) -> Error {
        self.fault(Place::Line(line.into()), found, expected)
    }

    pub fn fault(&self, place: Place, found: impl Display, expected: impl Display) -> Error {
        fault(&self.shown, place, found, expected)
    }
}

/// All of a file; of a long one several threads read a part each, for most of that time makes room in memory.
fn whole(path: &Path) -> io::Result<Vec<u8>> {
    let metadata = fs::metadata(path)?;
    let parts = metadata.len().div_ceil(PART as u64) as usize;
    if !metadata.is_file() || parts < 2 {
        return fs::read(path);
    }
    let mut bytes = vec![0; metadata.len() as usize];
    bytes.par_chunks_mut(PART).enumerate().try_for_each(|(number, part)| {
        let mut file = File::open(path)?;
        file.seek(SeekFrom::Start((number * PART) as u64))?;
        file.read_exact(part)
    })?;
    Ok(bytes)
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Whether text has no byte-order mark, and carriage returns only before line feeds.
fn is_plain(bytes: &[u8]) -> bool {
    !bytes.starts_with(b"\xEF\xBB\xBF")
        && memchr_iter(b'\r', bytes).all(|at| bytes.get(at + 1) == Some(&b'\n'))
}

/// Without byte-order mark; a carriage return that stands alone (or two before a line feed) becomes one
/// line's end.
fn plain(mut bytes: Vec<u8>) -> Vec<u8> {
    if bytes.starts_with(b"\xEF\xBB\xBF") {
        bytes.drain(..3);
    }
    let mut clean = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while let Some(found) = memchr(b'\r', &bytes[at..]) {
        clean.extend_from_slice(&bytes[at..at + found]);
        at += found;
        while bytes.get(at) == Some(&b'\r') {
            at += 1;
        }
        at += usize::from(bytes.get(at) == Some(&b'\n'));
        clean.push(b'\n');
    }
    clean.extend_from_slice(&bytes[at..]);
    clean
}

/// Text in UTF-8, or in Latin-1 where it is not.
pub fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect::<String>().into(),
    }
}

/// Lines with their numbers from 1, without their ends.
pub fn lines(bytes: &[u8]) -> impl Iterator<Item = (u32, &[u8])> {
    lines_from(bytes, 1)
}

/// The same with their numbers from `first` on.
#[inline]
pub fn lines_from(bytes: &[u8], first: u32) -> impl Iterator<Item = (u32, &[u8])> {
    let mut rest = bytes;
    (first..).map_while(move |number| {
        let (line, after) = (!rest.is_empty()).then(|| split_line(rest))?;
        rest = after;
        Some((number, line))
    })
}

/// The beginning of a text of JSON, without the blanks in it.
pub fn without_blanks(bytes: &[u8]) -> String {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(4096)]);
    head.chars().filter(|letter| !letter.is_whitespace()).collect()
}

/// The values of a list of JSON; none of anything else.
pub fn list(value: &serde_json::Value) -> &[serde_json::Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

/// The first line without its end, and what follows.
#[inline]
pub fn split_line(bytes: &[u8]) -> (&[u8], &[u8]) {
    let (line, rest) = match memchr(b'\n', bytes) {
        Some(end) => (&bytes[..end], &bytes[end + 1..]),
        None => (bytes, &[][..]),
    };
    (line.strip_suffix(b"\r").unwrap_or(line), rest)
}

/// What a cell says, as an error repeats it: in quotes, and not too long.
pub(crate) fn quoted(bytes: &[u8]) -> String {
    const SHOWN: usize = 40;
    let text = decoded(bytes);
    let mut short: String = text.chars().take(SHOWN).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    format!("{short:?}")
}

#[cfg(test)]
mod tests {
    #[test]
    fn each_line_end_counts_once() {
        let text = super::plain(b"\xEF\xBB\xBFa\r\nb\rc\r\r\nd\ne".to_vec());
        let all: Vec<(u32, &[u8])> = super::lines(&text).collect();
        assert_eq!(all, [(1, &b"a"[..]), (2, b"b"), (3, b"c"), (4, b"d"), (5, b"e")]);
    }
}
