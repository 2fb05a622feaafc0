//! The scores of all releases, one line each, none left out.

use std::path::Path;

use crate::Error;
use crate::folder::{read, write};
use crate::score::Score;

/// How much of a commitment names a line.
const SHORT: usize = 12;

/// The page with a line more for a score, unless it has that of the commitment already.
pub fn with(page: &str, score: &Score) -> String {
    let short = &score.seal[..SHORT.min(score.seal.len())];
    if page.contains(short) {
        return page.to_string();
    }
    let mut text = page.to_string();
    if text.is_empty() {
        text += "# Scores by release\n\n\
            Each line is written by `blind score`, and none is taken out; all figures but the last line's are of earlier builds. The commitment is the beginning of the digest of the seals.\n";
    }
    let mut header = String::from("| commitment | cases |");
    score.goals().iter().for_each(|goal| header += &format!(" {} |", goal.what));
    // Goals that were not there before need a table of their own.
    if text.lines().rfind(|line| line.starts_with("| commitment")) != Some(&header) {
        text += &format!("\n{header}\n| --- | --- |{}\n", " --- |".repeat(score.goals().len()));
    }
    text += &format!("| `{short}` | {} |", score.outcomes.len());
    for goal in score.goals() {
        let found = goal.found;
        text += &if found.trials == 0 {
            " – |".into()
        } else {
            format!(" {} of {} |", found.hits, found.trials)
        };
    }
    text + "\n"
}

/// Adds the line of a score to a file.
pub fn add(path: &Path, score: &Score) -> Result<(), Error> {
    let page = if path.is_file() { read(path)? } else { String::new() };
    write(path, &with(&page, score))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_score_stands_once() {
        let score = |seal: &str| Score { outcomes: Vec::new(), real: Vec::new(), seal: seal.into() };
        let first = with("", &score("0123456789abcdef"));
        assert_eq!(first.lines().count(), 7, "{first}");
        assert_eq!(with(&first, &score("0123456789abcdef")), first);
        let second = with(&first, &score("ffff456789abcdef"));
        assert!(second.starts_with(&first) && second.lines().count() == 8);
    }
}
