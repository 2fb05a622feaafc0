//! Each fault has its message: where, what was found, what was expected.

use std::fmt::Write as _;
use std::fs;
use std::io::Cursor;
use std::path::Path;
use tables::{BATCH_ROWS, COLUMN_LIMIT, Error, Format, LINE_LIMIT, Reader, Writer};

fn read(format: Format, bytes: impl Into<Vec<u8>>, wanted: Option<&[&str]>) -> Result<usize, Error> {
    let input = Cursor::new(bytes.into());
    Reader::from_read(input, format, "x", wanted)?.map(|batch| batch.map(|batch| batch.rows())).sum()
}

fn message(format: Format, bytes: impl Into<Vec<u8>>, wanted: Option<&[&str]>) -> String {
    read(format, bytes, wanted).expect_err("a fault").to_string()
}

fn csv(text: &str) -> String {
    message(Format::Csv, text, None)
}

fn ndjson(text: &str) -> String {
    message(Format::NdJson, text, None)
}

#[test]
fn headers() {
    let header = "expected a line of column names, cut at commas";
    assert_eq!(csv(""), format!("x: found no header; {header}"));
    assert_eq!(csv("# only words\n"), format!("x: found no header; {header}"));
    assert_eq!(csv("\na\n"), format!("x, line 1: found an empty line; {header}"));
    assert_eq!(csv("# words\n0.5,1\n"), format!("x, line 2: found the number 0.5; {header}"));
    assert_eq!(csv("a,\"b\n1,2\n"), format!("x, line 1: found a quote that is not closed; {header}"));
    assert_eq!(
        csv("a,b,a\n"),
        "x, line 1: found column a twice, as columns 1 and 3; expected a name of its own for each column"
    );
    assert_eq!(
        csv(",b\n"),
        "x, line 1: found no name for column 1; expected a name for each (pandas: index=False)"
    );
    assert_eq!(
        message(Format::Csv, b"a\xff\n1\n", None),
        "x, line 1: found byte 2 of the line, which is not UTF-8; expected text in UTF-8"
    );
}

#[test]
fn wishes() {
    for (format, text) in [(Format::Csv, "a,b\n1,2\n"), (Format::NdJson, "{\"a\":1,\"b\":2}\n")] {
        assert_eq!(message(format, text, Some(&[])), "x: no columns are wanted; name one at least");
        assert_eq!(message(format, text, Some(&["a", "a"])), "x: column a is wanted twice");
    }
    assert_eq!(
        message(Format::Csv, "a,b\n1,2\n", Some(&["b", "c", "d"])),
        "x, line 1: found no column c, d; expected it among those there are: a, b"
    );
    assert_eq!(
        message(Format::NdJson, "{\"a\":1}\n{\"b\":2}\n", Some(&["a", "b", "c"])),
        "x: found no line with the key c; expected it in one at least"
    );
    assert_eq!(read(Format::NdJson, "{\"a\":1}\n{\"b\":2}\n", Some(&["a", "b"])).expect("read"), 2);
}

#[test]
fn values_of_csv() {
    let value = |line: u64, column: &str, found: &str| {
        format!(
            "x, line {line}, column {column}: found {found}; expected a finite number, or nothing where one is missing"
        )
    };
    assert_eq!(csv("a,b_nt\n1,2\n3,four\n"), value(3, "2 (b_nt)", "\"four\""));
    assert_eq!(csv("a,b_nt\n1,2\n\"3x\",4\n"), value(3, "1 (a)", "\"\\\"3x\\\"\""));
    assert_eq!(csv("a,b_nt\n1,inf\n"), value(2, "2 (b_nt)", "\"inf\""));
    assert_eq!(csv("a,b_nt\n-Infinity,1\n"), value(2, "1 (a)", "\"-Infinity\""));
    assert_eq!(csv("a,b_nt\n1,1e999\r\n"), value(2, "2 (b_nt)", "\"1e999\""));
    assert_eq!(csv("a,b_nt\n1,1.0 2.0\n"), value(2, "2 (b_nt)", "\"1.0 2.0\""));
    assert_eq!(csv("a,b_nt\n1;2,3\n"), value(2, "1 (a)", "\"1;2\""));
    assert_eq!(
        csv("a,b_nt\n1,\"2\n3,4\n"),
        "x, line 2, column 2 (b_nt): found \"\\\"2\", a quote that is not closed on its line; expected a closing quote"
    );
    let late = format!("a,b\n{}1,2\n1,z\n", "1,2\n".repeat(2 * BATCH_ROWS));
    let line = 2 * BATCH_ROWS as u64 + 3;
    assert_eq!(csv(&late), value(line, "2 (b)", "\"z\""));
    assert_eq!(
        message(Format::Csv, b"a,b\n1,2\n1,\xc3\x28\n", Some(&["a"])),
        "x, line 3: found byte 3 of the line, which is not UTF-8; expected text in UTF-8"
    );
}

