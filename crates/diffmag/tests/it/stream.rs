//! One pass against pieces, batches, gaps and holes, and against numbers from outside.

use common::{Axis, DifferentialCalibration};
use diffmag::stream::{Error, Partial, Statistics, answer};
use noise::Stream;
use partial::{Error as Fault, Partial as _, Take, merge, parse, to_line};
use serde_json::Value;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::Range;
use testkit::reference::{list, number, reference};

use crate::answers::elements;

/// Time, reference and test.
pub struct Series {
    time_s: Vec<f64>,
    columns: [Vec<f64>; 6],
}

/// η of the pairs.
pub const ETA: [[f64; 3]; 3] = [[1.002, 0.003, -0.011], [-0.004, 0.998, 0.02], [0.007, -0.013, 1.001]];

#[derive(Clone, Copy)]
pub struct Truth {
    pub white_rms_nt: f64,
    pub flicker: f64,
    pub exponent: f64,
    pub drift_nt_per_day: f64,
}

/// All noise is cut out of series four times as long, so that it goes on below one over the length.
pub fn pair(truth: &Truth, rows: usize, first_s: f64, seed: u64) -> Series {
    let mut stream = Stream::new(seed, "pair");
    let mut cut = |amplitude: f64, exponent: f64| -> Vec<f64> {
        if amplitude == 0.0 {
            return vec![0.0; rows];
        }
        let long = noise::power_law(&mut stream, 4 * rows, 1.0, amplitude, exponent);
        let middle = long[2 * rows];
        long[rows..2 * rows].iter().map(|n| n - middle).collect()
    };
    let field: Vec<Vec<f64>> = [20_800.0, 700.0, 47_500.0]
        .into_iter()
        .map(|main| cut(2e-4, 1.6).into_iter().map(|n| main + n).collect())
        .collect();
    let flicker: Vec<Vec<f64>> = (0..3).map(|_| cut(truth.flicker, truth.exponent)).collect();
    let mut white = Stream::new(seed, "white");
    let test: Vec<Vec<f64>> = (0..3)
        .map(|j| {
            let row = |row: usize| {
                (0..3).map(|i| ETA[i][j] * field[i][row]).sum::<f64>()
                    + flicker[j][row]
                    + truth.white_rms_nt * white.normal()
                    + truth.drift_nt_per_day * row as f64 / 86_400.0
            };
            (0..rows).map(row).collect()
        })
        .collect();
    let columns = [field, test].concat().try_into().expect("six columns");
    Series { time_s: (0..rows).map(|row| first_s + row as f64).collect(), columns }
}

fn series(rows: usize, first_s: f64, seed: u64) -> Series {
    let truth = Truth { white_rms_nt: 0.02, flicker: 1e-4, exponent: 1.0, drift_nt_per_day: 0.8 };
    pair(&truth, rows, first_s, seed)
}

impl Series {
    fn push(&self, statistics: &mut Statistics, rows: Range<usize>) -> Result<(), Error> {
        let columns = std::iter::once(&self.time_s).chain(&self.columns);
        statistics.push(&columns.map(|column| &column[rows.clone()]).collect::<Vec<_>>())
    }

    /// Rows in batches.
    pub fn partial(&self, rows: Range<usize>, batch: usize) -> Partial {
        let mut statistics = Statistics::every(Some(1.0));
        let end = rows.end;
        for from in rows.step_by(batch) {
            self.push(&mut statistics, from..(from + batch).min(end)).expect("good rows");
        }
        statistics.finish().expect("a piece")
    }

    fn without(mut self, rows: Range<usize>) -> Self {
        self.time_s.drain(rows.clone());
        self.columns.iter_mut().for_each(|column| drop(column.drain(rows.clone())));
        self
    }
}

