//! Every file of `fixtures/bad/ingest` brings its message, its exit code, nothing on standard output and
//! nothing in the folder.

use std::fs;
use std::path::Path;

const INGEST: &str = env!("CARGO_BIN_EXE_ingest");

/// A copy of the fixtures, with the files that are too large to be kept.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for entry in fs::read_dir(testkit::fixture("bad/ingest")).expect("fixtures") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            continue;
        }
        fs::copy(&path, folder.path().join(path.file_name().expect("a name"))).expect("copied");
    }
    let names: Vec<String> = (1..=1_000_000).map(|column| format!("c{column}_nT")).collect();
    let row = vec!["1.5"; names.len()].join(",");
    let million = format!("{}\n{row}\n{row}\n", names.join(","));
    fs::write(folder.path().join("million-columns.csv"), million).expect("written");
    let iaf = fs::read(testkit::fixture("ingest/iaf.bin")).expect("a fixture");
    let word = |day: usize, index: usize, content: [u8; 4]| {
        let mut bytes = iaf.clone();
        let at = day * 23_552 + 4 * (index - 1);
        bytes[at..at + 4].copy_from_slice(&content);
        bytes
    };
    for (name, bytes) in [
        ("truncated", iaf[..30_000].to_vec()),
        ("header-only", iaf[..64].to_vec()),
        ("big-endian", word(0, 2, 2_024_070_i32.to_be_bytes())),
        ("day", word(1, 2, 2_023_366_i32.to_le_bytes())),
        ("place", word(1, 3, i32::MIN.to_le_bytes())),
        ("orientation", word(0, 6, *b"XYZQ")),
        ("station", word(1, 1, *b" BOU")),
        ("value", word(1, 1600, i32::MIN.to_le_bytes())),
    ] {
        fs::write(folder.path().join(format!("{name}.bin")), bytes).expect("written");
    }
    folder
}

fn entries(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).expect("readable");
    let mut names: Vec<String> =
        names.map(|entry| entry.expect("an entry").file_name().into_string().expect("UTF-8")).collect();
    names.sort();
    names
}