#[test]
fn rows_of_csv() {
    let row = |line: u64, found: &str| {
        format!("x, line {line}: found {found}; expected 2, one for each name in the header")
    };
    assert_eq!(csv("a,b\n1,2\n3\n"), row(3, "1 value"));
    assert_eq!(csv("a,b\n1,2,3\n"), row(2, "3 values"));
    assert_eq!(csv("a,b\n1,2\n3,4\n5"), row(4, "1 value"));
    assert_eq!(csv("a,b\n1,2,\r\n"), row(2, "3 values"));
    assert_eq!(message(Format::Csv, "a,b\n1,2\n3,4,\"5,6\"\n", Some(&["a"])), row(3, "3 values"));
    let empty =
        |line: u64| format!("x, line {line}: found an empty line; expected a row on each line but the last");
    assert_eq!(csv("a,b\n1,2\n\n3,4\n"), empty(3));
    assert_eq!(csv("a\n1\n\r\n3\n"), empty(3));
    let apart = format!("a\n{}\n\n\n1\n", "1\n".repeat(BATCH_ROWS - 1));
    assert_eq!(csv(&apart), empty(BATCH_ROWS as u64 + 1));
    let blank_end = format!("a\n{}\n\n\n", "1\n".repeat(BATCH_ROWS - 1));
    assert_eq!(read(Format::Csv, blank_end, None).expect("read"), BATCH_ROWS - 1);
}

#[test]
fn lines_of_ndjson() {
    let object = "expected one JSON object, {\"name\": number or null, …}";
    assert_eq!(ndjson(""), format!("x: found no line; {object}"));
    assert_eq!(ndjson("{}\n"), format!("x, line 1: found no key; {object}"));
    assert_eq!(ndjson("[1,2]\n"), format!("x, line 1: found \"[1,2]\"; {object}"));
    assert_eq!(ndjson("{\"a\":1}\n{\"a\":1\n"), format!("x, line 2: found the end of the line; {object}"));
    assert_eq!(ndjson("{\"a\":1}\n{\"a\":1} 2\n"), format!("x, line 2: found \" 2\"; {object}"));
    assert_eq!(ndjson("{\"a\":1}\n{\"a\":1,}\n"), format!("x, line 2: found \"}}\"; {object}"));
    assert_eq!(ndjson("{\"a\":1}\n{a:1}\n"), format!("x, line 2: found \"a:1}}\"; {object}"));
    assert_eq!(
        ndjson("{\"a\":1}\n\n{\"a\":2}\n"),
        "x, line 2: found an empty line; expected a row on each line but the last"
    );
    let key = |line: u64, key: &str, found: &str| {
        format!("x, line {line}, key {key}: found {found}; expected a finite number or null")
    };
    assert_eq!(
        ndjson("{\"a\":1,\"b\":2}\n{\"a\":1,\"b\":\"two, too\"}\n"),
        key(2, "b", "\"\\\"two, too\\\"\"")
    );
    assert_eq!(ndjson("{\"a\":1}\n{\"a\":[1]}\n"), key(2, "a", "\"[1]\""));
    assert_eq!(ndjson("{\"a\":1}\n{\"a\":true}\n"), key(2, "a", "\"true\""));
    assert_eq!(ndjson("{\"a\":1}\n{\"a\":-Infinity}\n"), key(2, "a", "\"-Infinity\""));
    assert_eq!(ndjson("{\"a\":1}\n{\"a\":1e999}\n"), key(2, "a", "\"1e999\""));
    assert_eq!(ndjson("{\"a\":1}\n{\"a\":1.5nt}\n"), key(2, "a", "\"1.5nt\""));
    assert_eq!(
        ndjson("{\"a\":1}\n{\"a\":1,\"b\":2}\n"),
        "x, line 2, key b: found a key that the first line has not; expected the same keys on each line"
    );
    assert_eq!(
        ndjson("{\"a\":1}\n{\"a\":1,\"a\":2}\n"),
        "x, line 2, key a: found the key twice; expected it once on a line"
    );
    assert_eq!(
        ndjson("{\"a\":1,\"a\":2}\n"),
        "x, line 1: found column a twice, as columns 1 and 2; expected a name of its own for each column"
    );
    assert_eq!(
        message(Format::NdJson, b"{\"a\":1}\n{\"a\":\xff}\n", None),
        "x, line 2: found byte 6 of the line, which is not UTF-8; expected text in UTF-8"
    );
}

#[test]
fn absurd_sizes() {
    let mut names = String::new();
    for column in 0..=COLUMN_LIMIT {
        write!(names, "c{column},").expect("a name");
    }
    assert_eq!(
        csv(&format!("{names}z\n")),
        "x, line 1: found 10002 columns; expected at most 10000; are rows and columns exchanged?"
    );
    let long = |line: u64| {
        format!(
            "x, line {line}: found a line of more than {LINE_LIMIT} bytes; expected a row of numbers on each line"
        )
    };
    assert_eq!(csv(&"a".repeat(LINE_LIMIT + 1)), long(1));
    let digits = "0".repeat(LINE_LIMIT + 1);
    assert_eq!(csv(&format!("a\n1\n{digits}\n2\n")), long(3));
    assert_eq!(ndjson(&format!("{{\"a\":1}}\n{digits}\n")), long(2));
    assert_eq!(
        read(Format::Csv, format!("a\n1\n{}\n2\n", &digits[1..]), None).expect("just short enough"),
        3
    );
    // Of long lines a batch has fewer.
    let row = format!("1,{}\n", "0".repeat(1 << 22));
    let reader = Reader::from_read(Cursor::new(format!("a,b\n{}", row.repeat(20))), Format::Csv, "x", None);
    let rows: Vec<_> = reader.expect("opened").map(|batch| batch.expect("read").rows()).collect();
    assert_eq!((rows.iter().sum::<usize>(), rows.len()), (20, 3));
}

