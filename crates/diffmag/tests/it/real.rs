//! Real pairs of instruments, whose recordings are not in the repository: `just recordings` runs these tests.

use common::{Axis, DifferentialFit, Document};
use serde_json::{Value, json};
use std::fs;
use std::path::PathBuf;

use crate::answers::found;

/// Rows of three readings with the time before them, s.
type Rows = Vec<[f64; 4]>;

fn recording(id: &str, start: &str, instrument: &str, rows: &[[f64; 4]]) -> Value {
    let column = |k: usize| -> Vec<f64> { rows.iter().map(|row| row[k]).collect() };
    let mut columns = json!({"time_s": column(0)});
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        columns[format!("{instrument}_{axis}_nt")] = json!(column(k + 1));
    }
    json!({"id": id, "procedure": "differential", "start": start, "columns": columns})
}

fn fit(recordings: [Value; 2], correct_clock: bool) -> DifferentialFit {
    let text = json!({"fluxcal": 1, "recordings": recordings}).to_string();
    let found = found(&Document::parse(&text).expect("a document"), correct_clock);
    *found.fit.expect("a fit")
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

/// Readings of a file of IAGA-2002, seconds from the beginning of September 2011.
fn iaga(text: &str) -> Rows {
    let rows = text.lines().filter(|line| line.starts_with("2011-"));
    rows.map(|line| {
        let fields: Vec<&str> = line.split_whitespace().collect();
        let number = |field: &str| field.parse::<f64>().expect("a number");
        let (day, clock) = (&fields[0][8..], fields[1]);
        let days = if fields[0].starts_with("2011-08") { 0.0 } else { number(day) };
        let seconds = 3600.0 * number(&clock[..2]) + 60.0 * number(&clock[3..5]) + number(&clock[6..]);
        [86_400.0 * (days - 1.0) + seconds, number(fields[3]), number(fields[4]), number(fields[5])]
    })
    .collect()
}

/// Readings of the DIDD: hours, minutes, X, Y, Z.
fn didd(text: &str, day: f64) -> Rows {
    text.lines()
        .skip(1)
        .filter(|line| !line.trim().is_empty())
        .map(|line| {
            let fields: Vec<f64> =
                line.split_whitespace().map(|field| field.parse().expect("a number")).collect();
            [86_400.0 * (day - 1.0) + 3600.0 * fields[0] + 60.0 * fields[1], fields[2], fields[3], fields[4]]
        })
        .collect()
}

#[test]
#[ignore = "needs the recordings: just recordings"]
fn cobenzl_didd_and_lemi_025() {
    let folder = testkit::recordings("wik-cobenzl-2011-09a");
    let text = |name: String| fs::read_to_string(folder.join(name)).expect("a file");
    let (mut reference, mut test) = (Rows::new(), Rows::new());
    for day in 1..=12 {
        reference.extend(didd(&text(format!("didd/SEP{day:02}11.WIK")), f64::from(day)));
        test.extend(iaga(&text(format!("lemi025/201109{day:02}v.min"))));
    }
    let start = "2011-09-01T00:00:00Z";
    let pair =
        [recording("DIDD", start, "reference", &reference), recording("LEMI-025", start, "test", &test)];
    let fit = fit(pair, true);
    // The LEMI stamps its minutes at 47 s; the field itself says when they were taken.
    let clock = fit.clock.expect("a clock");
    assert!(clock.offset_s.value().abs() < 40.0, "{} s", clock.offset_s.value());
    assert!(fit.kept_out.events.len() + fit.kept_out.gaps.len() > 0, "the edge of a city");
}

#[test]
#[ignore = "needs the recordings: just recordings"]
fn meson_hall_fluxgates() {
    let folder = testkit::recordings("tucan-fluxgates-2019-08-09-quiet");
    let text = fs::read_to_string(folder.join("online_data.csv")).expect("a file");
    let (mut reference, mut test) = (Rows::new(), Rows::new());
    for line in text.lines() {
        let volts: Vec<f64> = line.split(',').filter_map(|field| field.trim().parse().ok()).collect();
        let nt = |column: usize, sign: f64| sign * 1e5 * volts[column];
        let time_s = volts[0] - 1_565_373_900.0;
        // As the authors group and sign the third and the fourth sensor: 1 V is 100 µT.
        reference.push([time_s, nt(8, -1.0), nt(7, -1.0), nt(9, 1.0)]);
        test.push([time_s, nt(13, -1.0), nt(14, 1.0), nt(15, 1.0)]);
    }
    // The logger stopped for minutes, twice: the first stretch is taken.
    let gap = reference.windows(2).position(|pair| pair[1][0] - pair[0][0] > 30.0);
    let rows = gap.map_or(reference.len(), |row| row + 1);
    let start = "2019-08-09T18:05:00Z";
    let pair = [
        recording("sensor 3", start, "reference", &reference[..rows]),
        recording("sensor 4", start, "test", &test[..rows]),
    ];
    assert!(fit(pair, false).samples > 100);
}
