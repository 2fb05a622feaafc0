//! Steps and spikes: false alarms on clean series, the share found against their size, and sizes within their
//! intervals.

use estimate::events::{Search, Shape, fill, threshold};
use estimate::periodogram::periodogram;
use estimate::whittle;
use noise::Stream;

use crate::made::made;

const STEP_S: f64 = 60.0;
const ROWS: usize = 4320;
const TRIALS: u64 = 30;

/// Name, amplitude and exponent of flicker, and rms of white noise.
struct Kind(&'static str, (f64, f64), f64);

const KINDS: [Kind; 3] = [
    Kind("white", (0.0, 1.0), 0.1),
    Kind("flicker, α = 1", (1e-3, 1.0), 0.02),
    Kind("flicker, α = 1.5", (2e-5, 1.5), 0.02),
];

impl Kind {
    fn series(&self, seed: u64) -> Vec<f64> {
        made(&mut Stream::new(seed, self.0), (ROWS, STEP_S), self.1, self.2)
    }
}

/// The filter of a series, with the noise fitted to the series itself.
fn filter(series: &[f64]) -> Search {
    let fit = whittle::fit(&[periodogram(series, STEP_S).expect("a periodogram")]).expect("a fit");
    let density = |frequency: f64| fit.density(0, STEP_S, frequency).value;
    Search::new(series, STEP_S, &density).expect("a filter")
}

/// Whether a shape at any row exceeds the threshold.
fn alarm(search: &Search) -> bool {
    let least = threshold(2 * ROWS, 0.01);
    [Shape::Step, Shape::Spike]
        .into_iter()
        .any(|shape| (0..search.rows()).any(|row| search.ratio(shape, row).abs() >= least))
}

#[test]
fn clean_series_raise_no_alarm() {
    let count = testkit::campaigns(100);
    for kind in &KINDS {
        let alarms = (0..count).filter(|seed| alarm(&filter(&kind.series(*seed)))).count();
        assert!(alarms as f64 <= 0.02 * count as f64, "{}: {alarms} of {count}", kind.0);
    }
}

#[test]
fn power_and_size() {
    for kind in &KINDS {
        for shape in [Shape::Step, Shape::Spike] {
            // What one standard uncertainty is at that row.
            let unit = filter(&kind.series(999)).size(shape, 1700).1;
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
                    let search = filter(&series);
                    let near = |row: &usize| search.ratio(shape, *row).abs() >= least;
                    let seen = (1698..=1702).any(|row| near(&row));
                    caught += usize::from(seen);
                    if seen && strength == 4.0 {
                        let (found, std) = search.size(shape, 1700);
                        inside += usize::from((found - size).abs() <= 1.96 * std);
                        counted += 1;
                    }
                }
                shares.push(caught as f64 / TRIALS as f64);
            }
            assert!(shares[0] < 0.15 && shares[3] > 0.9, "{} {shape:?}: {shares:?}", kind.0);
            assert!(inside as f64 >= 0.85 * counted as f64, "{} {shape:?}: {inside} of {counted}", kind.0);
        }
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
            alarms += usize::from(alarm(&Search::new(&filled, STEP_S, &density).expect("a filter")));
        }
        assert!(likely < straight && alarms <= 2, "{}: {likely} {straight} {alarms}", kind.0);
    }
}

/// What is far from a gap says nothing of it.
#[test]
fn gaps_far_apart_are_filled_each_by_itself() {
    let mut stream = Stream::new(3, "far apart");
    let rows = 30_000;
    let series: Vec<f64> = (0..rows).map(|_| stream.normal()).collect();
    let density = |frequency: f64| 2.0 * STEP_S + 1e-3 / frequency;
    let gaps = [5_000..5_040, 25_000..25_003];
    let missing = |gaps: &[std::ops::Range<usize>]| -> Vec<bool> {
        (0..rows).map(|row| gaps.iter().any(|gap| gap.contains(&row))).collect()
    };
    let both = fill(&series, &missing(&gaps), STEP_S, &density).expect("filled");
    for gap in gaps {
        let alone = fill(&series, &missing(std::slice::from_ref(&gap)), STEP_S, &density).expect("filled");
        assert_eq!(both[gap.clone()], alone[gap.clone()]);
        assert!(gap.clone().all(|row| both[row] != series[row]), "{gap:?} is as it was");
    }
}

#[test]
fn what_has_no_answer_is_refused() {
    assert!(Search::new(&[1.0; 10], 1.0, &|_| 1.0).is_err());
    assert!(Search::new(&[f64::NAN; 100], 1.0, &|_| 1.0).is_err());
    assert!(Search::new(&[1.0; 100], 1.0, &|_| 0.0).is_err());
}
