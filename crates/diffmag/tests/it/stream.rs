//! One pass against pieces, batches, gaps and holes, and against numbers from outside.

use diffmag::stream::{Batch, Error, Grid, Partial, Statistics, StreamFit, answer};
use noise::Stream;
use partial::{Error as Fault, Partial as _, merge, parse, to_line};
use serde_json::Value;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::Range;

/// Time, reference and test.
struct Series {
    time_s: Vec<f64>,
    columns: [Vec<f64>; 6],
}

const ETA: [[f64; 3]; 3] = [[1.002, 0.003, -0.011], [-0.004, 0.998, 0.02], [0.007, -0.013, 1.001]];

fn series(rows: usize, first_s: f64, seed: u64) -> Series {
    let mut stream = Stream::new(seed, "pair");
    let field: Vec<Vec<f64>> = [20_800.0, 700.0, 47_500.0]
        .into_iter()
        .map(|main| {
            noise::power_law(&mut stream, rows, 1.0, 2e-4, 1.6).iter().map(|n| main + 10.0 * n).collect()
        })
        .collect();
    let test: Vec<Vec<f64>> = (0..3)
        .map(|j| {
            let flicker = noise::power_law(&mut stream, rows, 1.0, 1e-4, 1.0);
            (0..rows)
                .map(|row| {
                    (0..3).map(|i| ETA[i][j] * field[i][row]).sum::<f64>()
                        + 12.0
                        + flicker[row]
                        + 0.02 * stream.normal()
                        + 1e-5 * row as f64
                })
                .collect()
        })
        .collect();
    let columns = [field, test].concat().try_into().expect("six columns");
    Series { time_s: (0..rows).map(|row| first_s + row as f64).collect(), columns }
}

impl Series {
    fn push(&self, statistics: &mut Statistics, rows: Range<usize>) -> Result<(), Error> {
        let [x, y, z, u, v, w] = self.columns.each_ref().map(|column| &column[rows.clone()]);
        statistics.push(&Batch { time_s: &self.time_s[rows], reference_nt: [x, y, z], test_nt: [u, v, w] })
    }

    /// Rows in batches; those of `left_out` are not there.
    fn partial(&self, rows: Range<usize>, batch: usize) -> Partial {
        let grid = Grid { step_s: 1.0, half: false };
        let mut statistics = Statistics::on(grid);
        let end = rows.end;
        for from in rows.step_by(batch) {
            self.push(&mut statistics, from..(from + batch).min(end)).expect("good rows");
        }
        statistics.finish()
    }

    fn without(mut self, rows: Range<usize>) -> Self {
        self.time_s.drain(rows.clone());
        self.columns.iter_mut().for_each(|column| drop(column.drain(rows.clone())));
        self
    }
}

/// All numbers of an answer with their places.
fn numbers(fit: &StreamFit) -> Vec<(String, f64)> {
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
    walk(String::new(), &serde_json::to_value(fit).expect("JSON"), &mut all);
    all
}

/// The greatest difference of two answers, of each number relative to the largest of its list: a vector is
/// held at its own length.
fn apart(one: &StreamFit, other: &StreamFit) -> (f64, String) {
    let list = |path: &str| match (path.rfind('['), path.rfind(']')) {
        (Some(from), Some(to)) => path[..from].to_string() + &path[to..],
        _ => path.to_string(),
    };
    let (one, other) = (numbers(one), numbers(other));
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
    println!("{} bytes", whole.len());
    assert!(whole.len() < 80_000);
}

/// A series with a gap and readings that are missing, from a seed.
fn with_holes(seed: u64) -> Series {
    let mut series = series(12_700, [0.0, -5003.0, 1_700_000_017.0][(seed % 3) as usize], seed);
    (0..seed % 30).for_each(|k| {
        series.columns[(k % 6) as usize][((seed >> 7) as usize + 397 * k as usize) % 11_000] = f64::NAN
    });
    let gap = 1000 + (seed % 9000) as usize;
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
    testkit::partials_merge(12, 12_000, piece, |one: &Partial, other: &Partial| {
        let (distance, place) = apart(&answer(one).expect("an answer"), &answer(other).expect("an answer"));
        if distance < 1e-12 { Ok(()) } else { Err(format!("{distance:e} {place}")) }
    });
}

#[test]
fn holes_between_pieces_are_those_within_one() {
    let whole = series(9000, 17.0, 8).without(3011..3975);
    let pieces = [0..2000, 2000..3011, 3011..whole.time_s.len()].map(|rows| whole.partial(rows, 999));
    let joined = merge(pieces.to_vec()).expect("no overlap");
    assert_eq!((joined.absent, joined.gaps), (0, 0), "another piece may fill the hole");
    let (joined, whole) =
        (answer(&joined).expect("an answer"), answer(&whole.partial(0..8036, 999)).expect("an answer"));
    assert_eq!((joined.absent, joined.gaps), (964, 1));
    let (distance, place) = apart(&whole, &joined);
    assert!(distance < 1e-12, "{distance:e} {place}");
}

