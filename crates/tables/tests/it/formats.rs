//! What is written is read back bit by bit, in the same batches, in every format and on any number of
//! threads.

use proptest::prelude::*;
use std::fs;
use std::io::{self, Read};
use std::path::Path;
use tables::{BATCH_ROWS, Batch, Error, Format, Reader, Writer};

const FORMATS: [&str; 3] = ["csv", "ndjson", "parquet"];

fn write(path: &Path, names: &[String], parts: &[Vec<Vec<f64>>]) {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut writer = Writer::create(path, &names).expect("created");
    for part in parts {
        writer.write(part).expect("written");
    }
    writer.finish().expect("finished");
}

fn read(path: &Path, threads: usize) -> Vec<Batch> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    pool.install(|| Reader::open(path, None).expect("opened").collect::<Result<_, _>>().expect("read"))
}

/// Bits, one pattern for every NaN.
fn bits(column: &[f64]) -> Vec<u64> {
    column.iter().map(|value| if value.is_nan() { f64::NAN.to_bits() } else { value.to_bits() }).collect()
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |value| !value.is_infinite()),
        4 => -1e6..1e6_f64,
        1 => Just(f64::NAN),
        1 => prop_oneof![Just(0.0), Just(-0.0), Just(f64::MAX), Just(f64::MIN_POSITIVE), Just(5e-324)],
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn tables_come_back(
        (names, rows) in prop::collection::btree_set("[a-z][a-z0-9_ ,\"\\\\éµ]{0,8}[a-z]", 1..6).prop_flat_map(|names| {
            let row = prop::collection::vec(number(), names.len());
            (Just(names.into_iter().filter(|name| name.parse::<f64>().is_err()).collect::<Vec<_>>()),
             prop::collection::vec(row, 1..40))
        }),
        cut in 0..40_usize,
    ) {
        prop_assume!(rows[0].len() == names.len());
        let columns: Vec<Vec<f64>> =
            (0..names.len()).map(|column| rows.iter().map(|row| row[column]).collect()).collect();
        let cut = cut.min(rows.len());
        let parts = [
            columns.iter().map(|column| column[..cut].to_vec()).collect(),
            columns.iter().map(|column| column[cut..].to_vec()).collect(),
        ];
        let folder = tempfile::tempdir().expect("a folder");
        for format in FORMATS {
            let path = folder.path().join(format!("table.{format}"));
            write(&path, &names, &parts);
            let reader = Reader::open(&path, None).expect("opened");
            prop_assert_eq!(reader.columns(), &names[..]);
            let batches: Vec<_> = reader.collect::<Result<_, _>>().expect("read");
            prop_assert_eq!(batches.len(), 1);
            for (column, back) in columns.iter().zip(&batches[0].columns) {
                prop_assert_eq!(bits(column), bits(back), "{}", format);
            }
        }
    }
}

#[test]
fn batches_depend_neither_on_threads_nor_on_the_format() {
    let rows = 5 * BATCH_ROWS + 1234;
    let value = |row: usize, column: usize| {
        if row % 1000 == column { f64::NAN } else { (row * column) as f64 / 7.0 }
    };
    let column = |column: usize| (0..rows).map(|row| value(row, column)).collect();
    let columns: Vec<Vec<f64>> = (1..=3).map(column).collect();
    let names = ["a", "b", "c"].map(String::from);
    let folder = tempfile::tempdir().expect("a folder");
    for format in FORMATS {
        let path = folder.path().join(format!("table.{format}"));
        write(&path, &names, std::slice::from_ref(&columns));
        for threads in [1, 2, 5] {
            let batches = read(&path, threads);
            assert_eq!(batches.len(), 6);
            for (number, batch) in batches.iter().enumerate() {
                let start = number * BATCH_ROWS;
                assert_eq!(batch.first_row, start as u64);
                assert_eq!(batch.rows(), BATCH_ROWS.min(rows - start));
                for (column, part) in columns.iter().zip(&batch.columns) {
                    let written = &column[start..start + part.len()];
                    assert_eq!(bits(written), bits(part), "{format}, {threads} threads");
                }
            }
        }
    }
}

#[test]
fn written_bytes_depend_neither_on_threads_nor_on_the_cuts() {
    let column: Vec<f64> = (0..300_000).map(|row| f64::from(row).sqrt()).collect();
    let folder = tempfile::tempdir().expect("a folder");
    for format in FORMATS {
        let text = |threads: usize, part: usize| {
            let path = folder.path().join(format!("{threads}.{format}"));
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let parts: Vec<_> = column.chunks(part).map(|part| vec![part.to_vec()]).collect();
            pool.install(|| write(&path, &["a".into()], &parts));
            fs::read(&path).expect("written")
        };
        assert!(text(1, column.len()) == text(2, 70_001), "{format}");
    }
}

