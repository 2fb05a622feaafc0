//! The header of a HAPI server's CSV (HAPI 2 and 3): lines that begin with `#` and together are one JSON object, whose
//! `parameters` have name, unit and fill value, and the size of those that take several columns.

use serde_json::Value;
use tables::COLUMN_LIMIT;

use crate::text::{lines, list};

pub struct Column {
    pub name: String,
    pub unit: Option<String>,
    pub fill: Option<f64>,
}

/// The columns, the time first; None where there is no such header.
pub fn header(bytes: &[u8]) -> Option<Vec<Column>> {
    if !bytes.starts_with(b"#") {
        return None;
    }
    let head = lines(bytes).map_while(|(_, line)| line.trim_ascii_start().strip_prefix(b"#"));
    let object: Value = serde_json::from_slice(&head.collect::<Vec<_>>().join(&b'\n')).ok()?;
    object.get("HAPI")?;
    let mut columns = Vec::new();
    for parameter in object.get("parameters")?.as_array()? {
        let count =
            list(&parameter["size"]).iter().try_fold(1_u64, |all, size| all.checked_mul(size.as_u64()?))?;
        let count = usize::try_from(count).ok().filter(|count| columns.len() + count <= COLUMN_LIMIT)?;
        columns.extend((0..count).map(|index| column(parameter, index, count)));
    }
    Some(columns)
}

/// A parameter's column of that number; what the header says once is for all of them.
fn column(parameter: &Value, index: usize, count: usize) -> Column {
    let of = |key: &str| match &parameter[key] {
        Value::Array(list) => list.get(index).and_then(Value::as_str).map(str::to_string),
        Value::String(text) if key != "label" || count == 1 => Some(text.clone()),
        _ => None,
    };
    let name = parameter["name"].as_str().unwrap_or_default();
    let name = match of("label").or_else(|| of("vectorComponents")) {
        _ if count == 1 => name.to_string(),
        Some(label) => format!("{name}_{label}"),
        None if count == 3 && parameter["coordinateSystemName"].is_string() => {
            format!("{name}_{}", ["x", "y", "z"][index])
        }
        None => format!("{name}_{}", index + 1),
    };
    Column { name, unit: of("units"), fill: of("fill").and_then(|fill| fill.parse().ok()) }
}

#[cfg(test)]
mod tests {
    use super::header;

    #[test]
    fn sizes_are_not_believed() {
        let of = |size: &str| {
            let text = format!(
                "#{{\"HAPI\": \"3.0\", \"parameters\":\n# [{{\"name\": \"B\", \"size\": {size}}}]}}\n1\n"
            );
            header(text.as_bytes())
                .map(|columns| columns.into_iter().map(|column| column.name).collect::<Vec<_>>())
        };
        assert_eq!(of("[3]"), Some(["B_1", "B_2", "B_3"].map(String::from).to_vec()));
        assert_eq!(of("[9000000000000000000, 9]"), None);
        assert_eq!(of("[1000000000]"), None);
        assert!(header(b"#{\"HAPI\": 3").is_none() && header(b"# a comment\n").is_none());
    }
}
