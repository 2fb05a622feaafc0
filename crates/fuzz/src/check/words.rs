//! Words of people, and words of programs.

use crate::finding::{Fault, Rule};

/// Numbers that are none.
const NO_NUMBERS: [&str; 5] = ["NaN", "inf", "nan", "Infinity", "infinity"];

/// What only those who wrote the program understand, with bars between.
const INSIDES: &str =
    "untagged enum|Some(|invalid length|expected struct|expected a string key|called `|Err(|Ok(";

/// The parts of a text that are one word each.
fn tokens(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_alphanumeric() && c != '_')
}

/// What people read of a text: a page has its scripts, and the numbers of its plots coded.
pub fn shown(text: &str) -> String {
    let mut parts = text.split("<script");
    let first = parts.next().unwrap_or_default().to_string();
    parts.fold(first, |shown, part| shown + part.split_once("</script>").map_or("", |(_, rest)| rest))
}

/// A number that is none, with the words around it, unless it was read.
pub fn no_number(text: &str, read: &[u8], asked: &str) -> Option<String> {
    let read = String::from_utf8_lossy(read);
    // In capitals or not: names of columns are written small.
    let was_read = |word: &str| tokens(&read).any(|token| token.eq_ignore_ascii_case(word));
    let is_repeated = |word: &str| asked.contains(word) || was_read(word);
    let word =
        NO_NUMBERS.into_iter().find(|word| tokens(text).any(|token| token == *word) && !is_repeated(word));
    // A page says how many points of a plot were missing.
    let is_not_finite = || text.matches("not finite").count() > text.matches("missing or not finite").count();
    let word = word.or_else(|| is_not_finite().then_some("not finite"))?;
    let line = text.lines().find(|line| tokens(line).any(|token| token == word) || line.contains(word))?;
    let at = line.find(word).unwrap_or_default();
    let begin = (0..=at.saturating_sub(80)).rev().find(|at| line.is_char_boundary(*at)).unwrap_or_default();
    Some(line[begin..].chars().take(160).collect())
}

/// A failure is told, and not in the words of the program's insides.
pub fn message(said: &str, read: &[u8], asked: &str) -> Option<Fault> {
    if said.trim().is_empty() {
        return Some(Fault::new(Rule::Message, "it failed without a word"));
    }
    let is_repeated =
        |word: &str| asked.contains(word) || read.windows(word.len()).any(|part| part == word.as_bytes());
    // Of words that begin so, not of those that have it within.
    let begins =
        |word: &str| said.match_indices(word).any(|(at, _)| !said[..at].ends_with(char::is_alphanumeric));
    let inside = INSIDES.split('|').find(|word| begins(word) && !is_repeated(word));
    let none = (tokens(said).any(|token| token == "None") && !is_repeated("None")).then_some("None");
    let found: String = said.trim().chars().take(300).collect();
    inside.or(none).map(|word| Fault::new(Rule::Message, format!("`{word}` in: {found}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_none() {
        let found = |text: &str| no_number(text, b"id: Infinity", "coilcal in.json");
        assert_eq!(found("1.5 ± NaN nT"), Some("1.5 ± NaN nT".into()));
        assert_eq!(found("x\nlies by -inf nT"), Some("lies by -inf nT".into()));
        assert_eq!(found("information of Nancy, \"Infinity\""), None);
    }

    #[test]
    fn messages_are_for_people() {
        let fault = |said: &str| message(said, b"", "").map(|fault| fault.found);
        assert_eq!(fault("axescal: found nothing; expected something"), None);
        assert_eq!(fault(" \n"), Some("it failed without a word".into()));
        assert_eq!(fault("found None"), Some("`None` in: found None".into()));
        assert_eq!(fault("Nonetheless, None-such"), Some("`None` in: Nonetheless, None-such".into()));
        assert!(message("found None", b"\"None\"", "").is_none());
        assert!(fault("expected struct Grid").is_some() && fault("Unexpected struct field").is_none());
    }
}
