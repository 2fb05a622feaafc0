//! What of a document's text tells where something stands.

/// JSON text with 0 for each number and without spaces outside strings: every value is on its line. Of long columns it is a tenth.
pub fn outline(text: String) -> String {
    let mut bytes = text.into_bytes();
    let (mut kept, mut within, mut escaped, mut number) = (0, false, false, false);
    for at in 0..bytes.len() {
        let byte = bytes[at];
        if within {
            within = escaped || byte != b'"';
            escaped = !escaped && byte == b'\\';
        } else {
            let goes_on = number && (byte.is_ascii_digit() || b"+-.eE".contains(&byte));
            number = goes_on || byte == b'-' || byte.is_ascii_digit();
            if goes_on || byte == b' ' {
                continue;
            }
            within = byte == b'"';
        }
        bytes[kept] = if number && !within { b'0' } else { byte };
        kept += 1;
    }
    bytes.truncate(kept);
    bytes.shrink_to_fit();
    // Of UTF-8 only whole ASCII characters are gone.
    String::from_utf8(bytes).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::line_of;

    #[test]
    fn values_stay_on_their_lines() {
        let text = "{\"a b\": [1.5e-3, -2,\n 3E+5, null, true],\n \"1 \\\" 2\": {\"µ\": -0.5}, \"e\":\n [[1, 2],\n  [3]]}";
        let short = outline(text.into());
        assert_eq!(short, "{\"a b\":[0,0,\n0,null,true],\n\"1 \\\" 2\":{\"µ\":0},\"e\":\n[[0,0],\n[0]]}");
        for path in ["a b[0]", "a b[2]", "a b[3]", "e[1][0]", "e", "1 \\\" 2.µ"] {
            assert_eq!(line_of(&short, path), line_of(text, path), "{path}");
        }
    }
}
