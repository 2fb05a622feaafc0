//! Steps of days of one second at a busy site: flicker noise, traffic by day, bursts of disturbance, passing
//! vehicles, and steps of 5 to 20 times the noise around them, 2 to 600 rows apart. How many are found, and
//! how many are told that are none. FLUXCAL_DAYS sets how many days, FLUXCAL_FIRST the seed of the first.

use std::f64::consts::TAU;

use common::{EventKind, KeptOutEvent};
use noise::{Stream, power_law};

use crate::pair_in_time::{ETA, both, document};

const ROWS: usize = 86_400;
const MAIN_NT: [f64; 3] = [20_800.0, 700.0, 47_500.0];
const DAILY_NT: [f64; 3] = [22.0, 28.0, 12.0];
/// The noise around a row is the rms about their mean of so many readings on either side.
const AROUND: usize = 64;
/// A step that is told so many rows from one is that step: rows between are disturbed.
const NEAR: usize = 10;

/// A number between 0 and 1, all alike.
fn uniform(stream: &mut Stream) -> f64 {
    stream.normal().atan2(stream.normal()).rem_euclid(TAU) / TAU
}

/// A number between two ends, its logarithm uniform.
fn between(stream: &mut Stream, low: f64, high: f64) -> f64 {
    low * (high / low).powf(uniform(stream))
}

/// About the mean.
fn rms(values: &[f64]) -> f64 {
    estimate::stats::rms(&paired::residual::centred(values))
}

/// A step of the test instrument.
struct Step {
    row: usize,
    axis: usize,
    size: f64,
    /// Its size over the noise around it.
    over_noise: f64,
}

struct Day {
    reference: [Vec<f64>; 3],
    test: [Vec<f64>; 3],
    steps: Vec<Step>,
}

impl Day {
    fn new(seed: u64) -> Self {
        let mut stream = Stream::new(seed, "day");
        let field: [Vec<f64>; 3] = std::array::from_fn(|axis| {
            let daily = |row: usize| DAILY_NT[axis] * (TAU * row as f64 / ROWS as f64 + axis as f64).sin();
            let natural = power_law(&mut stream, ROWS, 1.0, 2e-4, 1.6);
            natural.iter().enumerate().map(|(row, b)| MAIN_NT[axis] + daily(row) + b).collect()
        });
        let mut noise = noise(&mut stream);
        let steps = steps(&mut stream, &noise);
        for step in &steps {
            noise[step.axis][step.row..].iter_mut().for_each(|value| *value += step.size);
        }
        let test = std::array::from_fn(|j| {
            let turned = |row: usize| (0..3).map(|i| field[i][row] * ETA[i][j]).sum::<f64>();
            (0..ROWS).map(|row| turned(row) + noise[j][row]).collect()
        });
        let reference = field.map(|column| column.into_iter().map(|b| b + 0.002 * stream.normal()).collect());
        Self { reference, test, steps }
    }
}

/// What the test instrument reads beside the field.
fn noise(stream: &mut Stream) -> [Vec<f64>; 3] {
    let white = between(stream, 0.01, 0.05);
    let flicker = between(stream, 2e-5, 1e-3);
    let busy = 4.0 * uniform(stream);
    // From six to eighteen o'clock.
    let by_day = |row: usize| (TAU * (row as f64 / ROWS as f64 - 0.25)).sin().max(0.0).powi(2);
    let mut noise: [Vec<f64>; 3] = std::array::from_fn(|_| {
        let mut slow = 0.0;
        let own = power_law(stream, ROWS, 1.0, flicker, 1.0);
        own.into_iter()
            .enumerate()
            .map(|(row, own)| {
                // Traffic: half of it at once, half with a memory of twenty seconds.
                slow += -slow / 20.0 + stream.normal() * (2.0_f64 / 20.0).sqrt();
                own + white * (stream.normal() + busy * by_day(row) * (stream.normal() + slow))
            })
            .collect()
    });
    let bursts = (8.0 * uniform(stream)) as usize;
    for _ in 0..bursts {
        let (first, length) = (uniform(stream) * ROWS as f64, between(stream, 20.0, 900.0));
        let size = white * between(stream, 5.0, 50.0);
        let parts = [uniform(stream), uniform(stream), uniform(stream)];
        let rows = first as usize..((first + length) as usize).min(ROWS);
        for (column, part) in noise.iter_mut().zip(parts) {
            for (value, row) in column[rows.clone()].iter_mut().zip(rows.clone()) {
                let along = (0.5 * TAU * (row as f64 - first) / length).sin().max(0.0);
                *value += along * size * part * stream.normal();
            }
        }
    }
    let passes = (15.0 * uniform(stream)) as usize;
    for _ in 0..passes {
        let middle = ROWS as f64 * (0.25 + 0.5 * uniform(stream));
        let (half_s, size) = (between(stream, 3.0, 60.0), between(stream, 0.2, 5.0));
        let parts = [stream.normal(), stream.normal(), stream.normal()];
        // What a dipole that drives by leaves: even along one axis, odd along the others.
        for (axis, (column, part)) in noise.iter_mut().zip(parts).enumerate() {
            for (row, value) in column.iter_mut().enumerate() {
                let u = (row as f64 - middle) / half_s;
                let form = [2.0 - u * u, u, 1.0][axis];
                *value += size * part * form * (1.0 + u * u).powf(-2.5);
            }
        }
    }
    noise
}

