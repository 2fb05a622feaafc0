//! Every document of `fixtures/bad/correct` brings its message, its exit code, and nothing on standard
//! output; and so does each table that is not as it must be.

use std::fs;

const CORRECT: &str = env!("CARGO_BIN_EXE_correct");

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/correct", CORRECT) >= 14);
}

/// What is asked, and below it what is said.
const FAULTS: &str = r#"
good.csv
    correct: good.csv: found lines of values (CSV); expected a fluxcal document. To read it:\n  correct --calibration DOCUMENT good.csv
--calibration good.csv good.csv
    good.csv: found lines of values (CSV)
--calibration flight.json --map map.json good.csv
    good.csv, line 1: found no column "u"
--calibration flight.json fill.csv -o out.csv
    fill.csv, row 2, column sensor_y_v: found -1e31; expected a reading between −1000000 and 1000000
--calibration flight.json two.csv
    correct: two.csv: found the columns time_s, sensor_x_v, sensor_y_v; expected readings of three sensors, sensor_x_v, sensor_y_v, sensor_z_v, or the same in nT
--calibration flight.json word.csv -o out.csv
    word.csv, line 3, column 2 (sensor_y_v)
--calibration flight.json short.csv -o out.csv
    short.csv, line 3
--calibration flight.json short.parquet
    short.parquet
--calibration flight.json nowhere.csv
    nowhere.csv: cannot be read
--calibration nowhere.json good.csv
    nowhere.json: cannot be read
--calibration flight.json good.xlsx
    the file's name does not say its format
--calibration flight.json --recording fright good.csv
    there is no recording "fright" in the calibration's document; expected one of: flight
--calibration flight.json -
    the format of standard input is unknown; expected --from csv
"#;

#[test]
fn each_fault_of_a_table_has_its_message() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("written");
    write("flight.json", &testkit::read_fixture("correct/flight/input.json"));
    write("two.csv", "time_s,sensor_x_v,sensor_y_v\n0,1,2\n");
    write("word.csv", "sensor_x_v,sensor_y_v,sensor_z_v\n1,2,3\n1,two,3\n");
    write("short.csv", "sensor_x_v,sensor_y_v,sensor_z_v\n1,2,3\n1,2\n");
    write("good.csv", "sensor_x_v,sensor_y_v,sensor_z_v\n1,2,3\n");
    write("short.parquet", "PAR1");
    write("fill.csv", "sensor_x_v,sensor_y_v,sensor_z_v\n1,2,3\n1,-1e31,3\n");
    write(
        "map.json",
        r#"{"fluxcal-mapping": 1, "header_line": 1, "columns": [{"from": "u", "to": "sensor_x_v", "unit": "V"}]}"#,
    );
    assert_eq!(testkit::refusals(CORRECT, folder.path(), FAULTS), 13);
}