#[test]
fn each_fault_has_its_message() {
    let folder = folder();
    let before = entries(folder.path());
    let files = "truncated.min truncated-number.min truncated-header.min header-only.min components-lie.min \
                 interval-lies.min day-of-year-lies.min titles-unknown.min joined-end-to-end.min no-number.min \
                 time-of-day.min nothing-observed.min empty.csv blank.csv header-only.csv truncated.csv utf-16.csv \
                 utf-16-without-mark.csv duplicate-times.csv clock-set-back.csv unknown-unit.csv no-unit.csv \
                 more-values.csv time.csv day-or-month.csv spreadsheet.csv words-only.csv document.json list.json \
                 truncated.ndjson truncated.parquet time-missing.parquet million-columns.csv nowhere.csv \
                 nameless.csv thousands-doubtful.csv day-or-month-am.csv truncated.cdf short.pcdcp short-usgs.json \
                 truncated.bin header-only.bin big-endian.bin day.bin place.bin orientation.bin station.bin \
                 value.bin truncated.imf row.imf day.imf truncated.blv no-star.blv day.blv twice.blv yearmean.flx \
                 hapi-no-unit.csv hapi-size.csv absolute-gon.txt absolute-unit.txt absolute-position.txt \
                 absolute-mark.txt absolute-mark-name.txt absolute-misread.txt absolute-row.txt absolute.json \
                 absolute.abs";
    let files = files.split(' ').map(|file| (file.replace('.', "-"), format!("-o out.json {file}")));
    let of_words = "unit-open unit-unknown volts column-absent column-twice column-zero scale-huge key-unknown zone \
                    format newer";
    let of_words = of_words.split(' ').map(|map| (map, "word.csv"));
    let of_bits = ["thousands", "bits", "valid", "no-day"].map(|map| (map, "bits.csv"));
    let maps = of_words.chain(of_bits).chain([("column-by-number", "text-for-number.ndjson")]);
    let maps = maps.map(|(map, file)| (format!("map-{map}"), format!("--map map-{map}.json {file}")));
    let asked = [
        ("no-file", ""),
        ("decimal-comma", "--map map-semicolon.json decimal-comma.csv"),
        ("word", "--map map.json word.csv"),
        ("quote-open", "--map map.json quote-open.csv"),
        ("latin-1-in-a-row", "--map map.json latin-1-in-a-row.csv"),
        ("text-for-number", "--map map.json text-for-number.ndjson"),
        ("wrong-separator", "--map map-semicolon.json word.csv"),
        ("million-columns-mapped", "--map map.json million-columns.csv"),
        ("summer-time-ends", "--map map-vienna.json summer-time-ends.csv"),
        ("date-not-in-the-name", "--map map-no-date.json word.csv"),
        ("bits", "--map map-bits-16.json bits.csv"),
        ("seconds-of-day", "--map map-seconds-of-day.json seconds-of-day.csv"),
        ("thousands", "--map map-seconds-of-day.json thousands.csv"),
        ("cdf-variable-absent", "--map map.json mission.cdf"),
        ("map-for-iaf", "--map map.json value.bin"),
        ("guess-iaf", "guess value.bin"),
        ("map-for-iaga", "--map map.json whole.min"),
        ("map-is-none", "--map document.json word.csv"),
        ("two-stations", "whole.min other-station.min"),
        ("files-disagree", "whole.min disagrees.min"),
        ("guess-iaga", "guess whole.min"),
        ("guess-absolute", "guess absolute-row.txt"),
        ("guess-million-columns", "guess million-columns.csv"),
        ("table-leaves-the-folder", "--beside=../secret.parquet -o out.json whole.min"),
        ("table-of-unknown-kind", "--beside=table.xlsx -o out.json whole.min"),
    ];
    let asked = asked.map(|(name, words)| (name.to_string(), words.to_string()));
    let mut wrong = Vec::new();
    for (name, arguments) in files.chain(maps).chain(asked) {
        let arguments: Vec<&str> = arguments.split_whitespace().collect();
        let run = testkit::run_in(INGEST, folder.path(), &arguments);
        let (said, written) = (run.message(), run.stdout);
        let expected = testkit::fixture(&format!("bad/ingest/messages/{name}.txt"));
        if testkit::bless() {
            fs::write(&expected, &said).expect("written");
        }
        let expected = fs::read_to_string(&expected).unwrap_or_default();
        if said != expected || !written.is_empty() || said.starts_with("exit code 0") {
            wrong.push(format!("{name}:\n{said}{written}where this is expected:\n{expected}"));
        }
        assert_eq!(entries(folder.path()), before, "{name} left something behind");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_is_asked_for_gets_past_a_fault() {
    let folder = folder();
    let ok = |arguments: &[&str]| {
        let run = testkit::run_in(INGEST, folder.path(), arguments);
        assert_eq!(run.code, 0, "{arguments:?}: {}", run.stderr);
        (run.stderr, serde_json::from_str::<serde_json::Value>(&run.stdout).expect("a document"))
    };
    let (said, document) = ok(&["--trust-rows", "components-lie.min"]);
    assert!(said.contains("the header says XYZF, the titles say HDZF; the titles are used"), "{said}");
    assert_eq!(document["recordings"][0]["source"]["components"], "HDZF");
    let (said, _) = ok(&["--trust-rows", "interval-lies.min"]);
    assert!(said.contains("the rows are 60 s apart; the rows are used"), "{said}");
    ok(&["--trust-rows", "day-of-year-lies.min"]);
    let (said, document) = ok(&["--keep", "last", "whole.min", "disagrees.min"]);
    assert!(said.contains("1 row in which files disagree"), "{said}");
    assert_eq!(document["recordings"][0]["columns"]["sensor_x_nt"][5], 1.0);
    ok(&["--sort", "--keep", "first", "clock-set-back.csv"]);
    ok(&["--keep", "first", "duplicate-times.csv"]);
}
