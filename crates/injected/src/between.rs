//! What was recorded at moments, as a signal that is known at every instant.

use concealed::signal::Signal;
use std::sync::Arc;

/// The cubic through each two neighbours whose slopes are those of their neighbours (Catmull and Rom), for
/// uneven times too; before the first reading and after the last one it is held.
pub fn signal(times: &[f64], values: &[f64]) -> Signal {
    let (times, values) = (times.to_vec(), values.to_vec());
    Arc::new(move |t| {
        let after = times.partition_point(|own| *own <= t);
        match (after.checked_sub(1), times.get(after)) {
            (None, _) => values.first().copied().unwrap_or(0.0),
            (Some(before), None) => values[before],
            (Some(before), Some(_)) => cubic(&times, &values, before, t),
        }
    })
}

fn cubic(times: &[f64], values: &[f64], before: usize, t: f64) -> f64 {
    let slope = |row: usize| {
        let (from, to) = (row.saturating_sub(1), (row + 1).min(times.len() - 1));
        (values[to] - values[from]) / (times[to] - times[from])
    };
    let step = times[before + 1] - times[before];
    let x = (t - times[before]) / step;
    let (y, z) = (values[before], values[before + 1]);
    let (left, right) = (step * slope(before), step * slope(before + 1));
    let (square, cube) = (x * x, x * x * x);
    y * (2.0 * cube - 3.0 * square + 1.0)
        + left * (cube - 2.0 * square + x)
        + z * (3.0 * square - 2.0 * cube)
        + right * (cube - square)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_come_back_and_a_line_stays_one() {
        let times = [0.0, 1.0, 2.5, 3.0, 7.0];
        let line: Vec<f64> = times.iter().map(|t| 2.0 - 0.5 * t).collect();
        let signal = signal(&times, &line);
        for t in [0.0, 0.3, 1.0, 2.0, 2.9, 5.5, 7.0] {
            assert!((signal(t) - (2.0 - 0.5 * t)).abs() < 1e-12, "{t}");
        }
        assert_eq!((signal(-3.0), signal(9.0)), (2.0, -1.5));
    }

    #[test]
    fn a_wave_between_its_samples() {
        let times: Vec<f64> = (0..200).map(f64::from).collect();
        let wave = |t: f64| (t / 10.0).sin();
        let signal = signal(&times, &times.iter().map(|t| wave(*t)).collect::<Vec<_>>());
        for t in [3.5, 40.2, 150.9] {
            assert!((signal(t) - wave(t)).abs() < 2e-4, "{t}: {}", signal(t) - wave(t));
        }
    }
}
