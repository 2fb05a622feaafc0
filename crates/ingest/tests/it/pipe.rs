//! Ways in and out: documents that exist, standard input, files in any order, tables beside, files as they
//! really are.

use serde_json::Value;
use std::fs;
use std::process::Command;
use testkit::{run, run_in};

const INGEST: &str = env!("CARGO_BIN_EXE_ingest");

fn fixture(name: &str) -> String {
    testkit::fixture("ingest").join(name).to_str().expect("UTF-8").to_string()
}

fn document(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// What is said of a text file, and the columns that are written; the code must be 0.
fn ingested(bytes: &[u8]) -> (String, Value) {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("a.csv"), bytes).expect("written");
    let run = run_in(INGEST, folder.path(), &["a.csv"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    (run.stderr, document(&run.stdout)["recordings"][0]["columns"].clone())
}

#[test]
fn a_recording_is_added_and_the_rest_kept() {
    let first = r#"{"fluxcal": 1, "weather": "dry", "recordings": [{"id": "flx-2024-03-10", "procedure": "free_run"}]}"#;
    let taken = run(INGEST, &["--add", "-", &fixture("lemi.sec")], first);
    assert_eq!(taken.code, 0, "{}", taken.stderr);
    let found = document(&taken.stdout);
    let recordings = found["recordings"].as_array().map(Vec::len);
    assert_eq!((found["weather"].as_str(), recordings), (Some("dry"), Some(2)));
    assert_eq!(found["history"][0]["stage"], "ingest");
    let twice = run(INGEST, &["--add", "-", &fixture("flx20240310a.min")], first);
    assert_eq!((twice.code, twice.stdout.as_str()), (2, ""));
    assert!(twice.stderr.contains("--id"), "{}", twice.stderr);
    let named = run(INGEST, &["-q", "--id", "b", "--add", "-", &fixture("flx20240310a.min")], first);
    assert_eq!(named.stderr, "");
}

#[test]
fn the_order_of_files_and_the_threads_change_nothing() {
    let (a, b) = (fixture("flx20240310a.min"), fixture("flx20240310b.min"));
    let of = |files: [&str; 2], threads: &str| {
        let output =
            Command::new(INGEST).args(files).env("RAYON_NUM_THREADS", threads).output().expect("ingest");
        (output.stdout, output.stderr)
    };
    let first = of([&a, &b], "1");
    assert_eq!(first, of([&b, &a], "2"));
    let said = String::from_utf8_lossy(&first.1).into_owned();
    assert!(said.contains("65 rows of 60 s, 2024-03-10T00:00:00Z to 2024-03-10T01:09:00Z"), "{said}");
    assert!(said.contains("1 gap, 5 rows missing"), "{said}");
    assert!(said.contains("2 duplicate rows merged"), "{said}");
    let found = document(&String::from_utf8_lossy(&first.0));
    let source = &found["recordings"][0]["source"];
    assert_eq!((source["gaps"]["missing_rows"].as_u64(), source["merged_rows"].as_u64()), (Some(5), Some(2)));
    assert_eq!(source["gaps"]["longest"][0]["after_s"], 59.0 * 60.0);
}

#[test]
fn a_long_series_goes_beside_its_document() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows: String = (0..10_001).map(|row| format!("{row},{row}.5\n")).collect();
    fs::write(folder.path().join("long.csv"), format!("time_s,sensor_x_nt\n{rows}")).expect("written");
    fs::create_dir(folder.path().join("campaign")).expect("a folder");
    let of = |arguments: &[&str]| {
        let run = run_in(INGEST, folder.path(), arguments);
        assert_eq!(run.code, 0, "{arguments:?}: {}", run.stderr);
        run.stdout
    };
    assert_eq!(of(&["-o", "campaign/out.json", "long.csv"]), "");
    let found = document(&fs::read_to_string(folder.path().join("campaign/out.json")).expect("a document"));
    assert_eq!(found["recordings"][0]["table"], "long.parquet");
    assert_eq!(found["recordings"][0].get("columns"), None);
    let table = tables::beside(&folder.path().join("campaign"), "long.parquet").expect("a path");
    let rows: usize =
        tables::Reader::open(&table, None).expect("a table").map(|batch| batch.expect("rows").rows()).sum();
    assert_eq!(rows, 10_001);
    let beside = document(&of(&["--beside=readings.csv", "long.csv"]));
    assert_eq!(beside["recordings"][0]["table"], "readings.csv");
    let csv = fs::read_to_string(folder.path().join("readings.csv")).expect("in the present folder");
    assert!(csv.starts_with("time_s,sensor_x_nt\n0.0,0.5\n"), "{}", &csv[..40]);
    let inline = document(&of(&["--inline", "long.csv"]));
    assert_eq!(inline["recordings"][0]["columns"]["sensor_x_nt"].as_array().map(Vec::len), Some(10_001));
}

#[test]
fn a_table_that_cannot_be_written_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir_all(folder.path().join("t.parquet/within")).expect("a folder");
    let arguments = ["--beside=t.parquet", "-o", "out.json", &fixture("lemi.sec")];
    let run = run_in(INGEST, folder.path(), &arguments);
    assert_eq!((run.code, run.stdout.as_str()), (2, ""));
    let left = fs::read_dir(folder.path()).expect("readable");
    assert_eq!(left.map(|entry| entry.expect("an entry").file_name()).collect::<Vec<_>>(), ["t.parquet"]);
}

