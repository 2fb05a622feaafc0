//! Markdown.

/// A table.
pub fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let mut text = format!("| {} |\n|{}\n", head.join(" | "), " --- |".repeat(head.len()));
    for row in rows {
        text += &format!("| {} |\n", row.join(" | "));
    }
    text + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_as_many_rules_as_columns() {
        let text = table(&["", "x"], &[vec!["rms".into(), "1".into()]]);
        assert_eq!(text, "|  | x |\n| --- | --- |\n| rms | 1 |\n\n");
    }
}
