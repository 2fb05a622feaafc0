//! Steps and spikes: false alarms on clean series, the share found against their size, and sizes within their intervals.

use estimate::events::{Event, Shape, fill, find, threshold};
use estimate::periodogram::periodogram;
use estimate::whittle;
use noise::Stream;

const STEP_S: f64 = 60.0;
const ROWS: usize = 4320;
const TRIALS: u64 = 30;

struct Kind {
    name: &'static str,
    white: f64,
    amplitude: f64,
    exponent: f64,
}

const KINDS: [Kind; 3] = [
    Kind { name: "white", white: 0.1, amplitude: 0.0, exponent: 1.0 },
    Kind { name: "flicker, α = 1", white: 0.02, amplitude: 1e-3, exponent: 1.0 },
    Kind { name: "flicker, α = 1.5", white: 0.02, amplitude: 2e-5, exponent: 1.5 },
];

impl Kind {
    /// A series cut out of one four times as long.
    fn series(&self, seed: u64) -> Vec<f64> {
        let mut stream = Stream::new(seed, self.name);
        let flicker = if self.amplitude > 0.0 {
            noise::power_law(&mut stream, 4 * ROWS, STEP_S, self.amplitude, self.exponent)
        } else {
            vec![0.0; 4 * ROWS]
        };
        (0..ROWS).map(|row| flicker[row + ROWS] + self.white * stream.normal()).collect()
    }
}

/// With the noise fitted to the series itself.
fn found(series: &[f64]) -> Vec<Event> {
    found_under(series, series)
}

fn found_under(noise: &[f64], series: &[f64]) -> Vec<Event> {
    let fit = whittle::fit(&[periodogram(noise, STEP_S).expect("a periodogram")]).expect("a fit");
    let density = |frequency: f64| fit.density(0, STEP_S, frequency).value;
    find(series, STEP_S, &density, 0.01, 50).expect("searched")
}

#[test]
fn clean_series_raise_no_alarm() {
    let count = testkit::campaigns(100);
    for kind in &KINDS {
        let alarms = (0..count).filter(|seed| !found(&kind.series(*seed)).is_empty()).count();
        println!("{}: {alarms} of {count} clean series with an alarm", kind.name);
        assert!(alarms as f64 <= 0.02 * count as f64, "{}: {alarms} of {count}", kind.name);
    }
}

#[test]
fn power_and_size() {
    for kind in &KINDS {
        for shape in [Shape::Step, Shape::Spike] {
            // What one standard uncertainty is at that row.
            let clean = kind.series(999);
            let fit = whittle::fit(&[periodogram(&clean, STEP_S).expect("a periodogram")]).expect("a fit");
            let density = |frequency: f64| fit.density(0, STEP_S, frequency).value;
            let search = estimate::events::Search::new(&clean, STEP_S, &density).expect("a filter");
            let unit = search.size(shape, 1700).1;
            let least = threshold(ROWS, 0.01);
            let mut shares = Vec::new();
            let (mut inside, mut counted) = (0, 0);
            for strength in [-2.0, 0.0, 2.0, 4.0] {
                let size = (least + strength) * unit;
                let mut caught = 0;
                for seed in 0..TRIALS {
                    let mut series = kind.series(5000 + seed);
                    let to = if shape == Shape::Step { ROWS } else { 1701 };
                    series[1700..to].iter_mut().for_each(|value| *value += size);
                    let event =
                        found(&series).into_iter().find(|e| e.shape == shape && e.row.abs_diff(1700) <= 2);
                    caught += usize::from(event.is_some());
                    if let Some(event) = event.filter(|_| strength == 4.0) {
                        inside += usize::from((event.size - size).abs() <= 1.96 * event.std);
                        counted += 1;
                    }
                }
                shares.push(caught as f64 / TRIALS as f64);
            }
            println!(
                "{} {shape:?} (1σ = {unit:.4}, threshold {least:.2}σ): found at −2, 0, +2, +4σ about it: {shares:.2?}; \
                 {inside} of {counted} sizes within 95 %",
                kind.name
            );
            assert!(shares[0] < 0.15 && shares[3] > 0.9, "{}: {shares:?}", kind.name);
            assert!(inside as f64 >= 0.85 * counted as f64);
        }
    }
}

#[test]
fn several_events_come_out_together() {
    let kind = &KINDS[1];
    let clean = kind.series(3);
    let mut series = clean.clone();
    series[1000..].iter_mut().for_each(|value| *value += 2.0);
    series[3000..].iter_mut().for_each(|value| *value -= 5.0);
    series[2000] += 900.0;
    series[2500] -= 40.0;
    let mut events = found_under(&clean, &series);
    events.sort_by_key(|event| event.row);
    let rows: Vec<(Shape, usize)> = events.iter().map(|event| (event.shape, event.row)).collect();
    use Shape::{Spike, Step};
    assert_eq!(rows, [(Step, 1000), (Spike, 2000), (Spike, 2500), (Step, 3000)]);
    for (event, size) in events.iter().zip([2.0, 900.0, -40.0, -5.0]) {
        assert!((event.size - size).abs() < 4.0 * event.std, "{event:?}");
    }
}

/// A gap on a straight line between its two noisy neighbours looks like a bump; filled it does not.
#[test]
fn gaps_are_filled_with_what_is_likely() {
    for kind in &KINDS {
        let (mut straight, mut likely, mut alarms) = (0.0, 0.0, 0);
        for seed in 0..40 {
            let truth = kind.series(9000 + seed);
            let fit = whittle::fit(&[periodogram(&truth, STEP_S).expect("a periodogram")]).expect("a fit");
            let density = |frequency: f64| fit.density(0, STEP_S, frequency).value;
            let missing: Vec<bool> =
                (0..ROWS).map(|row| (700..760).contains(&row) || row % 97 == 5).collect();
            let mut series = truth.clone();
            let line = |from: usize, to: usize, row: usize| {
                truth[from] + (row - from) as f64 / (to - from) as f64 * (truth[to] - truth[from])
            };
            (0..ROWS).filter(|row| row % 97 == 5).for_each(|row| series[row] = line(row - 1, row + 1, row));
            (700..760).for_each(|row| series[row] = line(699, 760, row));
            let filled = fill(&series, &missing, STEP_S, &density).expect("filled");
            assert!((0..ROWS).all(|row| missing[row] || (filled[row] - truth[row]).abs() < 1e-9));
            let off = |of: &[f64]| (0..ROWS).map(|row| (of[row] - truth[row]).powi(2)).sum::<f64>();
            straight += off(&series);
            likely += off(&filled);
            alarms += usize::from(!find(&filled, STEP_S, &density, 0.01, 9).expect("searched").is_empty());
        }
        println!(
            "{}: mean square error {:.2} of the straight lines', {alarms} alarms",
            kind.name,
            likely / straight
        );
        assert!(likely < straight && alarms <= 2);
    }
}

#[test]
fn what_has_no_answer_is_refused() {
    assert!(find(&[1.0; 10], 1.0, &|_| 1.0, 0.01, 9).is_err());
    assert!(find(&[f64::NAN; 100], 1.0, &|_| 1.0, 0.01, 9).is_err());
    assert!(find(&[1.0; 100], 1.0, &|_| 0.0, 0.01, 9).is_err());
}
