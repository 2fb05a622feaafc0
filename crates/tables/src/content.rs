use memchr::memchr;

use crate::{Error, Place, fault};

/// What a file is, told from its content: names of files say little.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// IAGA-2002.
    Iaga,
    /// Lines of values between separators.
    Delimited,
    /// A JSON object a line.
    NdJson,
    /// Apache Parquet.
    Parquet,
    /// NASA's Common Data Format.
    Cdf,
    /// INTERMAGNET's archive format of definitive minute means.
    Iaf,
    /// A fluxcal document.
    Document,
}

impl Content {
    /// What bytes are; `shown` names them in errors.
    ///
    /// # Errors
    ///
    /// [`Error::Request`] for nothing, archives, UTF-16, HDF5, and what is neither text nor a format that is
    /// read.
    pub fn of(shown: &str, bytes: &[u8]) -> Result<Self, Error> {
        let refused = |found: &str, expected: &str| Err(fault(shown, Place::Whole, found, expected));
        let archive = "a file of readings; unpack it first";
        let utf8 = "text in UTF-8; convert it, for example with iconv -f UTF-16 -t UTF-8";
        match bytes {
            [] => return refused("an empty file", "readings; was it copied in full?"),
            [b'P', b'A', b'R', b'1', ..] => return Ok(Content::Parquet),
            [0xCD, 0xF3 | 0xF2, ..] | [0, 0, 0xFF, 0xFF, 0, 0, 0xFF, 0xFF, ..] => return Ok(Content::Cdf),
            [b'P', b'K', 3, 4, ..] => return refused("a zip archive (a spreadsheet is one too)", archive),
            [0x1f, 0x8b, ..] => return refused("a gzip archive", archive),
            [0x89, b'H', b'D', b'F', ..] => {
                return refused("HDF5", "IAGA-2002, CDF, CSV, NDJSON or Parquet; convert it first");
            }
            [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => return refused("text in UTF-16", utf8),
            _ => {}
        }
        match iaf(bytes) {
            Some(true) => return Ok(Content::Iaf),
            Some(false) => {
                let expected = "IAF in little-endian byte order, as INTERMAGNET publishes it; swap the bytes of each number";
                return refused("INTERMAGNET's archive format (IAF) in big-endian byte order", expected);
            }
            None => {}
        }
        let head = &bytes[..bytes.len().min(4096)];
        match memchr(0, head) {
            Some(at) if at < 4 && head.len() > 3 => {
                return refused("text in UTF-16, without a mark that says so", utf8);
            }
            Some(at) => {
                return refused(&format!("a zero byte at byte {}", at + 1), "text, Parquet, CDF or IAF");
            }
            None => {}
        }
        let head = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(head);
        let first = head.trim_ascii_start();
        if first.is_empty() {
            return refused("nothing but blanks", "readings; was it copied in full?");
        }
        if first.starts_with(b"{") || first.starts_with(b"[") {
            if head.windows(9).any(|part| part == b"\"fluxcal\"") {
                return Ok(Content::Document);
            }
            if first.starts_with(b"{") {
                return Ok(Content::NdJson);
            }
            return refused("a JSON list", "NDJSON, which is one JSON object a line");
        }
        let label = first.get(..6).is_some_and(|label| label.eq_ignore_ascii_case(b"format"));
        let line = &first[..memchr(b'\n', first).unwrap_or(first.len())];
        let line = line.to_ascii_uppercase();
        let iaga = label && line.windows(4).any(|part| part == b"IAGA");
        Ok(if iaga { Content::Iaga } else { Content::Delimited })
    }

    /// As messages call it.
    pub fn name(self) -> &'static str {
        match self {
            Content::Iaga => "IAGA-2002",
            Content::Delimited => "CSV",
            Content::NdJson => "NDJSON",
            Content::Parquet => "Parquet",
            Content::Cdf => "CDF",
            Content::Iaf => "IAF",
            Content::Document => "a fluxcal document",
        }
    }

    /// Whether it is a format of observatories that says itself what its columns are.
    pub fn is_observatory(self) -> bool {
        matches!(self, Content::Iaga | Content::Iaf)
    }

    /// Whether it is no text.
    pub fn is_binary(self) -> bool {
        matches!(self, Content::Parquet | Content::Cdf | Content::Iaf)
    }
}

/// Whether bytes begin as a day of IAF does, and whether its numbers are little-endian: the station's code, year
/// and day of the year as YYYYDDD, and as sixth word the letters of the components. It has no other mark.
fn iaf(bytes: &[u8]) -> Option<bool> {
    let word = |index: usize| bytes.get(4 * index..4 * index + 4)?.first_chunk::<4>().copied();
    let letters = |index: usize, known: fn(&u8) -> bool| {
        let text = word(index)?;
        let text = text.trim_ascii();
        (text.len() > 1 && text.iter().all(known)).then_some(())
    };
    letters(0, u8::is_ascii_alphanumeric)?;
    letters(5, u8::is_ascii_uppercase)?;
    let is_day = |day: i32| (1800..2262).contains(&(day / 1000)) && (1..=366).contains(&(day % 1000));
    let day = word(1)?;
    match (is_day(i32::from_le_bytes(day)), is_day(i32::from_be_bytes(day))) {
        (false, false) => None,
        (little, _) => Some(little),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_told_from_content() {
        let of = |bytes: &[u8]| Content::of("x", bytes).map_err(|error| error.to_string());
        assert_eq!(of(b" Format                 IAGA-2002   |\n"), Ok(Content::Iaga));
        assert_eq!(of(b"t,x\n1,2\n"), Ok(Content::Delimited));
        assert_eq!(of(b"{\"t\": 1}\n"), Ok(Content::NdJson));
        assert_eq!(of(b"PAR1...."), Ok(Content::Parquet));
        assert_eq!(of(b"\xCD\xF3\x00\x01\x00\x00\xFF\xFF"), Ok(Content::Cdf));
        assert_eq!(of(b"{\n \"fluxcal\": 1}"), Ok(Content::Document));
        let iaf = |day: [u8; 4]| [b" FLX".as_slice(), &day, &[0; 12], b"XYZG"].concat();
        assert_eq!(of(&iaf(2_024_366_i32.to_le_bytes())), Ok(Content::Iaf));
        assert!(of(&iaf(2_024_366_i32.to_be_bytes())).expect_err("order").contains("big-endian"));
        assert!(of(&iaf(2_024_367_i32.to_le_bytes())).expect_err("no day").contains("zero byte"));
        assert!(of(b"\xff\xfet\0").expect_err("UTF-16").contains("UTF-16"));
        assert!(of(b"t\0,\0x\0").expect_err("UTF-16").contains("UTF-16"));
        assert!(of(b"PK\x03\x04").expect_err("zip").contains("zip"));
    }
}
