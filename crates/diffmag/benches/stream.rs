//! Speed of one pass over a day at 16 Hz of both instruments in batches of 65 536 rows, on one core. The peer reads the same
//! columns and adds them up. Time per row is the time shown over 1 382 400.

use diffmag::stream::{Batch, Partial, Statistics, answer};
use divan::{Bencher, black_box};
use noise::Stream;
use std::sync::LazyLock;

const ROWS: usize = 1_382_400;
const BATCH: usize = 65_536;

fn main() {
    divan::main();
}

static DAY: LazyLock<(Vec<f64>, [Vec<f64>; 6])> = LazyLock::new(|| {
    let mut stream = Stream::new(1, "day");
    let field = [20_000.0, 500.0, 45_000.0].map(|main| {
        let natural = noise::power_law(&mut stream, ROWS, 0.0625, 2e-4, 1.6);
        natural.into_iter().map(|n| main + n).collect::<Vec<f64>>()
    });
    let test =
        field.each_ref().map(|column| column.iter().map(|b| 1.001 * b + 0.01 * stream.normal()).collect());
    let [x, y, z] = field;
    let [u, v, w] = test;
    ((0..ROWS).map(|row| row as f64 * 0.0625).collect(), [x, y, z, u, v, w])
});

fn pass() -> Partial {
    let (time, columns) = &*DAY;
    let mut statistics = Statistics::new();
    for from in (0..ROWS).step_by(BATCH) {
        let rows = from..(from + BATCH).min(ROWS);
        let [x, y, z, u, v, w] = columns.each_ref().map(|column| &column[rows.clone()]);
        let batch = Batch { time_s: &time[rows], reference_nt: [x, y, z], test_nt: [u, v, w] };
        statistics.push(black_box(&batch)).expect("on the grid");
    }
    statistics.finish().expect("rows")
}

#[divan::bench(sample_count = 10)]
fn one_pass(bencher: Bencher) {
    LazyLock::force(&DAY);
    bencher.bench_local(pass);
}

#[divan::bench(sample_count = 10)]
fn one_pass_peer_sums(bencher: Bencher) {
    let (time, columns) = &*DAY;
    bencher.bench_local(|| {
        columns.iter().chain([time]).map(|column| black_box(column).iter().sum::<f64>()).sum::<f64>()
    });
}

#[divan::bench(sample_count = 10)]
fn the_answer(bencher: Bencher) {
    let partial = pass();
    bencher.bench_local(|| answer(black_box(&partial)).expect("an answer"));
}
