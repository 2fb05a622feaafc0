//! What the source of a recording says is in it, and whether a stage that was not told found it.

use crate::markdown;

/// One thing that is known.
#[derive(Clone, Debug)]
pub struct KnownFact {
    /// What says so.
    pub from: &'static str,
    /// What is known.
    pub what: &'static str,
    /// The stage that was asked, and was not told.
    pub stage: &'static str,
    /// What it answered, in a few words.
    pub answer: String,
    /// Whether that is what is known.
    pub found: bool,
}

/// A table of them, what was not found first.
pub fn table(known: impl Iterator<Item = KnownFact>) -> String {
    let mut known: Vec<KnownFact> = known.collect();
    known.sort_by_key(|one| one.found);
    let word = |found: bool| if found { "yes" } else { "**no**" };
    let row = |one: KnownFact| {
        vec![
            one.from.into(),
            one.what.into(),
            format!("`{}`: {}", one.stage, one.answer),
            word(one.found).into(),
        ]
    };
    markdown::table(
        &["known from", "what", "a stage that was not told", "found"],
        &known.into_iter().map(row).collect::<Vec<_>>(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_found_stands_first() {
        let one = |answer: &str, found| KnownFact {
            from: "notes",
            what: "a clock",
            stage: "diffmag",
            answer: answer.into(),
            found,
        };
        let text = table([one("late", true), one("nothing", false)].into_iter());
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[2], "| notes | a clock | `diffmag`: nothing | **no** |");
        assert!(lines[3].ends_with("| yes |"), "{text}");
    }
}