#[test]
fn parquet() {
    let open = |name: &str, wanted: &[&str]| -> Result<Vec<_>, Error> {
        Reader::open(&testkit::fixture("tables").join(name), Some(wanted))?.collect()
    };
    let message = |name: &str, column: &str| {
        let text = open(name, &[column]).expect_err(column).to_string();
        text.split_once(".parquet, ").expect("the file's name").1.to_string()
    };
    let expected = "expected a column of DOUBLE, FLOAT, INT64 or INT32 that are plain numbers; convert it, or name the \
                    columns wanted";
    let other = "other_kinds.parquet";
    assert_eq!(message(other, "name"), format!("column name: found values of type BYTE_ARRAY; {expected}"));
    assert_eq!(message(other, "good"), format!("column good: found values of type BOOLEAN; {expected}"));
    assert_eq!(
        message("int96.parquet", "time"),
        format!("column time: found values of type INT96; {expected}")
    );
    // 2024-02-29 and a second later.
    assert_eq!(open(other, &["time"]).expect("moments")[0].columns, [[1_709_164_800.0, 1_709_164_801.0]]);
    assert_eq!(
        message(other, "steps.list.element"),
        format!("column steps.list.element: found a column within another; {expected}")
    );
    let finite = "expected a finite number that double precision holds exactly, or null";
    let found = "found an infinite number, or an integer beyond ±2⁵³";
    assert_eq!(message(other, "beyond"), format!("row 1, column beyond: {found}; {finite}"));
    assert_eq!(message(other, "infinite"), format!("row 2, column infinite: {found}; {finite}"));
    assert_eq!(open(other, &["x_nt"]).expect("numbers")[0].columns, [[1.0, 2.0]]);
    let absent = open(other, &["y_nt"]).expect_err("absent").to_string();
    assert!(absent.ends_with(
        "found no column y_nt; expected it among those there are: x_nt, name, time, steps.list.element, beyond, infinite, \
         good"
    ));
    let stream = Reader::from_read(Cursor::new(Vec::new()), Format::Parquet, "standard input", None);
    assert_eq!(
        stream.err().expect("a stream").to_string(),
        "standard input: Parquet is read from its end and so cannot come from a stream; give a file, or pipe CSV or NDJSON"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("words.parquet");
    for bytes in [&b""[..], b"words", b"PAR1 and nothing else PAR1"] {
        fs::write(&path, bytes).expect("written");
        let error = Reader::open(&path, None).err().expect("no Parquet").to_string();
        assert!(error.contains("words.parquet: found what cannot be decoded ("), "{error}");
        assert!(error.ends_with("; expected a whole Parquet file"), "{error}");
    }
}

#[test]
fn requests() {
    let unknown = Reader::open(Path::new("a/table.txt"), None).err().expect("unknown").to_string();
    assert_eq!(
        unknown,
        "a/table.txt: the file's name does not say its format; expected .csv, .ndjson, .jsonl or .parquet"
    );
    let absent = Reader::open(Path::new("absent/table.csv"), None).err().expect("absent").to_string();
    assert!(absent.starts_with("absent/table.csv: cannot be read: "), "{absent}");
    let names = |columns: &[&str]| {
        Writer::to_write(Vec::new(), Format::Csv, "x", columns).err().expect("refused").to_string()
    };
    let end = "is not written; expected columns with names of their own";
    assert_eq!(names(&[]), format!("x: a table without columns {end}"));
    assert_eq!(names(&["a", "a"]), format!("x: a table with two columns a {end}"));
    assert_eq!(names(&["a", "b\nc"]), format!("x: a table with the column name \"b\\nc\" {end}"));
    assert_eq!(names(&["1.5"]), format!("x: a table with the column name \"1.5\" {end}"));
    assert_eq!(
        names(&vec!["a"; COLUMN_LIMIT + 1]),
        format!("x: a table of 10001 columns, more than 10000, {end}")
    );
    let mut writer = Writer::to_write(Vec::new(), Format::NdJson, "x", &["a", "b"]).expect("begun");
    writer.write(&[[1.0], [2.0]]).expect("written");
    let unequal = writer.write(&[vec![1.0], vec![]]).expect_err("unequal").to_string();
    assert_eq!(unequal, "x: columns of [1, 0] rows cannot be written; expected 2 columns of the same length");
    assert!(writer.write(&[[1.0]]).is_err());
    assert_eq!(
        writer.write(&[[1.0, 1.0], [2.0, f64::INFINITY]]).expect_err("infinite").to_string(),
        "x: row 3 of column 2 is infinite and is not written; expected finite numbers, NaN where one is missing"
    );
}
