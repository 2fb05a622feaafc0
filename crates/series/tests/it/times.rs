//! Cutting, resampling, renaming and joining against series that are known at every time.

use common::{Column, Columns, Document, Recording};
use series::{Bound, Cut, Join, Operation, run};

/// The field at a time since 2025-03-14.
fn field(t: f64) -> f64 {
    20_000.0 + 30.0 * (t / 200.0).sin()
}

fn recording(id: &str, start: &str, time: &[f64], begin_s: f64, quantity: &str) -> Recording {
    let values = time.iter().map(|t| field(begin_s + t));
    let columns =
        [("time_s".to_string(), Column::from(time.to_vec())), (format!("{quantity}_x_nt"), values.collect())];
    Recording {
        id: id.into(),
        procedure: "free_run".into(),
        start: Some(start.into()),
        columns: Columns::from(columns),
        ..Recording::default()
    }
}

fn document(recordings: Vec<Recording>) -> Document {
    Document { fluxcal: 1, recordings, ..Document::default() }
}

/// The largest difference from the field, and how many values are missing.
fn against(recording: &Recording, name: &str, begin_s: f64) -> (f64, usize) {
    let values = recording.column(name).expect(name);
    let time = recording.column("time_s").expect("times");
    let there = time.iter().zip(values).filter(|(_, value)| value.is_finite());
    let most = there.map(|(t, value)| (value - field(begin_s + t)).abs()).fold(0.0, f64::max);
    (most, values.iter().filter(|value| value.is_nan()).count())
}

#[test]
fn a_cut_and_another_name() {
    let time: Vec<f64> = (0..600).map(f64::from).collect();
    let all = document(vec![recording("a", "2025-03-14T00:00:00Z", &time, 0.0, "sensor")]);
    let cut = Cut { from: Bound::parse("2025-03-14T00:01:00Z"), to: Bound::parse("120") };
    let outcome = run(all, &[], &Operation::Cut(cut)).expect("cut");
    let times = outcome.document.recordings[0].column("time_s").expect("times");
    assert_eq!((times.len(), times[0], times[59]), (60, 60.0, 119.0));
    let rename = Operation::Rename(vec![("sensor".into(), "test".into())]);
    let outcome = run(outcome.document, &["a".into()], &rename).expect("renamed");
    assert_eq!(against(&outcome.document.recordings[0], "test_x_nt", 0.0), (0.0, 0));
    assert_eq!(outcome.words, ["\"a\": sensor_x_nt is test_x_nt"]);
}

#[test]
fn another_step() {
    // Times to the millisecond, with a gap of 30 s.
    let rounded = |row: i32| (f64::from(row) / 3.0 * 1e3).round() / 1e3;
    let time: Vec<f64> = (0..3000).filter(|row| !(1200..1290).contains(row)).map(rounded).collect();
    let all = document(vec![recording("a", "2025-03-14T00:00:00.5Z", &time, 0.5, "sensor")]);
    let outcome = run(all, &[], &Operation::Resample(2.0)).expect("resampled");
    let resampled = &outcome.document.recordings[0];
    assert_eq!(resampled.column("time_s").expect("times")[..2], [1.5, 3.5]);
    let (off, missing) = against(resampled, "sensor_x_nt", 0.5);
    assert!(off < 0.05 && (14..80).contains(&missing), "{off} nT, {missing} missing");
    assert!(!outcome.words[0].contains("cubic pieces"), "{:?}", outcome.words);
}

#[test]
fn recordings_with_times_of_their_own() {
    // One at 1 s, one at 0.13 s that began 40 s later, one that is uneven and slow.
    let one: Vec<f64> = (0..1000).map(f64::from).collect();
    let two: Vec<f64> = (0..7000).map(|row| f64::from(row) * 0.13).collect();
    let three: Vec<f64> = (0..60).map(|row| f64::from(row) * 20.0 + f64::from(row * 7 % 5)).collect();
    let all = document(vec![
        recording("slow", "2025-03-13T23:59:50Z", &three, -10.0, "outside"),
        recording("one", "2025-03-14T00:00:00Z", &one, 0.0, "reference"),
        recording("two", "2025-03-14T01:00:40+01:00", &two, 40.0, "test"),
    ]);
    let join = Join {
        ids: ["one", "two", "slow"].map(str::to_string).into(),
        id: Some("pair".into()),
        procedure: Some("differential".into()),
    };
    let outcome = run(all, &[], &Operation::Join(join)).expect("joined");
    let [pair] = outcome.document.recordings.as_slice() else { panic!("one recording") };
    assert_eq!([pair.id.as_str(), pair.procedure.as_str()], ["pair", "differential"]);
    assert_eq!(outcome.changed, [0]);
    assert_eq!(against(pair, "reference_x_nt", 0.0), (0.0, 0));
    let (off, missing) = against(pair, "test_x_nt", 0.0);
    assert!(off < 0.1 && (90..150).contains(&missing), "{off} nT, {missing} missing");
    let (off, missing) = against(pair, "outside_x_nt", 0.0);
    assert!(off < 0.2 && missing == 0, "{off} nT, {missing} missing");
    assert!(outcome.words[1].contains("piecewise cubics: outside_x_nt"), "{:?}", outcome.words);
}
