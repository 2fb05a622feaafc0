//! What no formatter of numbers for people writes.

/// Nouns that programs count.
const COUNTED: &str = "candidates dates degrees files findings gaps levels orientations pairs plots points \
    readings recordings rows samples steps";

/// The places where words for people do not have the form of `common::number`: `5.2e-15`, `-3`, `1 rows`, and
/// uncertainties that have not two digits, or not the decimals of their value.
pub fn ill_written(text: &str) -> Vec<String> {
    text.lines().flat_map(in_line).collect()
}

fn in_line(text: &str) -> Vec<String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let mut wrong = Vec::new();
    for (at, word) in words.iter().enumerate() {
        let bare = word
            .trim_start_matches(['(', '[', '"'])
            .trim_end_matches([')', ']', '"', '″', ',', ';', ':', '.']);
        let number = bare.parse::<f64>().is_ok() && bare.contains(|c: char| c.is_ascii_digit());
        if number && (bare.contains(['e', 'E']) || bare.starts_with('-')) {
            wrong.push(bare.to_string());
        }
        let next = words.get(at + 1).map(|next| next.trim_end_matches(|c: char| !c.is_alphabetic()));
        if let Some(noun) = next.filter(|next| bare == "1" && COUNTED.split(' ').any(|noun| noun == *next)) {
            wrong.push(format!("1 {noun}"));
        }
        if let (Some(before), "±", Some(after)) =
            (at.checked_sub(1).map(|at| words[at]), *word, words.get(at + 1))
            && let (Some(value), Some(std)) = (digits(before), digits(after))
            && !agree(&value, &std)
        {
            wrong.push(format!("{before} ± {after}"));
        }
    }
    wrong
}

/// The plain digits of a number that stands by itself, without its sign.
fn digits(word: &str) -> Option<String> {
    let word = word.trim_start_matches(['(', '+', '−', '-']);
    let end = word.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(word.len());
    let whole = !word[end..].starts_with(['°', ')']) || word[end..].starts_with(")·");
    (end > 0 && whole).then(|| word[..end].trim_end_matches('.').to_string())
}

fn agree(value: &str, std: &str) -> bool {
    let decimals = |number: &str| number.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let figures = std.replace('.', "");
    let figures = figures.trim_start_matches('0');
    let two = figures.len() == 2 || !std.contains('.') && figures.trim_end_matches('0').len() <= 2;
    std == "0" || two && decimals(value) == decimals(std)
}

#[cfg(test)]
mod tests {
    use super::ill_written;

    #[test]
    fn what_the_formatter_writes_is_well_written() {
        for text in [
            "x +0.3085 ± 0.0043 nT, y −12 ± 11, z (−1.8 ± 1.1)·10⁻⁷ (adjusted p = 5.2·10⁻¹⁵)",
            "(+0.9997498, +0.0100017, +0.0200091) ± 1.3\"; 89.99123° ± 0.43″; it would be ± 0.0070 nT",
            "1 row of 60 s, 21 rows, 123500 ± 1200 nT, 2.5 ± 0, 2024-03-10 to flx-1, 1 is left out",
        ] {
            assert_eq!(ill_written(text), Vec::<String>::new(), "{text}");
        }
    }

    #[test]
    fn what_it_does_not_write_is_seen() {
        let text = "(p = 5.2e-15), t = -3.4; 1 rows: 6401.1960 ± 0.0146 nT/V, +0.308 ± 0.0050, 0.39 ± 0.2";
        let wrong = ["5.2e-15", "-3.4", "1 rows", "6401.1960 ± 0.0146", "+0.308 ± 0.0050,", "0.39 ± 0.2"];
        assert_eq!(ill_written(text), wrong);
    }
}
