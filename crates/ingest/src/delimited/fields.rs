//! What stands between separators.

use memchr::memchr;

/// The fields of a line: between separators, quotes taken off; of blanks any number is one separator.
pub fn fields(line: &[u8], separator: char) -> Vec<&[u8]> {
    let mut all = Vec::new();
    let mut rest = Some(line);
    while let Some(line) = rest {
        match next_field(line, separator as u8) {
            Some((field, after)) => {
                all.push(field);
                rest = after;
            }
            None => break,
        }
    }
    all
}

/// The first field of a line, and the rest after its separator; None where blanks are all that is left.
#[inline]
pub fn next_field(line: &[u8], separator: u8) -> Option<(&[u8], Option<&[u8]>)> {
    if separator == b' ' {
        let line = line.trim_ascii_start();
        let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        return (!line.is_empty()).then(|| (&line[..end], Some(&line[end..])));
    }
    if line.first() == Some(&b'"') {
        let mut at = 1;
        // A quote within quotes is written twice.
        while let Some(end) = memchr(b'"', &line[at..]) {
            at += end + 1;
            if line.get(at) != Some(&b'"') {
                let end = memchr(separator, &line[at..]).map_or(line.len(), |end| at + end);
                return Some((&line[1..at - 1], line.get(end + 1..).filter(|_| end < line.len())));
            }
            at += 1;
        }
    }
    Some(match memchr(separator, line) {
        Some(end) => (&line[..end], Some(&line[end + 1..])),
        None => (line, None),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::decoded;

    #[test]
    fn fields_between_separators() {
        let of = |line: &str, separator: char| -> Vec<String> {
            fields(line.as_bytes(), separator).into_iter().map(|field| decoded(field).into_owned()).collect()
        };
        assert_eq!(of("a,b,,c", ','), ["a", "b", "", "c"]);
        assert_eq!(of("a;b;", ';'), ["a", "b", ""]);
        assert_eq!(of("\"a,b\",\"c\"\"d\",e", ','), ["a,b", "c\"\"d", "e"]);
        assert_eq!(of("  a \t b  ", ' '), ["a", "b"]);
        assert_eq!(of("\"x\"", ','), ["x"]);
    }
}