#[test]
fn a_caller_that_holds_every_thread_does_not_wait_for_ever() {
    use rayon::prelude::*;
    let folder = tempfile::tempdir().expect("a folder");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    for format in FORMATS {
        let path = folder.path().join(format!("table.{format}"));
        write(&path, &["a".into()], &[vec![vec![1.0; 1000]]]);
        let rows = |_| -> usize {
            let reader = Reader::open(&path, None).expect("opened");
            reader.map(|batch| batch.expect("read").rows()).sum()
        };
        assert_eq!(pool.install(|| (0..8_usize).into_par_iter().map(rows).sum::<usize>()), 8000);
    }
}

#[test]
fn lines_end_and_begin_as_programs_write_them() {
    let cases: [(&str, &str); 6] = [
        ("csv", "\u{feff}# made by hand\r\n# in two lines\n a ,\"b\" \r\n1,2\n3,\r\n\"5\" , +6.\n"),
        ("csv", "a,b\n1,2\n3,NaN\n5,6"),
        ("csv", "a,b\n1,2\r\n3,null\r\n5,6\r"),
        ("csv", "b,note,a\n2,\"one, and \"\"two\"\"\",1\n,,3\n6,\"\",5\n\n\r\n\n"),
        ("ndjson", "\u{feff}{\"a\":1,\"b\":2}\r\n{ \"b\" : null , \"a\" : 3.0 }\n{\"a\":5e0,\"b\":6}\n\n\n"),
        (
            "ndjson",
            "{\"a\":1,\"b\":2,\"t\":\"x\"}\n{\"t\":[1,{\"u\":2}],\"a\":3,\"b\":NaN}\n{\"\\u0062\":6,\"t\":Infinity,\"a\":5}",
        ),
    ];
    for (format, text) in cases {
        let format = Format::of(Path::new(&format!("x.{format}"))).expect("a format");
        let reader =
            Reader::from_read(text.as_bytes(), format, "standard input", Some(&["a", "b"])).expect(text);
        let batches: Vec<_> = reader.collect::<Result<_, _>>().expect(text);
        assert_eq!(batches.len(), 1, "{text}");
        assert_eq!(batches[0].columns[0], [1.0, 3.0, 5.0], "{text}");
        assert_eq!(bits(&batches[0].columns[1]), bits(&[2.0, f64::NAN, 6.0]), "{text}");
    }
}

#[test]
fn a_table_without_rows_has_columns() {
    let folder = tempfile::tempdir().expect("a folder");
    for format in ["csv", "parquet"] {
        let path = folder.path().join(format!("table.{format}"));
        write(&path, &["a".into(), "b".into()], &[]);
        let mut reader = Reader::open(&path, Some(&["b"])).expect("opened");
        assert_eq!(reader.columns(), ["b"]);
        assert!(reader.next().is_none());
    }
}

/// Gives a byte at a time.
struct Slow<R>(R);

impl<R: Read> Read for Slow<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let most = buffer.len().min(1);
        self.0.read(&mut buffer[..most])
    }
}

#[test]
fn a_slow_stream_gives_the_same_batches() {
    let text: String = (0..BATCH_ROWS + 10).map(|row| format!("{row}\n")).collect();
    let text = format!("a\n{text}");
    let reader = Reader::from_read(Slow(io::Cursor::new(text)), Format::Csv, "a pipe", None).expect("opened");
    let batches: Vec<_> = reader.collect::<Result<_, _>>().expect("read");
    assert_eq!(batches.iter().map(Batch::rows).collect::<Vec<_>>(), [BATCH_ROWS, 10]);
    assert_eq!(batches[1].columns[0][9], (BATCH_ROWS + 9) as f64);
}

#[test]
fn nothing_half_written_is_left() {
    let folder = tempfile::tempdir().expect("a folder");
    let entries = || fs::read_dir(folder.path()).expect("readable").count();
    for format in FORMATS {
        let path = folder.path().join(format!("table.{format}"));
        let mut writer = Writer::create(&path, &["a"]).expect("created");
        writer.write(&[vec![1.0]]).expect("written");
        assert!(!path.exists());
        drop(writer);
        assert_eq!(entries(), 0);
        fs::write(&path, "old").expect("written");
        write(&path, &["a".into()], &[vec![vec![2.0]]]);
        assert_eq!(read(&path, 1)[0].columns, [[2.0]]);
        assert_eq!(entries(), 1);
        fs::remove_file(&path).expect("removed");
    }
    let error = Writer::create(&folder.path().join("absent/table.csv"), &["a"]).err().expect("no folder");
    assert!(error.to_string().contains("absent/table.csv: cannot be written: "), "{error}");
}

#[test]
fn damaged_parquet_reaches_the_caller_as_an_error_or_as_values() {
    let bytes = fs::read(testkit::fixture("tables/snappy.parquet")).expect("the fixture");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("damaged.parquet");
    let mut refused = 0;
    for place in (0..bytes.len()).step_by(7) {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x55;
        fs::write(&path, &damaged).expect("written");
        let read: Result<Vec<_>, Error> = Reader::open(&path, None).and_then(Iterator::collect);
        refused += usize::from(read.is_err());
    }
    assert!(refused > 100, "{refused}");
}
