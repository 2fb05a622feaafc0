//! What holds for every series.

use common::{Column, Columns, Document, Recording};
use proptest::prelude::*;
use series::{Average, Operation, run};

fn document(start: Option<&str>, columns: &[(&str, Vec<f64>)]) -> Document {
    let columns: Columns =
        columns.iter().map(|(name, values)| (name.to_string(), Column::from(values.clone()))).collect();
    let start = start.map(str::to_string);
    let recording =
        Recording { id: "a".into(), procedure: "free_run".into(), start, columns, ..Recording::default() };
    Document { fluxcal: 1, recordings: vec![recording], ..Document::default() }
}

fn average(document: Document, window_s: f64) -> Recording {
    let operation = Operation::Average(Average { window_s, share: 0.0 });
    run(document, &[], &operation).expect("averaged").document.recordings.swap_remove(0)
}

proptest! {
    /// No sample is lost or counted twice, and means of means, weighted by their samples, are the means of
    /// all: with gaps, missing readings and uneven times.
    #[test]
    fn means_of_means(
        steps in prop::collection::vec(1_u32..40, 2..120),
        missing in prop::collection::vec(any::<bool>(), 120),
    ) {
        let time: Vec<f64> = steps.iter().scan(0, |sum, step| { *sum += step; Some(f64::from(*sum)) }).collect();
        let values = |offset: f64| -> Vec<f64> { time.iter().map(|t| offset + (t / 13.0).sin()).collect() };
        let mut holed = values(20_000.0);
        holed.iter_mut().zip(&missing).filter(|(_, missing)| **missing).for_each(|(value, _)| *value = f64::NAN);
        let there = holed.iter().filter(|value| value.is_finite()).count() as f64;
        let columns = [("time_s", time.clone()), ("sensor_x_nt", values(44_000.0)), ("sensor_y_nt", holed)];
        let all = document(Some("2025-03-14T00:00:07Z"), &columns);
        let minutes = average(all.clone(), 60.0);
        let sum = |recording: &Recording, name: &str| recording.column(name).map(|column| column.iter().sum::<f64>());
        prop_assert_eq!(sum(&minutes, "samples"), Some(time.len() as f64));
        prop_assert_eq!(sum(&minutes, "sensor_y_nt_samples").unwrap_or(time.len() as f64), there);
        let twice = average(Document { recordings: vec![minutes], ..all.clone() }, 300.0);
        let once = average(all, 300.0);
        prop_assert_eq!(twice.columns.len(), once.columns.len());
        for (name, column) in &once.columns {
            let other = twice.column(name).expect("the column");
            for (a, b) in column.iter().zip(other) {
                prop_assert!((a - b).abs() < 1e-9 || a.is_nan() && b.is_nan(), "{name}: {a} {b}");
            }
        }
    }

    /// A window begins at a whole multiple of its length in UTC, whenever the recording began.
    #[test]
    fn windows_of_utc(start in 0_u32..3600, window in 1_u32..700) {
        let time: Vec<f64> = (0..500).map(f64::from).collect();
        let moment = format!("2025-03-14T{:02}:{:02}:{:02}Z", start / 3600, start / 60 % 60, start % 60);
        let means = average(document(Some(&moment), &[("time_s", time.clone()), ("sensor_x_nt", time)]), f64::from(window));
        let unix_s = means.start().expect("a start").unix_s;
        for middle in means.column("time_s").expect("times") {
            let begin = unix_s + middle - f64::from(window) / 2.0;
            let places = begin / f64::from(window);
            prop_assert!((places - places.round()).abs() < 1e-6, "{begin}");
        }
    }
}

/// Timestamps printed to the millisecond: a row that is due at a boundary is not lost to the window before.
#[test]
fn rounded_times() {
    let time: Vec<f64> = (0..160).map(|row| (f64::from(row) / 16.0 * 1e3).round() / 1e3).collect();
    let values = vec![1.0; time.len()];
    let means = average(document(None, &[("time_s", time), ("sensor_x_nt", values)]), 1.0);
    assert_eq!(means.column("samples").expect("samples"), [16.0; 10]);
}
