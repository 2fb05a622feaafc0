//! A column read at other times: the one way in which series get other times here.

use common::series::even_places;
use estimate::resample::{pchip, resample};

/// Neighbours farther apart than this many usual steps have a gap between them, which is not bridged.
const GAP: f64 = 2.5;
/// Times as near as this, s, are one.
const SAME_S: f64 = 5e-7;

/// How values came to their new times.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Way {
    /// The times are the same.
    Same,
    /// Band-limited: windowed sinc, above the slower series' Nyquist frequency taken out.
    BandLimited,
    /// Cubic pieces that do not overshoot, for slow and for uneven series.
    Pieces,
}

/// The usual step of rising times: their median; None for fewer than two.
pub fn usual_step_s(time: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len().checked_sub(1)? / 2;
    let (_, step, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*step)
}

/// Values at rising `time`, read at rising times `at` that are `step_s` apart; NaN outside and in gaps. A series that is even but for
/// gaps and no slower than `at` is read band-limited, so that nothing folds; any other by cubic pieces, an uneven one that is faster than
/// `at` after it was made even.
pub fn read_at(time: &[f64], values: &[f64], at: &[f64], step_s: f64) -> (Vec<f64>, Way) {
    let there = || time.iter().zip(values).filter(|(_, value)| value.is_finite());
    let (time, values): (Vec<f64>, Vec<f64>) = there().map(|(time, value)| (*time, *value)).unzip();
    let Some(own_s) = usual_step_s(&time) else {
        let only =
            |t: &f64| time.first().filter(|own| (*own - t).abs() <= SAME_S).map_or(f64::NAN, |_| values[0]);
        return (at.iter().map(only).collect(), Way::Same);
    };
    // Of a faster series the rows at those times are not enough: what lies between would fold.
    if let Some(same) = same(&time, &values, at).filter(|_| own_s * 1.001 >= step_s) {
        return (same, Way::Same);
    }
    let read = |time: &[f64], values: &[f64]| {
        let read = pchip(time, values, at);
        let near = |(t, value): (&f64, f64)| if in_gap(time, *t, own_s) { f64::NAN } else { value };
        at.iter().zip(read).map(near).collect::<Vec<f64>>()
    };
    // A series as slow as the new times or slower holds nothing that could fold.
    if own_s > step_s * 1.001 {
        return (read(&time, &values), Way::Pieces);
    }
    let first = time[0];
    if let Some((even_s, places)) = even_places(&time) {
        let mut even = vec![f64::NAN; places.last().map_or(0, |last| last + 1)];
        places.iter().zip(&values).for_each(|(place, value)| even[*place] = *value);
        return (banded(&even, first, even_s, at, step_s), Way::BandLimited);
    }
    // Uneven and faster: made even by cubic pieces, gaps left open, and then as above.
    let count = ((time[time.len() - 1] - first) / own_s).floor() as usize + 1;
    let grid: Vec<f64> = (0..count).map(|place| first + place as f64 * own_s).collect();
    let made = pchip(&time, &values, &grid);
    let open = |(t, value): (&f64, f64)| if in_gap(&time, *t, own_s) { f64::NAN } else { value };
    let made: Vec<f64> = grid.iter().zip(made).map(open).collect();
    (banded(&made, first, own_s, at, step_s), Way::Pieces)
}

fn banded(even: &[f64], first: f64, even_s: f64, at: &[f64], step_s: f64) -> Vec<f64> {
    let last = even.len() as f64 - 1.0;
    let places: Vec<f64> = at.iter().map(|t| (t - first) / even_s).collect();
    let inside = |place: f64| (-1e-6..=last + 1e-6).contains(&place);
    let read = resample(&[even], &places, (step_s / even_s).max(1.0)).columns.swap_remove(0);
    read.into_iter().zip(places).map(|(value, place)| if inside(place) { value } else { f64::NAN }).collect()
}

/// Values where each time within the series is one of it.
fn same(time: &[f64], values: &[f64], at: &[f64]) -> Option<Vec<f64>> {
    let (first, last) = (time[0] - SAME_S, time[time.len() - 1] + SAME_S);
    at.iter()
        .map(|t| {
            if *t < first || *t > last {
                return Some(f64::NAN);
            }
            let place = time.partition_point(|own| own + SAME_S < *t);
            time.get(place).filter(|own| (*own - t).abs() <= SAME_S).map(|_| values[place])
        })
        .collect()
}

fn in_gap(time: &[f64], t: f64, usual_s: f64) -> bool {
    let after = time.partition_point(|own| *own < t);
    let Some(right) = time.get(after) else { return true };
    match after.checked_sub(1) {
        Some(before) => {
            right - time[before] > GAP * usual_s && right - t > SAME_S && t - time[before] > SAME_S
        }
        None => right - t > SAME_S,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(time: &[f64], period: f64) -> Vec<f64> {
        time.iter().map(|t| (std::f64::consts::TAU * t / period).sin()).collect()
    }

    #[test]
    fn a_sine_comes_back_and_none_folds() {
        let time: Vec<f64> = (0..2000).map(f64::from).collect();
        let at: Vec<f64> = (0..180).map(|k| 100.0 + 10.0 * f64::from(k)).collect();
        let (slow, way) = read_at(&time, &sine(&time, 200.0), &at, 10.0);
        assert_eq!(way, Way::BandLimited);
        let inner = 30..150;
        assert!(
            slow[inner.clone()]
                .iter()
                .zip(&sine(&at, 200.0)[inner.clone()])
                .all(|(a, b)| (a - b).abs() < 1e-3)
        );
        // A period of 3.3 s would fold to 33 s with rows taken as they are.
        let (fast, _) = read_at(&time, &sine(&time, 3.3), &at, 10.0);
        assert!(fast[inner].iter().all(|value| value.abs() < 1e-3));
    }

    #[test]
    fn slow_uneven_and_open_series() {
        let time: Vec<f64> = (0..60).map(|row| f64::from(row) * 60.0 + f64::from(row * 7 % 5)).collect();
        let at: Vec<f64> = (0..3000).map(f64::from).collect();
        let (read, way) = read_at(&time, &sine(&time, 3600.0), &at, 1.0);
        assert_eq!(way, Way::Pieces);
        assert!(read.iter().zip(sine(&at, 3600.0)).all(|(a, b)| (a - b).abs() < 5e-3));
        let with_gap = [0.0, 1.0, 2.0, 9.0, 10.0, 11.5];
        let (read, _) = read_at(&with_gap, &[1.0; 6], &[0.5, 2.0, 5.0, 9.5, 12.0], 0.5);
        assert!(read[0] == 1.0 && read[1] == 1.0 && read[2].is_nan() && read[3] == 1.0 && read[4].is_nan());
    }
}
