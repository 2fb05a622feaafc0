//! What of a document's text tells where something stands.

/// JSON text with 0 for each number and without spaces outside strings: every value is on its line. Of long
/// columns it is a tenth.
pub fn outline(text: &str) -> String {
    let mut kept = Vec::with_capacity(text.len() / 8);
    let mut rest = text.as_bytes();
    while let [first, others @ ..] = rest {
        let length = match first {
            b'"' => string(rest),
            b'-' | b'0'..=b'9' => {
                kept.push(b'0');
                rest = &others[others.iter().take_while(|byte| in_number(**byte)).count()..];
                continue;
            }
            b' ' => {
                rest = others;
                continue;
            }
            _ => 1,
        };
        kept.extend_from_slice(&rest[..length]);
        rest = &rest[length..];
    }
    // Of UTF-8 only whole ASCII characters are gone.
    String::from_utf8(kept).unwrap_or_default()
}

/// Whether a byte may follow the first one of a number.
fn in_number(byte: u8) -> bool {
    byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.' | b'e' | b'E')
}

/// Length of the string that a text begins with, with its quotes.
fn string(text: &[u8]) -> usize {
    let mut escaped = false;
    let end = text[1..].iter().position(|byte| {
        let ends = *byte == b'"' && !escaped;
        escaped = *byte == b'\\' && !escaped;
        ends
    });
    end.map_or(text.len(), |end| end + 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::line_of;

    #[test]
    fn values_stay_on_their_lines() {
        let text = "{\"a b\": [1.5e-3, -2,\n 3E+5, null, true],\n \"1 \\\" 2\": {\"µ\": -0.5}, \"e\":\n [[1, 2],\n  [3]]}";
        let short = outline(text);
        assert_eq!(short, "{\"a b\":[0,0,\n0,null,true],\n\"1 \\\" 2\":{\"µ\":0},\"e\":\n[[0,0],\n[0]]}");
        for path in ["a b[0]", "a b[2]", "a b[3]", "e[1][0]", "e", "1 \\\" 2.µ"] {
            assert_eq!(line_of(&short, path), line_of(text, path), "{path}");
        }
    }
}
