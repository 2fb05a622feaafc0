//! Files that pandas and Python's json wrote (`fixtures/reference/tables.py`) are read to the same bits.

use std::collections::HashMap;
use tables::{Reader, Writer};

type Values = HashMap<String, Vec<Option<f64>>>;

fn values() -> Values {
    serde_json::from_str(&testkit::read_fixture("tables/tables.json")).expect("the values")
}

/// Bits, and none for what is missing.
fn bits(values: impl IntoIterator<Item = Option<f64>>) -> Vec<Option<u64>> {
    values.into_iter().map(|value| value.map(f64::to_bits)).collect()
}

fn check(reader: Reader) -> Vec<String> {
    let values = values();
    let names = reader.columns().to_vec();
    let mut columns = vec![Vec::new(); names.len()];
    for batch in reader {
        for (column, part) in columns.iter_mut().zip(batch.expect("a batch").columns) {
            column.extend(part.into_iter().map(|value| (!value.is_nan()).then_some(value)));
        }
    }
    for (name, column) in names.iter().zip(columns) {
        assert_eq!(bits(column), bits(values[name].iter().copied()), "{name}");
    }
    names
}

#[test]
fn every_file_has_the_values() {
    for file in ["plain.csv", "quoted.csv", "python.ndjson", "snappy.parquet", "zstd.parquet", "gzip.parquet"]
    {
        let reader = Reader::open(&testkit::fixture("tables").join(file), None).expect(file);
        assert_eq!(check(reader).len(), values().len(), "{file}");
    }
    let short = check(Reader::open(&testkit::fixture("tables/pandas.ndjson"), None).expect("opened"));
    assert_eq!(short, ["time_s", "code", "flag", "test_y_nt"]);
}

#[test]
fn wanted_columns_come_in_the_order_of_the_wish() {
    let wanted = ["flag", "time_s", "temperature_k"];
    for file in ["plain.csv", "quoted.csv", "python.ndjson", "zstd.parquet"] {
        let reader = Reader::open(&testkit::fixture("tables").join(file), Some(&wanted)).expect(file);
        assert_eq!(check(reader), wanted, "{file}");
    }
}

#[test]
fn what_is_written_anew_has_the_same_values() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut source = testkit::fixture("tables/zstd.parquet");
    for file in ["a.csv", "b.ndjson", "c.parquet", "d.JSONL"] {
        let reader = Reader::open(&source, None).expect("opened");
        let names = reader.columns().to_vec();
        source = folder.path().join(file);
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let mut writer = Writer::create(&source, &names).expect(file);
        for batch in reader {
            writer.write(&batch.expect("a batch").columns).expect("written");
        }
        writer.finish().expect("finished");
        check(Reader::open(&source, None).expect(file));
    }
}
