//! A real pair of instruments, whose recordings are not in the repository: `just recordings` runs this test. What is
//! found of more pairs is in docs/proof/real.md.

use common::{Axis, DifferentialFit, Recording};
use std::fs;
use std::path::PathBuf;

use crate::answers::found;
use crate::pair_in_time::{self, columns, document};

/// Rows of three readings with the time before them, s.
type Rows = Vec<[f64; 4]>;

fn recording(id: &str, start: &str, instrument: &str, rows: &[[f64; 4]]) -> Recording {
    let column = |k: usize| -> Vec<f64> { rows.iter().map(|row| row[k]).collect() };
    let read = [column(1), column(2), column(3)];
    let recording = pair_in_time::recording(id, &column(0), columns(instrument, &read, &(0..rows.len())));
    Recording { start: Some(start.into()), ..recording }
}

fn fit(recordings: [Recording; 2], correct_clock: bool) -> DifferentialFit {
    *found(&document(recordings.into()), correct_clock).fit.expect("a fit")
}

/// Rows of a CSV with a header, `time` taken from the first column less `zero`.
fn csv(path: PathBuf, zero: f64) -> Rows {
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let number = |field: &str| field.trim().parse::<f64>().expect("a number");
    text.lines()
        .skip(1)
        .map(|line| {
            let fields: Vec<f64> = line.split(',').map(number).collect();
            [fields[0] - zero, fields[1], fields[2], fields[3]]
        })
        .collect()
}

#[test]
#[ignore = "needs the recordings: just recordings"]
fn conrad_fge_and_lemi_036() {
    let folder = testkit::recordings("wic-conrad-2022-08");
    let read = |name: &str| csv(folder.join(name), 1_660_089_600.0);
    let start = "2022-08-10T00:00:00Z";
    let pair = [
        recording("FGE", start, "reference", &read("fge_s0252_2022-08-10_1s.csv")),
        recording("LEMI-036", start, "test", &read("lemi036_xyz_2022-08-10_1s.csv")),
    ];
    let fit = fit(pair, false);
    assert_eq!(fit.samples + fit.missing, 86_400);
    // The FGE stands along the magnetic north, the LEMI's readings were turned to the geographic one: by the
    // declination.
    let turn = fit.elements["xy"].weighted.atan2(fit.elements["xx"].weighted).to_degrees();
    assert!((3.0..5.5).contains(&turn), "{turn}°");
    for axis in Axis::ALL {
        let rms = fit.axes.get(axis).expect("an axis").rms_nt;
        assert!(rms < 0.15, "{axis}: {rms} nT");
    }
}
