//! Whether times are even but for rows that were never written, and a series made even where they are not.

use crate::cadence::{self, Cadence, rounding};

/// What the last digit rounds, in its units: a half, and what a line through rounded times is off.
const ROUNDED: f64 = 0.75;
/// A share of a step within which a time is at its place wherever its moment matters.
pub const EXACT: f64 = 1e-3;
/// The same where it does not, as for the spectrum of noise, which interpolation would lower.
pub const NEAR: f64 = 0.25;
/// A longer interval, in usual ones, is a gap.
pub const GAP: f64 = 3.0;

/// Rising times on even places, of which some may be left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Places {
    /// The place of each row, counted from the first.
    pub places: Vec<usize>,
    /// Time of the first place, s.
    pub start_s: f64,
    /// From one place to the next, s.
    pub step_s: f64,
    /// How far a time is from its place at most, s.
    pub scatter_s: f64,
    /// What the times' last digit and double precision round, s.
    pub rounded_s: f64,
    /// The usual interval, s.
    pub usual_s: f64,
}

impl Places {
    /// Of times that rise, all there; None for others, and for fewer than two.
    pub fn of(time: &[f64]) -> Option<Self> {
        let rises = |pair: &[f64]| pair[1] > pair[0] && (pair[1] - pair[0]).is_finite();
        if time.len() < 2 || !time.windows(2).all(rises) {
            return None;
        }
        let cadence = Cadence::of(time);
        let only_s = time[1] - time[0];
        let (fine_s, usual_s) = cadence.as_ref().map_or((only_s, only_s), |of| (of.step_s, of.usual_s));
        let digit_s = cadence.and_then(|cadence| cadence.digit_s).unwrap_or(0.0);
        let places: Vec<usize> = cadence::places(time, fine_s).map(|place| place as usize).collect();
        let last = time.len() - 1;
        let scatter = |start_s: f64, step_s: f64| {
            let off = places.iter().zip(time).map(|(place, t)| (t - start_s - *place as f64 * step_s).abs());
            off.fold(0.0, f64::max)
        };
        let (mut start_s, mut step_s) = (time[0], (time[last] - time[0]) / places[last] as f64);
        if scatter(start_s, step_s) > EXACT * fine_s {
            (start_s, step_s) = line(&places, time);
        }
        let scatter_s = scatter(start_s, step_s);
        let rounded_s = (ROUNDED * digit_s).max(rounding(time));
        Some(Self { places, start_s, step_s, scatter_s, rounded_s, usual_s })
    }

    /// Whether each time lies within this share of a step of its place, or within what is rounded.
    pub fn even(&self, share: f64) -> bool {
        self.scatter_s <= (share * self.step_s).max(self.rounded_s)
    }

    /// How many places there are from the first time to the last.
    pub fn count(&self) -> usize {
        self.places.last().map_or(0, |last| last + 1)
    }

    /// A column at its places; NaN where no row is.
    pub fn put(&self, column: &[f64]) -> Vec<f64> {
        let mut even = vec![f64::NAN; self.count()];
        self.places.iter().zip(column).for_each(|(place, value)| even[*place] = *value);
        even
    }

    /// An even step for times that are not: the mean interval between gaps.
    pub fn mean_step_s(&self, time: &[f64]) -> f64 {
        let intervals = time.windows(2).map(|pair| pair[1] - pair[0]);
        let (sum, count) = intervals
            .filter(|interval| *interval <= GAP * self.usual_s)
            .fold((0.0, 0.0), |(sum, count), interval| (sum + interval, count + 1.0));
        sum / count
    }

    /// A column of uneven times at even ones, `step_s` apart from the first on, by cubic pieces; NaN within gaps.
    pub fn interpolated(&self, time: &[f64], column: &[f64], step_s: f64) -> Vec<f64> {
        let rows = ((time[time.len() - 1] - time[0]) / step_s + 1e-6).floor() as usize + 1;
        let at: Vec<f64> = (0..rows).map(|row| time[0] + row as f64 * step_s).collect();
        interpolated(time, column, &at, GAP * self.usual_s)
    }
}

/// A column at even times.
#[derive(Clone, Debug)]
pub struct Evened {
    /// From one to the next, s.
    pub step_s: f64,
    /// NaN where a reading is missing.
    pub column: Vec<f64>,
    /// How far the times are from even ones, s; None where they are even and nothing was interpolated.
    pub uneven_s: Option<f64>,
}

/// A column as a spectrum needs it: at its places where times are near them, else interpolated. None for
/// times that do not rise, or with so many gaps that fewer than half of the places are rows.
pub fn evened(time: &[f64], column: &[f64]) -> Option<Evened> {
    if let Some(step_s) = step_of_all(time) {
        return Some(Evened { step_s, column: column.to_vec(), uneven_s: None });
    }
    let places = Places::of(time).filter(|places| places.count() < 2 * time.len())?;
    if places.even(NEAR) {
        return Some(Evened { step_s: places.step_s, column: places.put(column), uneven_s: None });
    }
    let step_s = places.mean_step_s(time);
    let column = places.interpolated(time, column, step_s);
    Some(Evened { step_s, column, uneven_s: Some(places.scatter_s) })
}

/// The step of times that are all at their places; else None. Ten times as quick as [`Places`].
fn step_of_all(time: &[f64]) -> Option<f64> {
    let (first, last) = (*time.first()?, *time.last()?);
    let step_s = (last - first) / (time.len() - 1) as f64;
    let at_place = |(place, t): (usize, &f64)| (t - first - place as f64 * step_s).abs() <= EXACT * step_s;
    (step_s > 0.0 && time.iter().enumerate().all(at_place)).then_some(step_s)
}

