//! Which columns are wanted of those that there are.

use std::collections::HashMap;

use crate::{COLUMN_LIMIT, Error, Place, fault, listed};

/// Checks the names of a table, and gives the place of each wanted column among them.
pub fn select(
    source_name: &str,
    names: &[String],
    place: Place,
    wanted: &[&str],
) -> Result<Vec<usize>, Error> {
    let refused = |found: String, expected: &str| Err(fault(source_name, place, found, expected));
    if names.len() > COLUMN_LIMIT {
        let expected = format!("at most {COLUMN_LIMIT}; are rows and columns exchanged?");
        return refused(format!("{} columns", names.len()), &expected);
    }
    let mut places = HashMap::new();
    for (column, name) in names.iter().enumerate() {
        if name.is_empty() {
            let found = format!("no name for column {}", column + 1);
            return refused(found, "a name for each (pandas: index=False)");
        }
        if let Some(first) = places.insert(name.as_str(), column) {
            let found = format!("column {name} twice, as columns {} and {}", first + 1, column + 1);
            return refused(found, "a name of its own for each column");
        }
    }
    let absent: Vec<_> = wanted.iter().copied().filter(|name| !places.contains_key(name)).collect();
    if !absent.is_empty() {
        let expected = format!("it among those there are: {}", listed(names, 30));
        return refused(format!("no column {}", absent.join(", ")), &expected);
    }
    Ok(wanted.iter().map(|name| places[name]).collect())
}

/// Refuses an empty wish and a name in it twice.
pub fn check_wish(source_name: &str, wanted: Option<&[&str]>) -> Result<(), Error> {
    let Some(wanted) = wanted else { return Ok(()) };
    let twice = wanted.iter().enumerate().find(|(column, name)| wanted[..*column].contains(name));
    match (wanted.is_empty(), twice) {
        (true, _) => Err(Error::Request(format!("{source_name}: no columns are wanted; name one at least"))),
        (_, Some((_, name))) => Err(Error::Request(format!("{source_name}: column {name} is wanted twice"))),
        _ => Ok(()),
    }
}
