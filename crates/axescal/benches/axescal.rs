//! Speed of the stage, with a single decomposition of the same size as its peer in the same run.

use axescal::Options;
use common::Document;
use faer::Mat;

fn main() {
    divan::main();
}

/// The peer: one singular value decomposition of the 63×12 matrix that every step needs.
#[divan::bench]
fn peer_one_svd_63x12(bencher: divan::Bencher) {
    let matrix = Mat::from_fn(63, 12, |i, j| ((i * 37 + j * 11) % 23) as f64 - 11.0);
    bencher.bench(|| matrix.thin_svd().expect("finite"));
}

/// The whole stage on the parsed document: solve, doubtful readings, leave-one-out, bounds, result.
#[divan::bench]
fn whole_stage(bencher: divan::Bencher) {
    let text = testkit::read_fixture("nasa-1977/table-4.json");
    let document = Document::parse(&text).expect("a good document");
    bencher.bench(|| axescal::run(document.clone(), &Options::default()).expect("a result"));
}
