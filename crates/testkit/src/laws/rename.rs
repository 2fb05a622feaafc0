//! The axes by other names.

use serde_json::{Map, Value};

use super::walk::is_prose;

/// Renames x to y, y to z and z to x, of sensors, coils, SEN and GEO together (north to east to down): the
/// same campaign in frames that are turned by a third about their diagonal.
/// Panics: of theodolite angles, which count from the vertical and have no such name: state orientations as matrices.
pub fn rename_axes(document: &Value) -> Value {
    renamed("", document)
}

fn renamed(key: &str, value: &Value) -> Value {
    match value {
        Value::Object(object) => {
            assert!(!object.contains_key("theodolite"), "orientations as matrices");
            let each = |(name, value): (&String, &Value)| {
                // What is listed by axis is known by the key above.
                let inner = if axis(name).is_some() { format!("{key} of an axis") } else { name.clone() };
                // Where the points of a series are is no axis.
                let kept = key == "series" && name == "x";
                (if kept { name.clone() } else { key_of(key, name) }, renamed(&inner, value))
            };
            object.iter().map(each).collect::<Map<_, _>>().into()
        }
        Value::Array(list) => {
            let list: Vec<Value> = list.iter().map(|item| renamed(key, item)).collect();
            match key {
                // All that is nine numbers runs over axes, but for a covariance, which names what it runs
                // over.
                _ if is_of_axes(&list) && key != "covariance" => {
                    let rows =
                        list.into_iter().map(|row| Value::Array(shifted(row.as_array().expect("a row"))));
                    Value::Array(shifted(&rows.collect::<Vec<_>>()))
                }
                "positions_m of an axis" | "directions of an axis" | "eta" if list.len() == 3 => {
                    Value::Array(shifted(&list))
                }
                _ => Value::Array(list),
            }
        }
        Value::String(text) if !is_prose(text) => Value::String(name_of(text)),
        other => other.clone(),
    }
}

fn is_of_axes(list: &[Value]) -> bool {
    let is_row =
        |row: &Value| row.as_array().is_some_and(|row| row.len() == 3 && row.iter().all(Value::is_number));
    list.len() == 3 && list.iter().all(is_row)
}

/// What stood at x stands at y.
fn shifted(list: &[Value]) -> Vec<Value> {
    (0..3).map(|k| list[(k + 2) % 3].clone()).collect()
}

/// A key; the two axes of an angle between them have no order.
fn key_of(parent: &str, name: &str) -> String {
    let new = name_of(name);
    if !parent.contains("non_orthogonality") {
        return new;
    }
    let mut letters: Vec<char> = new.chars().collect();
    letters.sort_unstable();
    letters.into_iter().collect()
}

/// A name with its words renamed: `sensor_x_v`, `north_ppm`, `yx`, `matrix[0][1]`.
fn name_of(name: &str) -> String {
    let mut new = String::new();
    let mut word = String::new();
    let mut indexed = false;
    for c in name.chars().chain(std::iter::once('\0')) {
        if c.is_ascii_alphanumeric() {
            word.push(c);
            continue;
        }
        new += &word_of(&word, indexed);
        word.clear();
        indexed = c == '[' && name.contains("matrix");
        if c != '\0' {
            new.push(c);
        }
    }
    new
}

fn word_of(word: &str, index: bool) -> String {
    let cycle = ["north", "east", "down"];
    if let Some(place) = cycle.iter().position(|name| *name == word) {
        return cycle[(place + 1) % 3].into();
    }
    if index && let Ok(place) = word.parse::<usize>() {
        return ((place + 1) % 3).to_string();
    }
    let axes: Option<String> = word.chars().map(|letter| axis(&letter.to_string())).collect();
    axes.filter(|axes| axes.len() <= 2).unwrap_or_else(|| word.into())
}

/// The new letter of an axis.
fn axis(letter: &str) -> Option<char> {
    let place = "xyz".find(letter).filter(|_| letter.len() == 1)?;
    "yzx".chars().nth(place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn three_renamings_are_none() {
        let document = json!({
            "recordings": [{"id": "a", "conditions": {"sensor": "x", "orientation": [[1, 2, 3], [4, 5, 6], [7, 8, 9]]},
                "columns": {"sensor_x_v": [1, 2, 3], "coil_z_a": [4, 5, 6]}}],
            "calibration": {"axes": {"sensors": {"covariance_order": ["matrix[0][2]"], "non_orthogonality_arcsec": {"xy": 1, "yz": 2, "xz": 3}}}},
            "model": {"effects": [{"effect": "soft_iron", "parameters": {"xz_ppm": 1, "north_nt": 2}}]},
            "words": "sensor x is off"
        });
        let once = rename_axes(&document);
        let (recording, sensors) = (&once["recordings"][0], &once["calibration"]["axes"]["sensors"]);
        let conditions = json!({"sensor": "y", "orientation": [[9, 7, 8], [3, 1, 2], [6, 4, 5]]});
        assert_eq!(recording["conditions"], conditions);
        assert_eq!(recording["columns"], json!({"sensor_y_v": [1, 2, 3], "coil_x_a": [4, 5, 6]}));
        assert_eq!(sensors["covariance_order"][0], "matrix[1][0]");
        assert_eq!(sensors["non_orthogonality_arcsec"], json!({"yz": 1, "xz": 2, "xy": 3}));
        assert_eq!(once["model"]["effects"][0]["parameters"], json!({"yx_ppm": 1, "east_nt": 2}));
        assert_eq!(rename_axes(&rename_axes(&once)), document);
    }
}