#[test]
fn the_size_has_a_limit() {
    // More holes than are kept open, between two tiles or within one.
    let all = series(36_000, 5.0, 2);
    let pieces: Vec<Partial> = (0..600).map(|k| all.partial(60 * k..60 * k + 20 + k % 30, 4096)).collect();
    let joined = merge(pieces.clone()).expect("no overlap");
    let text = to_line(&joined);
    println!("{} bytes, {} of one piece", text.len(), to_line(&pieces[0]).len());
    assert!(text.len() < 8_000_000);
    assert_eq!(joined.gaps, 600 - partial::MOST as u64);
    let mut other = merge(pieces.iter().step_by(2).cloned().collect()).expect("no overlap");
    other.join(merge(pieces.iter().skip(1).step_by(2).cloned().collect()).expect("apart")).expect("apart");
    let (distance, place) = apart(&answer(&joined).expect("an answer"), &answer(&other).expect("an answer"));
    assert!(distance < 1e-12, "{distance:e} {place}");
}

#[test]
fn wrong_pieces_are_refused() {
    let series = series(4000, 0.0, 1);
    let piece = |rows| series.partial(rows, 1000);
    let text = |error: Error| error.to_string();
    let overlap = merge(vec![piece(0..2000), piece(1999..4000)]).expect_err("the row 1999 twice");
    assert_eq!(text(overlap), Error::Piece(Fault::Overlap { from_s: 1999.0, to_s: 1999.0 }).to_string());
    let mut other = piece(2000..4000);
    other.grid = Some(Grid { step_s: 2.0, half: false });
    assert!(
        text(merge(vec![piece(0..2000), other]).expect_err("two steps")).contains("every 1 s and every 2 s")
    );
    assert_eq!(merge(Vec::<Partial>::new()), Err(Fault::Empty.into()));
    let kind = to_line(&piece(0..2000)).replace("\"diffmag\"", "\"sensorcal\"");
    let edited = to_line(&piece(0..2000)).replace("\"profile\":{\"level\":6", "\"profile\":{\"level\":99");
    assert!(parse::<Partial>(&edited).expect_err("no such level").to_string().contains("was it edited?"));
    assert!(parse::<Partial>(&kind).expect_err("another kind").to_string().contains("found `sensorcal`"));
    assert!(matches!(parse::<Partial>("{}"), Err(Fault::Format { .. })));
    assert!(answer(&piece(0..100)).is_err());
}

#[test]
fn wrong_rows_are_told_by_their_number() {
    let mut series = series(300, 0.0, 1);
    let push = |series: &Series| {
        let mut statistics = Statistics::on(Grid { step_s: 1.0, half: false });
        series.push(&mut statistics, 0..100).and_then(|()| series.push(&mut statistics, 100..300))
    };
    series.time_s[150] = 150.45;
    assert!(matches!(push(&series), Err(Error::OffGrid { row: 150, .. })));
    series.time_s[150] = 149.0;
    assert!(matches!(push(&series), Err(Error::Piece(Fault::Backwards { row: 150, .. }))));
    series.time_s[150] = f64::NAN;
    assert!(matches!(push(&series), Err(Error::Piece(Fault::NoTime { row: 150 }))));
    assert_eq!(Statistics::new().finish(), Partial::default());
}

#[test]
fn numpy_has_the_same() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/reference/diffmag_stream.json");
    let reference: Value =
        serde_json::from_str(&std::fs::read_to_string(path).expect("the reference")).expect("JSON");
    let numbers = |value: &Value| -> Vec<f64> {
        value.as_array().expect("a list").iter().map(|v| v.as_f64().unwrap_or(f64::NAN)).collect()
    };
    let columns: Vec<Vec<f64>> =
        reference["columns"].as_array().expect("columns").iter().map(numbers).collect();
    let series = Series { time_s: numbers(&reference["time_s"]), columns: columns.try_into().expect("six") };
    let partial = series.partial(0..series.time_s.len(), 1000);
    let fit = answer(&partial).expect("an answer");
    let mut worst: [f64; 3] = [0.0; 3];
    for (axis, expected) in fit.axes.iter().zip(reference["axes"].as_array().expect("axes")) {
        let (eta, std) = (numbers(&expected["eta"]), numbers(&expected["std"]));
        for i in 0..3 {
            worst[0] = worst[0].max((axis.least_squares[i].value - eta[i]).abs());
            worst[1] = worst[1].max((axis.least_squares[i].std / std[i] - 1.0).abs());
        }
        worst[2] = worst[2].max((axis.rms_nt / expected["rms_nt"].as_f64().expect("rms") - 1.0).abs());
    }
    let pieces = [0..311, 311..1400, 1400..series.time_s.len()].map(|rows| series.partial(rows, 1000));
    let merged = answer(&merge(pieces.to_vec()).expect("no overlap")).expect("an answer");
    let (distance, place) = apart(&fit, &merged);
    println!("three pieces: {distance:.1e} {place}");
    assert!(distance < 1e-12, "{distance:e} {place}");
    println!("eta {:.1e}, std {:.1e}, rms {:.1e}", worst[0], worst[1], worst[2]);
    assert!(worst[0] < 1e-14 && worst[1] < 1e-12 && worst[2] < 1e-12, "{worst:?}");
}
