//! Each fault has its message: where, what was found, what was expected.

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

/// Texts, with where each fault is, and what is found there; `expected` ends the message.
fn each(format: Format, expected: &str, cases: &[(&str, &str, &str)]) {
    for (text, place, found) in cases {
        assert_eq!(message(format, *text, None), format!("x{place}: found {found}; expected {expected}"));
    }
}

#[test]
fn headers() {
    each(
        Format::Csv,
        "a line of column names, cut at commas",
        &[
            ("", "", "no header"),
            ("# only words\n", "", "no header"),
            ("\na\n", ", line 1", "an empty line"),
            ("# words\n0.5,1\n", ", line 2", "the number 0.5"),
            ("a,\"b\n1,2\n", ", line 1", "a quote that is not closed"),
        ],
    );
    let twice = [("a,b,a\n", ", line 1", "column a twice, as columns 1 and 3")];
    each(Format::Csv, "a name of its own for each column", &twice);
    let nameless = [(",b\n", ", line 1", "no name for column 1")];
    each(Format::Csv, "a name for each (pandas: index=False)", &nameless);
    for (format, text, wanted, byte) in [
        (Format::Csv, &b"a\xff\n1\n"[..], None, "line 1: found byte 2"),
        (Format::Csv, b"a,b\n1,2\n1,\xc3\x28\n", Some(&["a"][..]), "line 3: found byte 3"),
        (Format::NdJson, b"{\"a\":1}\n{\"a\":\xff}\n", None, "line 2: found byte 6"),
    ] {
        let expected = format!("x, {byte} of the line, which is not UTF-8; expected text in UTF-8");
        assert_eq!(message(format, text, wanted), expected);
    }
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
    let late = format!("a,b_nt\n{}1,2\n1,z\n", "1,2\n".repeat(2 * BATCH_ROWS));
    let late_place = format!(", line {}, column 2 (b_nt)", 2 * BATCH_ROWS + 3);
    each(
        Format::Csv,
        "a finite number, or nothing where one is missing",
        &[
            ("a,b_nt\n1,2\n3,four\n", ", line 3, column 2 (b_nt)", "\"four\""),
            ("a,b_nt\n1,2\n\"3x\",4\n", ", line 3, column 1 (a)", "\"\\\"3x\\\"\""),
            ("a,b_nt\n1,inf\n", ", line 2, column 2 (b_nt)", "\"inf\""),
            ("a,b_nt\n-Infinity,1\n", ", line 2, column 1 (a)", "\"-Infinity\""),
            ("a,b_nt\n1,1e999\r\n", ", line 2, column 2 (b_nt)", "\"1e999\""),
            ("a,b_nt\n1,1.0 2.0\n", ", line 2, column 2 (b_nt)", "\"1.0 2.0\""),
            ("a,b_nt\n1;2,3\n", ", line 2, column 1 (a)", "\"1;2\""),
            (&late, &late_place, "\"z\""),
        ],
    );
    let found = "\"\\\"2\", a quote that is not closed on its line";
    each(Format::Csv, "a closing quote", &[("a,b_nt\n1,\"2\n3,4\n", ", line 2, column 2 (b_nt)", found)]);
}

#[test]
fn rows_of_csv() {
    let expected = "2, one for each name in the header";
    each(
        Format::Csv,
        expected,
        &[
            ("a,b\n1,2\n3\n", ", line 3", "1 value"),
            ("a,b\n1,2,3\n", ", line 2", "3 values"),
            ("a,b\n1,2\n3,4\n5", ", line 4", "1 value"),
            ("a,b\n1,2,\r\n", ", line 2", "3 values"),
        ],
    );
    let of_one = message(Format::Csv, "a,b\n1,2\n3,4,\"5,6\"\n", Some(&["a"]));
    assert_eq!(of_one, format!("x, line 3: found 3 values; expected {expected}"));
    let apart = format!("a\n{}\n\n\n1\n", "1\n".repeat(BATCH_ROWS - 1));
    each(
        Format::Csv,
        "a row on each line but the last",
        &[
            ("a,b\n1,2\n\n3,4\n", ", line 3", "an empty line"),
            ("a\n1\n\r\n3\n", ", line 3", "an empty line"),
            (&apart, &format!(", line {}", BATCH_ROWS + 1), "an empty line"),
        ],
    );
    let blank_end = format!("a\n{}\n\n\n", "1\n".repeat(BATCH_ROWS - 1));
    assert_eq!(read(Format::Csv, blank_end, None).expect("read"), BATCH_ROWS - 1);
}