#[test]
fn line_ends_marks_and_old_encodings() {
    let text = "time;x (nT);T (°C)\n2024-06-10T10:00:00Z;1.5;20\n2024-06-10T10:00:01Z;2.5;21\n;;\n2024-06-10T10:00:02Z;;NaN\n";
    let (_, columns) = ingested(text.as_bytes());
    assert_eq!(columns["x_nt"], serde_json::json!([1.5, 2.5, null]));
    assert_eq!(columns["sensor_temperature_c"], serde_json::json!([20.0, 21.0, null]));
    let mut lines = text.lines();
    let mut mixed = String::from("\u{feff}");
    for end in ["\r\n", "\n", "\r", "\r\r\n", "\n"] {
        mixed += &format!("{}{end}", lines.next().unwrap_or_default());
    }
    assert_eq!(ingested(mixed.as_bytes()).1, columns);
    let latin: Vec<u8> =
        text.chars().map(|letter| u8::try_from(u32::from(letter)).expect("Latin-1")).collect();
    let (said, found) = ingested(&latin);
    assert_eq!(found, columns);
    assert!(said.contains("not in UTF-8 and was read as Latin-1"), "{said}");
    let (said, _) = ingested(text.trim_end().as_bytes());
    assert!(said.contains("the last line has no end"), "{said}");
}

#[test]
fn a_guess_is_saved_edited_and_used() {
    let folder = tempfile::tempdir().expect("a folder");
    let of = |arguments: &[&str]| run_in(INGEST, folder.path(), arguments);
    let map = folder.path().join("map.json");
    let logger = fixture("logger.csv");
    let guess = of(&["guess", &logger]);
    assert!(guess.stderr.contains("taken as UTC") && guess.stderr.contains("nothing is open"), "{guess:?}");
    let edited = guess.stdout.replace("\"zone\": \"UTC\"", "\"zone\": \"Europe/Vienna\"");
    fs::write(&map, edited).expect("written");
    let found = of(&["--map", "map.json", &logger]);
    assert_eq!((guess.code, found.code), (0, 0), "{found:?}");
    assert_eq!(document(&found.stdout)["recordings"][0]["start"], "2024-06-10T10:00:00Z");
    // A file that names no columns and states no units.
    let guess = of(&["guess", &fixture("counts.txt"), "-o", "map.json"]);
    assert_eq!((guess.code, guess.stdout.as_str()), (0, ""), "{guess:?}");
    assert!(guess.stderr.contains("the file names none"), "{guess:?}");
    let guessed = document(&fs::read_to_string(&map).expect("readable"));
    assert_eq!(
        (guessed["separator"].as_str(), guessed["time"]["format"].as_str()),
        (Some(" "), Some("unix_ms"))
    );
    let open = of(&[&fixture("counts.txt")]);
    assert_eq!((open.code, open.stdout.as_str()), (2, ""));
    assert!(open.stderr.contains("ingest guess"), "{open:?}");
}

#[test]
fn a_second_vector_is_asked_about_and_what_runs_beside_keeps_its_unit() {
    let folder = tempfile::tempdir().expect("a folder");
    let titles = "time,ref_x_nT,ref_y_nT,ref_z_nT,mag_x_nT,mag_y_nT,mag_z_nT,torquer_A,torquer_x_Am2,wheel_rpm,coil_mA";
    let row = |second: u32| {
        format!("2024-01-01T00:00:0{second}Z,20000,100,40000,20010,110,4010{second},0.1,0.2,3000,3\n")
    };
    let rows: String = (0..5).map(row).collect();
    fs::write(folder.path().join("a.csv"), format!("{titles}\n{rows}")).expect("written");
    let guess = run_in(INGEST, folder.path(), &["guess", "a.csv"]);
    assert!(
        guess
            .stderr
            .contains("to be settled: \"ref_x_nT\", \"ref_y_nT\", \"ref_z_nT\": taken as the reference")
    );
    let columns = document(&guess.stdout)["columns"].as_array().expect("columns").clone();
    let to: Vec<&str> = columns.iter().filter_map(|column| column["to"].as_str()).collect();
    let reference = ["reference_x_nt", "reference_y_nt", "reference_z_nt"];
    let sensor = ["sensor_x_nt", "sensor_y_nt", "sensor_z_nt"];
    assert_eq!(
        to,
        [&reference[..], &sensor, &["torquer_a", "torquer_x_am2", "wheel_rpm", "coil_a"]].concat()
    );
}

