//! Names of columns beside lists of known words.

/// Letters and digits in lower case.
pub fn plain(name: &str) -> String {
    name.chars().filter(|letter| letter.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// Whether a word is in a list of words separated by single blanks.
pub fn is_among(word: &str, known: &str) -> bool {
    known.split(' ').any(|known| known == word)
}
