//! Standard input and output of every program: `-`, marks of byte order, readings that are left out.

use serde_json::Value;
use std::fs;
use std::path::Path;

use crate::{beside, fixture};

/// A command of each kind: the program, its arguments, where `@` begins a fixture, and what it reads on
/// standard input.
const COMMANDS: &[(&str, &[&str], &str)] = &[
    ("simulate", &["campaign"], "plans/magsat-axes.json"),
    ("simulate", &["campaign", "--run-sheet"], "plans/magsat-axes.json"),
    ("simulate", &["observatory"], "plans/observatory.json"),
    ("simulate", &["flight"], "plans/flight.json"),
    ("simulate", &["replay"], "axescal/magsat/expected.json"),
    ("simulate", &["sweep", "--seeds", "1..2"], "plans/magsat-axes.json"),
    ("ingest", &["@ingest/field.csv"], ""),
    ("ingest", &["guess", "@ingest/logger.csv"], ""),
    ("series", &["cut", "--from", "-3"], "scalarcal/meadow/input.json"),
    ("series", &["rename", "sensor=test"], "scalarcal/meadow/input.json"),
    ("coilcal", &[], "coilcal/uneven/input.json"),
    ("sensorcal", &[], "sensorcal/small/input.json"),
    ("axescal", &[], "axescal/magsat/input.json"),
    ("axescal", &["design", "--number", "3", "--table-to", "4"], ""),
    ("scalarcal", &[], "scalarcal/meadow/input.json"),
    ("scalarcal", &["stream"], "scalarcal/pieces/morning.csv"),
    ("diffmag", &[], "diffmag/turned-pair/input.json"),
    ("diffmag", &["stream", "--partial"], "diffmag/pieces/morning.csv"),
    ("starcal", &[], "starcal/day/input.json"),
    ("absolute", &[], "absolute/weeks/input.json"),
    ("diagnose", &[], "diagnose/delay/input.json"),
    ("correct", &[], "correct/flight/input.json"),
    (
        "correct",
        &["--calibration", "@correct/flight/input.json", "--from", "csv"],
        "correct/flight/readings.csv",
    ),
    ("report", &["--text"], "axescal/magsat/expected.json"),
];

fn input(name: &str) -> String {
    if name.is_empty() { String::new() } else { testkit::read_fixture(name) }
}

/// Runs a command in a folder of its own, in which it leaves nothing behind.
fn run(program: &str, arguments: &[&str], more: &[&str], input: &str) -> testkit::Run {
    let arguments = arguments.iter().chain(more);
    let arguments: Vec<String> =
        arguments.map(|argument| argument.strip_prefix('@').map_or(argument.to_string(), fixture)).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    testkit::run(&beside(program), &arguments, input)
}

/// `-o -` is standard output. (A file of that name would be in the present folder.)
#[test]
fn a_dash_is_standard_output() {
    for (program, arguments, read) in COMMANDS {
        let input = input(read);
        let plain = run(program, arguments, &["-q"], &input);
        assert_eq!(plain.code, 0, "{program} {arguments:?}: {}", plain.stderr);
        let dashed = run(program, arguments, &["-q", "-o", "-"], &input);
        assert!(!plain.stdout.is_empty() && plain.stdout == dashed.stdout, "{program} {arguments:?}");
        assert!(!Path::new("-").exists(), "{program} {arguments:?} wrote a file that is called -");
    }
}