/// Groups of steps, 2 to 600 rows from each other.
fn steps(stream: &mut Stream, noise: &[Vec<f64>; 3]) -> Vec<Step> {
    let mut steps = Vec::new();
    let groups = (3.0 * uniform(stream)) as usize;
    for _ in 0..groups {
        let mut row = 1000 + (uniform(stream) * (ROWS - 6000) as f64) as usize;
        for _ in 0..1 + (4.0 * uniform(stream)) as usize {
            let axis = (3.0 * uniform(stream)) as usize % 3;
            let around = &noise[axis][row - AROUND..row + AROUND];
            let rms = rms(around);
            let over_noise = between(stream, 5.0, 20.0);
            let size = over_noise * rms * stream.normal().signum();
            steps.push(Step { row, axis, size, over_noise });
            row += between(stream, 2.0, 600.0) as usize;
        }
    }
    steps
}

/// What came of some days.
#[derive(Debug, Default)]
struct Score {
    days: usize,
    steps: usize,
    found: usize,
    /// Of those that are not found, how many are told as one disturbance with another.
    together: usize,
    failed: Vec<String>,
    /// Axes of which more is left than levels alone leave.
    worse: Vec<String>,
    missed: Vec<String>,
    false_steps: Vec<String>,
}

impl Score {
    fn add(&mut self, seed: u64) {
        self.days += 1;
        let day = Day::new(seed);
        let time: Vec<f64> = (0..ROWS).map(|row| row as f64).collect();
        let recording = both("day", &time, [&day.reference, &day.test], &(0..ROWS));
        let run = diffmag::run(document(vec![recording]), &diffmag::Options::default());
        let fit = match run {
            Ok(document) => document.calibration.and_then(|c| c.differential?.fit).expect("a fit"),
            Err(error) => return self.failed.push(format!("{seed}: {error}")),
        };
        for (axis, of) in fit.axes.iter() {
            let k = axis.index();
            let apart: Vec<f64> = day.test[k].iter().zip(&day.reference[k]).map(|(t, r)| t - r).collect();
            let (left, levels) = (of.left_nt(), rms(&apart));
            if left > levels {
                self.worse.push(format!("{seed} {axis}: {left} nT; levels alone leave {levels} nT"));
            }
        }
        let told: Vec<&KeptOutEvent> =
            fit.kept_out.events.iter().filter(|event| event.kind == EventKind::Step).collect();
        let all: Vec<_> = fit.kept_out.events.iter().map(|e| (e.kind, e.axis, e.rows)).collect();
        // A step across disturbed rows is told at the first of them.
        let last = |event: &KeptOutEvent| {
            let from_there = fit.kept_out.events.iter().filter(|other| other.rows[0] == event.rows[0]);
            from_there.map(|other| other.rows[1]).max().unwrap_or(event.rows[1])
        };
        let near =
            |row: usize, event: &KeptOutEvent| row + NEAR >= event.rows[0] && row <= last(event) + NEAR;
        self.steps += day.steps.len();
        for step in &day.steps {
            let same = |event: &&&KeptOutEvent| event.axis.index() == step.axis && near(step.row, event);
            let others = || day.steps.iter().filter(|other| other.row != step.row);
            let one = |event: &KeptOutEvent| {
                let inside = |row: usize| row + NEAR >= event.rows[0] && row <= event.rows[1] + NEAR;
                inside(step.row) && others().any(|other| inside(other.row))
            };
            if told.iter().any(|event| same(&event)) {
                self.found += 1;
            } else if fit.kept_out.events.iter().any(one) {
                self.together += 1;
            } else {
                let beside: Vec<_> = all.iter().filter(|of| of.2[0].abs_diff(step.row) < 300).collect();
                let Step { row, axis, size, over_noise } = step;
                self.missed.push(format!(
                    "{seed}: {size:.2} nT, {over_noise:.1} times the noise, of axis {axis} at row {row} beside {beside:?}"
                ));
            }
        }
        for event in told {
            if !day.steps.iter().any(|step| near(step.row, event)) {
                let close: Vec<_> = all.iter().filter(|of| of.2[0].abs_diff(event.rows[0]) < 300).collect();
                self.false_steps.push(format!("{seed}: {event:?} beside {close:?}"));
            }
        }
    }
}

#[test]
fn steps_of_disturbed_days_are_found_and_no_others() {
    let mut score = Score::default();
    let first = testkit::number("FLUXCAL_FIRST").unwrap_or(1);
    for seed in first..first + testkit::number("FLUXCAL_DAYS").unwrap_or(1) {
        score.add(seed);
    }
    println!("{score:#?}");
    assert!(score.failed.is_empty() && score.worse.is_empty(), "{score:?}");
    assert!(score.false_steps.len() <= score.days.div_ceil(100), "{score:?}");
    let told = score.found + score.together;
    assert!(testkit::agrees(told, score.steps, [0.95, 1.0], 1), "{score:?}");
}