/// All numbers of an answer with their places.
fn places(found: &DifferentialCalibration) -> Vec<(String, f64)> {
    fn walk(path: String, value: &Value, all: &mut Vec<(String, f64)>) {
        match value {
            Value::Number(number) => all.push((path, number.as_f64().expect("a number"))),
            Value::Array(list) => {
                list.iter().enumerate().for_each(|(i, v)| walk(format!("{path}[{i}]"), v, all))
            }
            Value::Object(map) => map.iter().for_each(|(key, v)| walk(format!("{path}.{key}"), v, all)),
            _ => {}
        }
    }
    let mut all = Vec::new();
    walk(String::new(), &serde_json::to_value(found).expect("JSON"), &mut all);
    all
}

fn same(one: &Partial, other: &Partial) -> Result<(), String> {
    let [one, other] = [one, other].map(|partial| answer(partial).expect("an answer"));
    let (distance, place) = apart(&one, &other);
    if distance < 1e-12 { Ok(()) } else { Err(format!("{distance:e} {place}")) }
}

/// The greatest difference of two answers, of each number relative to the largest of its list: a vector is
/// held at its own length.
fn apart(one: &DifferentialCalibration, other: &DifferentialCalibration) -> (f64, String) {
    let list = |path: &str| match (path.rfind('['), path.rfind(']')) {
        (Some(from), Some(to)) => path[..from].to_string() + &path[to..],
        _ => path.to_string(),
    };
    let (one, other) = (places(one), places(other));
    assert_eq!(one.len(), other.len());
    let mut largest: BTreeMap<String, f64> = BTreeMap::new();
    for (path, value) in &one {
        let largest = largest.entry(list(path)).or_default();
        *largest = largest.max(value.abs());
    }
    let mut worst = (0.0, String::new());
    for ((path, a), (_, b)) in one.into_iter().zip(other) {
        // Numbers near zero are held to 1e-15.
        let distance = (a - b).abs() / largest[&list(&path)].max(1e-3);
        if distance > worst.0 {
            worst = (distance, format!("{path}: {a} {b}"));
        }
    }
    worst
}

#[test]
fn batches_do_not_matter() {
    let mut series = series(20_000, -777.0, 3);
    series.columns[4][5000] = f64::NAN;
    let series = series.without(9000..9777);
    let whole = to_line(&series.partial(0..series.time_s.len(), usize::MAX >> 1));
    for batch in [1, 7, 1000, 4096] {
        assert_eq!(to_line(&series.partial(0..series.time_s.len(), batch)), whole, "{batch}");
    }
    let read: Partial = parse(&whole).expect("a piece");
    assert_eq!(to_line(&read), whole);
    assert_eq!((read.samples, read.missing, read.absent, read.gaps), (19_222, 1, 777, 1));
    assert!(whole.len() < 80_000);
}

/// A series with a gap and readings that are missing, from a seed.
fn with_holes(seed: u64) -> Series {
    let mut series = series(4_900, [0.0, -5003.0, 1_700_000_017.0][(seed % 3) as usize], seed);
    (0..seed % 30).for_each(|k| {
        series.columns[(k % 6) as usize][((seed >> 7) as usize + 397 * k as usize) % 4_000] = f64::NAN
    });
    let gap = 500 + (seed % 3000) as usize;
    series.without(gap..gap + 700)
}

#[test]
fn pieces_in_any_order_and_grouping() {
    let cached: RefCell<Option<(u64, Series)>> = RefCell::default();
    let piece = |seed: u64, rows: Range<usize>| {
        let mut cached = cached.borrow_mut();
        if cached.as_ref().is_none_or(|(of, _)| *of != seed) {
            *cached = Some((seed, with_holes(seed)));
        }
        cached.as_ref().expect("made").1.partial(rows, 4096)
    };
    // A little more than 64 tiles, so that the blocks of the profile grow.
    testkit::partials_merge(6, 4_200, piece, same);
}

#[test]
fn holes_between_pieces_are_those_within_one() {
    let whole = series(9000, 17.0, 8).without(3011..3975);
    let pieces = [0..2000, 2000..3011, 3011..whole.time_s.len()].map(|rows| whole.partial(rows, 999));
    let joined = merge(pieces.to_vec()).expect("no overlap");
    assert_eq!((joined.absent, joined.gaps), (0, 0), "another piece may fill the hole");
    let closed = answer(&joined).expect("an answer");
    assert_eq!(closed.fit.expect("a fit").missing, 964);
    assert_eq!(same(&whole.partial(0..8036, 999), &joined), Ok(()));
}

