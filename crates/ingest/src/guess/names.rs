//! Names of columns, as words that are known.

/// Letters and digits in lower case.
pub fn plain(name: &str) -> String {
    name.chars().filter(|letter| letter.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// Whether a word is one of those between blanks.
pub fn is_among(word: &str, known: &str) -> bool {
    known.split(' ').any(|known| known == word)
}