/// The field of a place goes where none was measured, and `--place` says what it needs.
#[test]
fn a_place_states_the_magnitude() {
    let file = fixture("field.csv");
    let folder = tempfile::tempdir().expect("a folder");
    let place = ["--place", "47.93,15.865,1087", "--date", "2022-08-10"];
    let run = run_in(INGEST, folder.path(), &[&[file.as_str()], &place[..]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let conditions = &document(&run.stdout)["recordings"][0]["conditions"];
    assert_eq!(conditions["magnitude_nt"]["std"], 138.0);
    assert_eq!(conditions["field_model"], "IGRF-14 at 47.93°, 15.865°, 1087 m in 2022.61");
    let late = run_in(INGEST, folder.path(), &[&file, "--place", "0,0,0", "--date", "2031-01-01"]);
    assert_eq!((late.code, late.stdout.as_str()), (2, ""));
    assert!(late.stderr.contains("IGRF-14 holds from 1900 to 2030"), "{}", late.stderr);
}

/// Parquet from a pipe, which has no end to begin at, is read like the file.
#[cfg(unix)]
#[test]
fn parquet_comes_through_a_pipe() {
    use std::process::Stdio;
    let file = fixture("field.parquet");
    let recordings = |output: std::process::Output| {
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{said}");
        document(&String::from_utf8(output.stdout).expect("UTF-8"))["recordings"][0]["columns"].clone()
    };
    let of_file = recordings(Command::new(INGEST).arg(&file).output().expect("ingest"));
    let mut cat = Command::new("cat").arg(&file).stdout(Stdio::piped()).spawn().expect("cat");
    let piped = Stdio::from(cat.stdout.take().expect("piped"));
    let of_pipe = recordings(Command::new(INGEST).arg("-").stdin(piped).output().expect("ingest"));
    cat.wait().expect("ended");
    assert_eq!(of_pipe, of_file);
    let folder = tempfile::tempdir().expect("a folder");
    let fifo = folder.path().join("fifo");
    assert!(Command::new("mkfifo").arg(&fifo).status().expect("mkfifo").success());
    let copy = format!("cat '{file}' > '{}'", fifo.display());
    let mut cat = Command::new("sh").args(["-c", &copy]).spawn().expect("sh");
    let of_fifo = recordings(Command::new(INGEST).arg(&fifo).output().expect("ingest"));
    cat.wait().expect("ended");
    assert_eq!(of_fifo, of_file);
}

#[test]
fn circles_of_a_theodolite_are_known_by_their_names() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = "2025-03-14T09:00:00Z;98.5;100;\n2025-03-14T09:02:00Z;5.02;100;0.1\n2025-03-14T09:03:00Z;365.03;300;-0.2\n";
    for (titles, unit, open) in [
        ("Hc [gon];Vc [gon];res [nT]", "gon", "nothing is open"),
        ("horizontal circle;vertical circle;residual", "gon", "circles beyond 360 are in gon"),
        ("hc_deg;zenith_deg;reading (nT)", "deg", "nothing is open"),
    ] {
        fs::write(folder.path().join("a.csv"), format!("time;{titles}\n{rows}")).expect("written");
        let guess = run_in(INGEST, folder.path(), &["guess", "a.csv"]);
        assert!(guess.stderr.contains(open), "{titles}: {}", guess.stderr);
        assert!(guess.stderr.contains("ingest --procedure absolute --map MAP FILE"), "{}", guess.stderr);
        let columns = document(&guess.stdout)["columns"].clone();
        let found = [0, 1, 2].map(|k| (columns[k]["to"].as_str(), columns[k]["unit"].as_str()));
        let due = [("horizontal_deg", unit), ("vertical_deg", unit), ("residual_nt", "nT")];
        assert_eq!(found, due.map(|(to, unit)| (Some(to), Some(unit))), "{titles}");
    }
    // A column of that name alone is none.
    fs::write(folder.path().join("a.csv"), format!("time;vertical;b;c\n{rows}")).expect("written");
    assert!(!run_in(INGEST, folder.path(), &["guess", "a.csv"]).stdout.contains("vertical_deg"));
}
