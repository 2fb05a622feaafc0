//! Speed, as ratios against a peer in the same run.
//!
//! `noise` is a day at 100 Hz of one sensor, 8.64 million samples, the document in memory; its peer is one
//! Fourier transform of the same samples. `rest` is all that the MAGSAT campaign holds for sensorcal but its
//! noise recordings; its peer predicts the same recordings once by the chain.

use common::{Axis, Column, Conditions, Document, Instrument, Recording, procedure};
use divan::{Bencher, black_box};
use estimate::spectrum::welch;
use noise::Stream;
use physics::{Basic, Context, References, Unit};
use std::sync::LazyLock;

const ROWS: usize = 8_640_000;

fn main() {
    divan::main();
}

static DAY: LazyLock<Document> = LazyLock::new(|| {
    let mut stream = Stream::new(1, "day");
    let flicker = noise::power_law(&mut stream, ROWS, 0.01, 1e-4, 1.0);
    let readings: Column = flicker.iter().map(|field| field + 0.02 * stream.normal()).collect();
    let time: Column = (0..ROWS).map(|row| row as f64 * 0.01).collect();
    let columns = [("time_s", time), ("sensor_x_nt", readings)];
    let recording = Recording {
        id: "day".into(),
        procedure: procedure::SENSOR_NOISE.into(),
        conditions: Conditions { sensor: Some(Axis::X), ..Conditions::default() },
        columns: columns.map(|(name, column)| (name.to_string(), column)).into_iter().collect(),
        ..Recording::default()
    };
    Document {
        fluxcal: 1,
        instrument: Some(Instrument::default()),
        recordings: vec![recording],
        ..Document::default()
    }
});

static REST: LazyLock<Document> = LazyLock::new(|| {
    let text = std::fs::read_to_string(testkit::fixture("plans/magsat.json")).expect("the plan");
    let plan = simulate::Plan::parse(&text).expect("a plan");
    let document = simulate::campaign(&plan).expect("simulated").document;
    let mut document = coilcal::run(document, &coilcal::Options::default()).expect("the coils");
    let kept = [
        procedure::SENSOR_SENSITIVITY,
        procedure::SENSOR_OFFSET_REVERSAL,
        procedure::TEMPERATURE_RUN,
        procedure::CROSS_FIELD,
        procedure::OFFSET_DRIFT,
    ];
    document.recordings.retain(|recording| kept.contains(&recording.procedure.as_str()));
    document
});

#[divan::bench(sample_count = 5)]
fn noise(bencher: Bencher) {
    let options = sensorcal::Options::default();
    bencher
        .with_inputs(|| DAY.clone())
        .bench_local_values(|document| sensorcal::run(black_box(document), &options).expect("noise"));
}

#[divan::bench(sample_count = 5)]
fn noise_peer_one_transform(bencher: Bencher) {
    let samples = DAY.recordings[0].axis_column("sensor", Axis::X, "nt").expect("readings");
    bencher.bench_local(|| welch(black_box(samples), 0.01, ROWS).expect("a spectrum"));
}

#[divan::bench(sample_count = 10)]
fn rest(bencher: Bencher) {
    let options = sensorcal::Options::default();
    bencher
        .with_inputs(|| REST.clone())
        .bench_local_values(|document| sensorcal::run(black_box(document), &options).expect("calibrated"));
}

#[divan::bench(sample_count = 10)]
fn rest_peer_one_prediction(bencher: Bencher) {
    let basic = Basic::of(&REST, Unit::Volt);
    let references = References::of(&REST);
    bencher.bench_local(|| {
        for recording in &REST.recordings {
            let context = Context::new(black_box(&REST), recording, references).expect("a context");
            black_box(physics::predict(&basic, &[], &context).expect("predicted"));
        }
    });
}
