//! What a program wrote goes to the next one, which may not refuse it.

use serde_json::Value;

use crate::finding::{Fault, Rule};
use crate::run::{End, Ended};

/// A refusal as a fault of the program before, unless what is refused was there before it.
///
/// `read` is what the program before read, with how the refusing one ended on that, where it reads such
/// files; `written` what it wrote, with what is said of it. That something is missing, and that there is
/// nothing to do, is no fault of what was written, unless there was something to do before; nor are readings
/// below one quantisation step, which a plan or a model may well make.
pub fn refused(read: (&[u8], Option<&Ended>), written: (&[u8], &str)) -> Option<Fault> {
    let now = said(written.1);
    if now.contains("found the constant reading") {
        return None;
    }
    let then = read.1.filter(|then| then.end != End::Code(0)).map(|then| said(&then.stderr));
    let was_done = read.1.is_some() && then.is_none();
    let place = path(&now);
    let at = |text: &[u8]| serde_json::from_slice::<Value>(text).ok()?.pointer(place.as_ref()?).map(rounded);
    let is_missing = place.is_none()
        || at(written.0).is_none()
        || ["found no ", "found nothing", "found neither "].iter().any(|words| now.contains(words));
    let is_alike = if is_missing { !was_done } else { at(read.0) == at(written.0) };
    (then.as_ref() != Some(&now) && !is_alike).then(|| Fault::new(Rule::Refused, now))
}

/// A message without the place in the file, which differs.
fn said(message: &str) -> String {
    let message = message.trim();
    match message.split_once(", line ") {
        Some((_, rest)) => {
            rest.trim_start_matches(|c: char| c.is_ascii_digit()).trim_start_matches(": ").into()
        }
        None => message.split_once(": ").map_or(message, |(_, rest)| rest).into(),
    }
}

/// The place that a message begins with, as a JSON pointer.
fn path(message: &str) -> Option<String> {
    let (path, _) = message.split_once(": found ")?;
    if path.contains(' ') {
        return None;
    }
    Some(format!("/{}", path.replace(['.', '['], "/").replace(']', "")))
}

/// A value in which a number has one spelling.
fn rounded(value: &Value) -> Value {
    match value {
        Value::Number(number) => serde_json::json!(number.as_f64()),
        Value::Array(list) => list.iter().map(rounded).collect(),
        Value::Object(map) => map.iter().map(|(key, value)| (key.clone(), rounded(value))).collect(),
        other => other.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whose_fault_it_is() {
        let read = br#"{"a": [{"b": 1}], "c": 2}"#;
        let written = br#"{"a": [{"b": 1.0}], "c": -1}"#;
        let ended =
            |code: i32, said: &str| Ended { end: End::Code(code), stdout: Vec::new(), stderr: said.into() };
        let told = |then: &str, now: &str| {
            refused((read, Some(&ended(2, then))), (written, now)).map(|fault| fault.found)
        };
        assert_eq!(told("correct: x.json, line 3: c: found 2", "correct: x.json, line 9: c: found 2"), None);
        assert_eq!(told("", "correct: in.json, line 9: a[0].b: found 1; expected 2"), None);
        assert_eq!(told("", "correct: in.json, line 9: c: found -1"), Some("c: found -1".into()));
        assert_eq!(told("correct: a: found 1", "correct: in.json, line 1: d: found nothing"), None);
        assert_eq!(told("correct: no", "correct: nothing to do"), None);
        assert_eq!(told("", "sensorcal: in.json, line 9: c: found the constant reading 2"), None);
        let done = ended(0, "");
        assert!(refused((read, Some(&done)), (written, "correct: nothing to do")).is_some());
        assert!(refused((b"", None), (written, "correct: nothing to do")).is_none());
    }
}
