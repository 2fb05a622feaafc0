use serde::Serialize;
use serde_json::Value;
use serde_json::ser::Formatter;
use std::io::{self, Write};

/// JSON as people read it: an object's keys on lines of their own, lists of numbers on one line.
pub fn to_text<T: Serialize>(value: &T) -> String {
    written(value, true) + "\n"
}

/// JSON on one line, without spaces.
pub fn to_line<T: Serialize>(value: &T) -> String {
    written(value, false)
}

/// The JSON of one value with that of another put over it: objects key by key, all else as a whole.
pub(crate) fn overlaid<T: Serialize>(under: &T, over: &T) -> String {
    let value = |one: &T| -> Value { serde_json::from_str(&to_text(one)).expect("what was just written") };
    let mut merged = value(under);
    overlay(&mut merged, value(over));
    merged.to_string()
}

fn overlay(under: &mut Value, over: Value) {
    match (under, over) {
        (Value::Object(under), Value::Object(over)) => {
            for (key, value) in over {
                overlay(under.entry(key).or_insert(Value::Null), value);
            }
        }
        (under, over) => *under = over,
    }
}

/// One serializer for both: a type's code for it is made once.
fn written<T: Serialize>(value: &T, spaced: bool) -> String {
    let mut lines = Lines(Vec::new());
    let format = Format { spaced, ..Format::default() };
    let mut serializer = serde_json::Serializer::with_formatter(&mut lines, format);
    value.serialize(&mut serializer).expect("a document has string keys and finite numbers");
    String::from_utf8(lines.0).expect("serde_json writes UTF-8")
}

/// Text without spaces at the ends of its lines: one follows each item of a list, and an object begins on a
/// new line.
struct Lines(Vec<u8>);

impl Write for Lines {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if bytes.first() == Some(&b'\n') && self.0.last() == Some(&b' ') {
            self.0.pop();
        }
        self.0.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Line breaks belong to objects only: each key on its line, and each object of a list on a new one.
#[derive(Default)]
struct Format {
    /// With line breaks and spaces.
    spaced: bool,
    /// For each open bracket: whether it is a list.
    open: Vec<bool>,
    /// Whether the bracket opened last has content.
    filled: bool,
}

impl Format {
    fn line<W: ?Sized + Write>(&self, writer: &mut W) -> io::Result<()> {
        if !self.spaced {
            return Ok(());
        }
        writer.write_all(b"\n")?;
        self.open.iter().try_for_each(|_| writer.write_all(b"  "))
    }
}

impl Formatter for Format {
    fn begin_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.open.push(true);
        writer.write_all(b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.open.pop();
        self.filled = true;
        writer.write_all(b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        match (first, self.spaced) {
            (true, _) => Ok(()),
            (false, true) => writer.write_all(b", "),
            (false, false) => writer.write_all(b","),
        }
    }

    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        if self.open.last() == Some(&true) {
            self.line(writer)?;
        }
        self.open.push(false);
        self.filled = false;
        writer.write_all(b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.open.pop();
        if self.filled {
            self.line(writer)?;
        }
        self.filled = true;
        writer.write_all(b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        if !first {
            writer.write_all(b",")?;
        }
        self.line(writer)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(if self.spaced { ": " } else { ":" }.as_bytes())
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, _: &mut W) -> io::Result<()> {
        self.filled = true;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    #[test]
    fn numbers_in_lines_and_objects_on_lines() {
        let value = json!({"a": [[1, 2], [3, 4]], "b": [{"c": 1.5}, {}], "d": {}});
        let text = super::to_text(&value);
        assert_eq!(
            text,
            "{\n  \"a\": [[1, 2], [3, 4]],\n  \"b\": [\n    {\n      \"c\": 1.5\n    },\n    {}],\n  \"d\": {}\n}\n"
        );
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).expect("valid"), value);
        assert_eq!(super::to_line(&value), value.to_string());
    }
}
