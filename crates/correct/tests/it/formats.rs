//! Formats of observatories: `ingest` reads what was written, to half a digit; what they cannot hold is refused.

use common::Recording;
use std::fs;
use std::path::Path;

const CORRECT: &str = env!("CARGO_BIN_EXE_correct");
const MINUTES: &str = "ingest/flx20240310a.min";

/// Runs on a file of readings; what it said, and the code.
fn correct(folder: &Path, readings: &str, arguments: &str) -> (i32, String) {
    let calibration = testkit::fixture("correct/flight/input.json");
    let given = ["--calibration", calibration.to_str().expect("UTF-8"), readings];
    let arguments: Vec<&str> = given.into_iter().chain(arguments.split(' ')).collect();
    let run = testkit::run_in(CORRECT, folder, &arguments);
    (run.code, run.stderr)
}

fn read(path: &Path) -> Recording {
    let options = ingest::Options { readings: ingest::Readings::Inline, ..Default::default() };
    let read = ingest::run(Default::default(), &[path.into()], &options).expect("read");
    read.document.recordings.into_iter().next().expect("a recording")
}

#[test]
fn ingest_reads_what_was_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let minutes = testkit::fixture(MINUTES);
    let minutes = minutes.to_str().expect("UTF-8");
    assert_eq!(correct(folder.path(), minutes, "-q --frame geo --to csv -o geo.csv").0, 0);
    let table = tables::Reader::open(&folder.path().join("geo.csv"), None).expect("a table");
    let names = table.columns().to_vec();
    let due = table.into_iter().next().expect("rows").expect("rows").columns;
    let due = |name: &str| &due[names.iter().position(|known| known == name).expect(name)];
    for (format, half, rows) in [("iaga", 0.005, 40), ("imf", 0.05, 1440), ("imagcdf", 0.0, 40)] {
        let asked = format!("--{format} flx --place 47.93,15.87,1087 -o written");
        let (code, said) = correct(folder.path(), minutes, &asked);
        assert!(code == 0 && said.contains("correct: 39 of 40 rows have a field in GEO"), "{said}");
        let found = read(&folder.path().join("written"));
        assert_eq!((found.rows(), found.start.as_deref()), (rows, Some("2024-03-10T00:00:00Z")), "{format}");
        for (name, from) in [
            ("time_s", "time_s"),
            ("sensor_x_nt", "field_geo_x_nt"),
            ("sensor_y_nt", "field_geo_y_nt"),
            ("sensor_z_nt", "field_geo_z_nt"),
            ("reference_nt", "reference_nt"),
        ] {
            for (found, due) in found.column(name).expect(name).iter().zip(due(from)) {
                let same = (found - due).abs() <= half + 1e-9 || (found.is_nan() && due.is_nan());
                assert!(same, "{format}, {name}: {found} {due}");
            }
        }
        let header = serde_json::to_string(&found.extra).expect("JSON").to_lowercase();
        for word in ["\"47.9", "\"15.", "flx"] {
            assert!(header.contains(word), "{format}: {header}");
        }
    }
}

/// Gaps become missing values at evenly spaced times, over the leap second at the end of 2016.
#[test]
fn times_of_imagcdf_are_evenly_spaced() {
    let folder = tempfile::tempdir().expect("a folder");
    let table = "time_s,samples,sensor_x_nt,sensor_y_nt,sensor_z_nt\n0.5,1,1,2,3\n1.5,1,1,2,3\n2.5,1,1,2,3\n6.5,1,1,2,3\n";
    fs::write(folder.path().join("means.csv"), table).expect("written");
    let (code, said) =
        correct(folder.path(), "means.csv", "--imagcdf FLX --start 2016-12-31T23:59:58Z -o field.cdf");
    assert_eq!(code, 0, "{said}");
    let found = read(&folder.path().join("field.cdf"));
    assert_eq!(found.start.as_deref(), Some("2016-12-31T23:59:58.5Z"));
    assert_eq!(found.column("time_s").expect("times"), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let there = found.column("sensor_x_nt").expect("X").iter().map(|value| value.is_finite());
    assert_eq!(there.collect::<Vec<_>>(), [true, true, true, false, false, false, true]);
}

#[test]
fn what_a_format_cannot_hold_is_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let header = "time_s,sensor_x_nt,sensor_y_nt,sensor_z_nt\n";
    let file = |name: &str, rows: &str| {
        fs::write(folder.path().join(name), header.to_string() + rows).expect("written")
    };
    file("half.csv", "30,1,2,3\n90,1,2,3\n");
    file("seconds.csv", "0,1,2,3\n1,1,2,3\n2,1,2,3\n");
    file("uneven.csv", "0,1,2,3\n1,1,2,3\n2,1,2,3\n3.4,1,2,3\n");
    file("twice.csv", "0,1,2,3\n0,1,2,3\n");
    file("large.csv", "0,90000,2,3\n");
    file("none.csv", "");
    let calibration = testkit::read_fixture("correct/flight/input.json");
    fs::write(folder.path().join("flight.json"), calibration).expect("written");
    let faults = r#"
CORRECT half.csv --imf FLX START
    row 1: found time_s = 30; expected a row each 60 s, centred on the minute
CORRECT seconds.csv --imf FLX START
    series resample --step 60
CORRECT seconds.csv --imf FLXX START
    expected three letters or digits
CORRECT uneven.csv --imagcdf FLX START
    row 4: found time_s = 3.4; expected evenly spaced times, apart from gaps
CORRECT seconds.csv --imagcdf FLX --start 1971-12-31T23:59:59Z
    expected a time since 1972
CORRECT twice.csv --imagcdf FLX START
    row 2: found time_s = 0; expected times that increase
CORRECT large.csv --iaga FLX START
    expected a field within ±88880 nT
CORRECT none.csv --imf FLX START
    found no rows
CORRECT seconds.csv --place 1,2,3
    give --iaga, --imf or --imagcdf too
CORRECT seconds.csv --iaga FLX --imf FLX START
    cannot be used with
"#;
    let faults = faults.replace("CORRECT", "--calibration flight.json -o out");
    let faults = faults.replace("START", "--start 2024-03-10T00:00:00Z");
    assert_eq!(testkit::refusals(CORRECT, folder.path(), &faults), 10);
}