/// A byte order mark before a document, a plan, a piece, a table, a mapping or a specification changes
/// nothing but the history.
#[test]
fn a_byte_order_mark_is_no_fault() {
    let without_digest = |text: &str| -> String {
        text.lines().filter(|line| !line.contains("sha256") && !line.contains("SHA-256")).collect()
    };
    // diagnose takes a second, and reads as the other stages do.
    let reading = COMMANDS.iter().filter(|(program, _, read)| !read.is_empty() && *program != "diagnose");
    for (program, arguments, read) in reading {
        let input = input(read);
        let plain = run(program, arguments, &["-q"], &input);
        let marked = run(program, arguments, &["-q"], &format!("\u{feff}{input}"));
        assert_eq!(marked.code, 0, "{program} {arguments:?}: {}", marked.stderr);
        assert!(without_digest(&marked.stdout) == without_digest(&plain.stdout), "{program} {arguments:?}");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let marked = |name: &str| {
        let path = folder.path().join(name.replace('/', "-"));
        fs::write(&path, format!("\u{feff}{}", testkit::read_fixture(name))).expect("written");
        path.to_str().expect("UTF-8").to_string()
    };
    let [map, csv, spec, plan] =
        ["ingest/codes-map.json", "ingest/codes.csv", "specs/magsat.json", "plans/magsat-axes.json"]
            .map(marked);
    let pieces = run("diffmag", &["stream", "--partial"], &[], &input("diffmag/pieces/morning.csv")).stdout;
    for (program, arguments, input) in [
        ("ingest", vec!["--map", &map, &csv], String::new()),
        ("ingest", vec!["guess", &csv], String::new()),
        ("report", vec!["--text", "--spec", &spec], input("specs/calibrated/input.json")),
        ("simulate", vec!["campaign", "--run-sheet", &plan], String::new()),
        ("diffmag", vec!["merge"], format!("\u{feff}{pieces}")),
    ] {
        let done = run(program, &arguments, &["-q"], &input);
        assert_eq!(done.code, 0, "{program} {arguments:?}: {}", done.stderr);
    }
}

/// Rows on standard input are those of the file, in each form that can come in a stream.
#[test]
fn a_stream_is_read_from_standard_input() {
    let file = fixture("diffmag/pieces/morning.csv");
    let of_file = run("diffmag", &["stream", &file], &[], "");
    let csv = fs::read_to_string(&file).expect("a fixture");
    let mut rows = csv.lines();
    let names: Vec<&str> = rows.next().expect("names").split(',').collect();
    let object = |row: &str| {
        let values = row.split(',').map(|value| if value.is_empty() { "null" } else { value });
        let pairs: Vec<String> =
            names.iter().zip(values).map(|(name, value)| format!("\"{name}\":{value}")).collect();
        format!("{{{}}}\n", pairs.join(","))
    };
    let ndjson: String = rows.map(object).collect();
    for (form, input) in [("CSV", &csv), ("NDJSON", &ndjson)] {
        for arguments in [vec!["stream"], vec!["stream", "-"]] {
            let streamed = run("diffmag", &arguments, &[], input);
            assert_eq!((streamed.code, &streamed.stderr), (0, &of_file.stderr), "{form}");
            assert!(streamed.stdout == of_file.stdout, "{form}");
        }
    }
    let document = run("diffmag", &["stream", "@diffmag/turned-pair/input.json"], &[], "");
    let streamed = run("diffmag", &["stream"], &[], &input("diffmag/turned-pair/input.json"));
    assert_eq!((document.code, streamed.code), (0, 0), "{}", streamed.stderr);
    assert!(document.stdout == streamed.stdout);
    for (arguments, input, words) in [
        (vec!["stream", "-", "-"], "", "- twice; standard input can be read once"),
        (vec!["stream"], "", "standard input: found an empty file"),
        (vec!["stream"], "time_s,x\n0,1\n", "standard input: found the columns time_s, x; expected"),
        (vec!["stream"], "PAR1", "standard input: found Parquet; expected CSV, NDJSON or a document"),
    ] {
        let refused = run("diffmag", &arguments, &[], input);
        assert!(refused.code == 2 && refused.stderr.contains(words), "{arguments:?}: {}", refused.stderr);
    }
}

/// Readings that a stage took are left out, with their digest; what it found is the same.
#[test]
fn readings_are_left_out_where_that_is_asked() {
    let stages = COMMANDS.iter().filter(|(program, arguments, _)| {
        let stages =
            ["coilcal", "sensorcal", "axescal", "scalarcal", "starcal", "diffmag", "absolute", "diagnose"];
        stages.contains(program) && arguments.is_empty()
    });
    for (program, _, read) in stages {
        let (input, json) = (input(read), |text: &str| serde_json::from_str::<Value>(text).expect("JSON"));
        let whole = json(&run(program, &[], &["-q"], &input).stdout);
        let short = run(program, &[], &["-q", "--drop-recordings"], &input);
        assert_eq!(short.code, 0, "{program}: {}", short.stderr);
        let lean = json(&short.stdout);
        for part in ["calibration", "diagnosis", "model", "instrument", "facility"] {
            assert_eq!(lean[part], whole[part], "{program}: {part}");
        }
        let recordings = lean["recordings"].as_array().expect("recordings");
        let dropped = recordings.iter().filter(|recording| recording["dropped"]["sha256"].is_string());
        assert!(dropped.clone().count() > 0, "{program}");
        assert!(dropped.clone().all(|recording| recording.get("columns").is_none()), "{program}");
        // The same stage says what is missing; readings that are put back are held to the digest.
        let refused = run(program, &[], &[], &short.stdout);
        let said = &refused.stderr;
        assert!(refused.code == 2 && said.contains("that an earlier stage left out"), "{said}");
        let mut back = lean.clone();
        for (number, recording) in back["recordings"].as_array_mut().expect("a list").iter_mut().enumerate() {
            recording["columns"] = whole["recordings"][number]["columns"].clone();
        }
        if *program != "diagnose" {
            let again = run(program, &[], &["-q"], &back.to_string());
            assert_eq!(again.code, 0, "{program}: {}", again.stderr);
        }
        let place = recordings.iter().position(|one| one["dropped"].is_object()).expect("one");
        let columns = back["recordings"][place]["columns"].as_object_mut().expect("columns");
        let (_, column) = columns.iter_mut().next().expect("a column");
        let last = column.as_array_mut().expect("a column").last_mut().expect("a row");
        *last = serde_json::json!(last.as_f64().unwrap_or(0.0) + 0.5);
        let refused = run(program, &[], &[], &back.to_string());
        let path = format!("recordings[{place}].dropped.sha256: found");
        assert!(refused.code == 2 && refused.stderr.contains(&path), "{program}: {}", refused.stderr);
    }
}
