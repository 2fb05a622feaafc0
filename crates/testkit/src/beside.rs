use serde_json::Value;
use std::fs;

use crate::{fixture, run_in};

/// A stage finds in a document whose recordings keep their readings in files beside it what it finds in the
/// document that holds them (a fixture), and leaves the files alone.
pub fn beside(program: &str, input: &str) {
    let mut document: Value = serde_json::from_str(&crate::read_fixture(input)).expect("JSON");
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("data")).expect("a folder");
    for (number, recording) in
        document["recordings"].as_array_mut().expect("recordings").iter_mut().enumerate()
    {
        let recording = recording.as_object_mut().expect("an object");
        let columns = recording.remove("columns").expect("columns");
        let columns = columns.as_object().expect("an object");
        let rows = columns.values().map(|column| column.as_array().map_or(0, Vec::len)).max().unwrap_or(0);
        let names: Vec<&str> = columns.keys().map(String::as_str).collect();
        let mut text = names.join(",") + "\n";
        for row in 0..rows {
            let cell =
                |column: &Value| if column[row].is_null() { String::new() } else { column[row].to_string() };
            text += &(columns.values().map(cell).collect::<Vec<_>>().join(",") + "\n");
        }
        let table = format!("data/{number}.csv");
        fs::write(folder.path().join(&table), text).expect("written");
        recording.insert("table".into(), table.into());
        recording.entry("conditions").or_insert_with(|| Value::Object(serde_json::Map::new()));
    }
    fs::write(folder.path().join("campaign.json"), document.to_string()).expect("written");
    let whole = fixture(input).canonicalize().expect("a fixture");
    let read = |input: &str| -> Value {
        let run = run_in(program, folder.path(), &["-q", input]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        serde_json::from_str(&run.stdout).expect("JSON")
    };
    let (apart, together) = (read("campaign.json"), read(whole.to_str().expect("UTF-8")));
    assert_eq!(apart["recordings"], document["recordings"]);
    for part in ["calibration", "model", "diagnosis"] {
        assert_eq!(apart[part], together[part], "{part}");
    }
}
