//! Other names of columns.

use common::{Columns, Error, Recording};

/// Renames columns of a recording, by old names and new ones; what was done, in words.
pub fn rename(recording: &mut Recording, path: &str, names: &[(String, String)]) -> Result<String, Error> {
    let mut said = Vec::new();
    let mut columns = Columns::new();
    for (name, column) in std::mem::take(&mut recording.columns) {
        let new = names.iter().find_map(|(old, new)| renamed(&name, old, new));
        if let Some(new) = &new {
            said.push(format!("{name} is {new}"));
        }
        let new = new.unwrap_or(name);
        if columns.insert(new.clone(), column).is_some() {
            let found = format!("two columns {new} in \"{}\"", recording.id);
            return Err(Error::document(format!("{path}.columns"), found, "each name once"));
        }
    }
    recording.columns = columns;
    if said.is_empty() {
        let there: Vec<&str> = recording.columns.keys().map(String::as_str).take(30).collect();
        let asked: Vec<&str> = names.iter().map(|(old, _)| old.as_str()).collect();
        let found = format!("no column {} among {}", asked.join(", "), there.join(", "));
        let expected = "a column's name, or how some begin, such as sensor=test";
        return Err(Error::document(format!("{path}.columns"), found, expected));
    }
    Ok(said.join(", "))
}

/// A name's new one: `sensor=test` makes `test_x_nt` of `sensor_x_nt`.
fn renamed(name: &str, old: &str, new: &str) -> Option<String> {
    if name == old {
        return Some(new.to_string());
    }
    let rest = name.strip_prefix(old)?;
    rest.starts_with('_').then(|| format!("{new}{rest}"))
}