#[test]
fn the_size_has_a_limit() {
    // More holes than are kept open, between two tiles or within one.
    let all = series(36_000, 5.0, 2);
    let pieces: Vec<Partial> = (0..600).map(|k| all.partial(60 * k..60 * k + 20 + k % 30, 4096)).collect();
    let joined = merge(pieces.clone()).expect("no overlap");
    assert!(to_line(&joined).len() < 8_000_000);
    assert_eq!(joined.gaps, 600 - partial::MOST as u64);
    let mut other = merge(pieces.iter().step_by(2).cloned().collect()).expect("no overlap");
    other.join(merge(pieces.iter().skip(1).step_by(2).cloned().collect()).expect("apart")).expect("apart");
    assert_eq!(same(&joined, &other), Ok(()));
}

#[test]
fn wrong_pieces_are_refused() {
    // What a table or a line of a piece can have is in `fixtures/bad/diffmag/stream`.
    let piece = series(2000, 0.0, 1).partial(0..2000, 1000);
    assert_eq!(merge(Vec::<Partial>::new()), Err(Fault::Empty.into()));
    let edited = to_line(&piece).replace("\"profile\":{\"level\":6", "\"profile\":{\"level\":99");
    assert!(parse::<Partial>(&edited).expect_err("no such level").to_string().contains("was it edited?"));
}

#[test]
fn wrong_rows_are_told_by_their_number() {
    let mut series = series(300, 0.0, 1);
    let push = |series: &Series| {
        let mut statistics = Statistics::every(Some(1.0));
        series.push(&mut statistics, 0..100).and_then(|()| series.push(&mut statistics, 100..300))
    };
    series.time_s[150] = 150.45;
    assert!(matches!(push(&series), Err(Error::OffGrid { row: 150, .. })));
    series.time_s[150] = 149.0;
    assert!(matches!(push(&series), Err(Error::Piece(Fault::Backwards { row: 150, .. }))));
    series.time_s[150] = f64::NAN;
    assert!(matches!(push(&series), Err(Error::Piece(Fault::NoTime { row: 150 }))));
    assert_eq!(Statistics::default().finish(), Ok(Partial::default()));
}

#[test]
fn numpy_has_the_same() {
    let reference = reference("diffmag_stream");
    let with_holes =
        |value: &Value| -> Vec<f64> { list(value).iter().map(|v| v.as_f64().unwrap_or(f64::NAN)).collect() };
    let columns: Vec<Vec<f64>> = list(&reference["columns"]).iter().map(with_holes).collect();
    let series =
        Series { time_s: with_holes(&reference["time_s"]), columns: columns.try_into().expect("six") };
    let partial = series.partial(0..series.time_s.len(), 1000);
    let fit = answer(&partial).expect("an answer").fit.expect("a fit");
    let mut worst: [f64; 3] = [0.0; 3];
    for (name, i, j) in elements() {
        let (expected, element) = (&reference["axes"][j], &fit.elements[&name]);
        let of = |key: &str| number(&expected[key][i]);
        worst[0] = worst[0].max((element.least_squares - of("eta")).abs());
        worst[1] = worst[1].max((element.std_independent / of("std") - 1.0).abs());
        let rms_nt = fit.axes.get(Axis::ALL[j]).expect("an axis").rms_nt;
        worst[2] = worst[2].max((rms_nt / number(&expected["rms_nt"]) - 1.0).abs());
    }
    let pieces = [0..311, 311..1400, 1400..series.time_s.len()].map(|rows| series.partial(rows, 1000));
    assert_eq!(same(&partial, &merge(pieces.to_vec()).expect("no overlap")), Ok(()));
    println!("eta {:.1e}, std {:.1e}, rms {:.1e}", worst[0], worst[1], worst[2]);
    assert!(worst[0] < 1e-14 && worst[1] < 1e-12 && worst[2] < 1e-12, "{worst:?}");
}