/// What is known, read at other times by cubic pieces; NaN within longer intervals than `gap_s`.
pub fn interpolated(time: &[f64], column: &[f64], at: &[f64], gap_s: f64) -> Vec<f64> {
    let known: Vec<(f64, f64)> =
        time.iter().copied().zip(column.iter().copied()).filter(|(_, value)| value.is_finite()).collect();
    let (time, values): (Vec<f64>, Vec<f64>) = known.into_iter().unzip();
    if time.is_empty() {
        return vec![f64::NAN; at.len()];
    }
    let mut read = pchip(&time, &values, at);
    for (value, t) in read.iter_mut().zip(at) {
        let after = time.partition_point(|known| known < t);
        if after > 0 && after < time.len() && time[after] - time[after - 1] > gap_s {
            *value = f64::NAN;
        }
    }
    read
}

/// Readings at rising times, read at other times within them: cubic pieces whose slopes are the weighted
/// harmonic means of those of the neighbouring chords, zero where these differ in sign, and at the ends of
/// three points, held to the chord's sign. Outside the times NaN.
///
/// Source: F. N. Fritsch and J. Butland, A method for constructing local monotone piecewise cubic
/// interpolants, SIAM J. Sci. Stat. Comput. 5 (1984) 300–304; as SciPy's `PchipInterpolator`.
pub fn pchip(time: &[f64], values: &[f64], at: &[f64]) -> Vec<f64> {
    let last = time.len() - 1;
    if last == 0 {
        return at.iter().map(|t| if *t == time[0] { values[0] } else { f64::NAN }).collect();
    }
    let width: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let chord: Vec<f64> = values.windows(2).zip(&width).map(|(pair, h)| (pair[1] - pair[0]) / h).collect();
    let slope: Vec<f64> = (0..=last)
        .map(|k| match k {
            _ if last == 1 => chord[0],
            0 => end_slope([width[0], width[1]], [chord[0], chord[1]]),
            _ if k == last => end_slope([width[k - 1], width[k - 2]], [chord[k - 1], chord[k - 2]]),
            _ if chord[k - 1] * chord[k] <= 0.0 => 0.0,
            _ => {
                let (before, after) = (2.0 * width[k] + width[k - 1], width[k] + 2.0 * width[k - 1]);
                (before + after) / (before / chord[k - 1] + after / chord[k])
            }
        })
        .collect();
    at.iter()
        .map(|t| {
            if !(time[0]..=time[last]).contains(t) {
                return f64::NAN;
            }
            let k = (time.partition_point(|known| known <= t).max(1) - 1).min(last - 1);
            let s = (t - time[k]) / width[k];
            let (rest, bend) = (1.0 - s, s * (1.0 - s));
            let ends = values[k] * rest * rest * (1.0 + 2.0 * s) + values[k + 1] * s * s * (3.0 - 2.0 * s);
            ends + width[k] * bend * (slope[k] * rest - slope[k + 1] * s)
        })
        .collect()
}

/// The slope at an end, from the two intervals next to it, the outer one first.
fn end_slope(width: [f64; 2], chord: [f64; 2]) -> f64 {
    let slope = ((2.0 * width[0] + width[1]) * chord[0] - width[0] * chord[1]) / (width[0] + width[1]);
    if slope * chord[0] <= 0.0 {
        0.0
    } else if chord[0] * chord[1] <= 0.0 && slope.abs() > 3.0 * chord[0].abs() {
        3.0 * chord[0]
    } else {
        slope
    }
}

/// The line t = a + b k of least squares.
fn line(places: &[usize], time: &[f64]) -> (f64, f64) {
    let count = places.len() as f64;
    let (k, t) = (places.iter().sum::<usize>() as f64 / count, time.iter().sum::<f64>() / count);
    let (mut above, mut below) = (0.0, 0.0);
    for (place, time) in places.iter().zip(time) {
        let from_middle = *place as f64 - k;
        above += from_middle * (time - t);
        below += from_middle.powi(2);
    }
    let step = above / below;
    (t - step * k, step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_of_times_with_gaps() {
        let of = |time: &[f64]| Places::of(time).expect("times");
        let found = of(&[0.0, 1.001, 2.0, 5.0, 6.0, 6.999, 8.0]);
        assert_eq!(found.places, [0, 1, 2, 5, 6, 7, 8]);
        assert!((found.step_s - 1.0).abs() < 1e-3 && found.even(NEAR));
        for none in [&[0.0, 1.0, 1.0][..], &[0.0, f64::NAN, 2.0], &[1.0]] {
            assert_eq!(Places::of(none), None);
        }
        // Three a second, printed to the millisecond, with a gap.
        let rows: Vec<usize> = (0..30_000).filter(|row| !(700..900).contains(row)).collect();
        let printed: Vec<f64> = rows.iter().map(|row| (*row as f64 / 3.0 * 1e3).round() / 1e3).collect();
        let found = of(&printed);
        assert!((found.step_s - 1.0 / 3.0).abs() < 1e-7 && found.even(EXACT) && found.places == rows);
    }

    #[test]
    fn a_straight_line_at_uneven_times_stays_one() {
        let time: Vec<f64> = (0..60).map(|k| f64::from(k) + 0.45 * f64::from(k * 7 % 5 - 2) / 2.0).collect();
        let places = Places::of(&time).expect("times");
        assert!(!places.even(NEAR));
        let step_s = places.mean_step_s(&time);
        let column: Vec<f64> = time.iter().map(|t| 5.0 + 0.5 * t).collect();
        for (row, value) in places.interpolated(&time, &column, step_s).iter().enumerate() {
            assert!((value - 5.0 - 0.5 * (time[0] + row as f64 * step_s)).abs() < 1e-9);
        }
    }
}