#[test]
fn lines_of_ndjson() {
    each(
        Format::NdJson,
        "one JSON object, {\"name\": number or null, …}",
        &[
            ("", "", "no line"),
            ("{}\n", ", line 1", "no key"),
            ("[1,2]\n", ", line 1", "\"[1,2]\""),
            ("{\"a\":1}\n{\"a\":1\n", ", line 2", "the end of the line"),
            ("{\"a\":1}\n{\"a\":1} 2\n", ", line 2", "\" 2\""),
            ("{\"a\":1}\n{\"a\":1,}\n", ", line 2", "\"}\""),
            ("{\"a\":1}\n{a:1}\n", ", line 2", "\"a:1}\""),
        ],
    );
    each(
        Format::NdJson,
        "a finite number or null",
        &[
            ("{\"a\":1,\"b\":2}\n{\"a\":1,\"b\":\"2, 3\"}\n", ", line 2, key b", "\"\\\"2, 3\\\"\""),
            ("{\"a\":1}\n{\"a\":[1]}\n", ", line 2, key a", "\"[1]\""),
            ("{\"a\":1}\n{\"a\":true}\n", ", line 2, key a", "\"true\""),
            ("{\"a\":1}\n{\"a\":-Infinity}\n", ", line 2, key a", "\"-Infinity\""),
            ("{\"a\":1}\n{\"a\":1e999}\n", ", line 2, key a", "\"1e999\""),
            ("{\"a\":1}\n{\"a\":1.5nt}\n", ", line 2, key a", "\"1.5nt\""),
        ],
    );
    let own = "a name of its own for each column";
    for (text, place, found, expected) in [
        ("{\"a\":1}\n\n{\"a\":2}\n", ", line 2", "an empty line", "a row on each line but the last"),
        ("{\"a\":1}\n{\"a\":1,\"a\":2}\n", ", line 2, key a", "the key twice", "it once on a line"),
        ("{\"a\":1,\"a\":2}\n", ", line 1", "column a twice, as columns 1 and 2", own),
    ] {
        each(Format::NdJson, expected, &[(text, place, found)]);
    }
    let other = ("{\"a\":1}\n{\"a\":1,\"b\":2}\n", ", line 2, key b", "a key that the first line has not");
    each(Format::NdJson, "the same keys on each line", &[other]);
}

#[test]
fn absurd_sizes() {
    let names: String = (0..=COLUMN_LIMIT).map(|column| format!("c{column},")).collect();
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
    assert_eq!(message(Format::NdJson, format!("{{\"a\":1}}\n{digits}\n"), None), long(2));
    let short_enough = format!("a\n1\n{}\n2\n", &digits[1..]);
    assert_eq!(read(Format::Csv, short_enough, None).expect("read"), 3);
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
    for (file, column, found) in [
        (other, "name", "values of type BYTE_ARRAY"),
        (other, "good", "values of type BOOLEAN"),
        ("int96.parquet", "time", "values of type INT96"),
        (other, "steps.list.element", "a column within another"),
    ] {
        assert_eq!(message(file, column), format!("column {column}: found {found}; {expected}"));
    }
    // 2024-02-29 and a second later.
    assert_eq!(open(other, &["time"]).expect("moments")[0].columns, [[1_709_164_800.0, 1_709_164_801.0]]);
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
    for (columns, fault) in [
        (&[][..], "without columns"),
        (&["a", "a"], "with two columns a"),
        (&["a", "b\nc"], "with the column name \"b\\nc\""),
        (&["1.5"], "with the column name \"1.5\""),
        (&["a"; COLUMN_LIMIT + 1], "of 10001 columns, more than 10000,"),
    ] {
        assert_eq!(names(columns), format!("x: a table {fault} {end}"));
    }
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
