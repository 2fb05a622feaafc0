//! The times of a series by themselves: their step, whether they are even, and where they jump.
//!
//! Each row has a place, counted in steps; rows that were never written leave places empty. The phase of a
//! row is its time less that of its place. A clock that is off by a constant rate gives a straight line,
//! jitter scatters about it, and a jump moves it from one row on for good: by less than a step, as whole
//! steps are missing rows.

use crate::stats::{median, median_of};

/// Rows on either side of a jump that are held against each other.
const BESIDE: usize = 16;
/// Fewer rows than these do not show that a jump persists.
const PERSISTS: usize = 5;
/// A jump is larger than this share of a step …
const LEAST: f64 = 1e-3;
/// … and than so many units of the last digit of the times, of which rounding alone makes one;
const DIGITS: f64 = 1.5;
/// it is so many of its own uncertainties by the scatter of the rows beside it …
const SIGMAS: f64 = 6.0;
/// … and so many times what the same comparison gives nearby (1.4826 times the median of its size).
const ELSEWHERE: f64 = 8.0;
const NEIGHBOURHOOD: usize = 1024;
/// More jumps than one in so many rows are the times' own irregularity.
const RARE: usize = 8 * BESIDE;
/// Rows of a run that tells the step more finely than its digits: the longest that has no gap.
const FINE: [usize; 3] = [1024, 128, 16];
/// Intervals are alike where each is within this share of their mean.
const ALIKE: f64 = 1e-3;
/// A longer interval, in usual ones, is a gap.
const WHOLE: f64 = 1.5;
/// Digits after the point that times are written with, at most.
const MOST_DIGITS: i32 = 9;
/// A median of the size of normal errors is this share of their standard deviation.
const OF_NORMAL: f64 = 1.4826;

/// A jump of the times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// The first row after it.
    pub row: usize,
    /// How much later the times are from there on, beyond whole steps: up to half a step, s.
    pub by_s: f64,
    /// Standard deviation of that, by the scatter of the times beside it, s.
    pub std_s: f64,
    /// From the row before to the first one after, s.
    pub interval_s: f64,
}

/// What times say of themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct Cadence {
    /// The usual step, s.
    pub step_s: f64,
    /// The mean of the intervals where they are alike, else their median, s.
    pub usual_s: f64,
    /// The unit of the last digit in which all times are written, counted from the first, where they are, s.
    pub digit_s: Option<f64>,
    /// In the order of rows.
    pub jumps: Vec<Jump>,
}

impl Cadence {
    /// Of times that rise; None for fewer than three.
    pub fn of(time: &[f64]) -> Option<Self> {
        if time.len() < 3 {
            return None;
        }
        let usual_s = usual(time);
        let digit_s = digit(time);
        let step_s = finer(time, usual_s);
        let least = (LEAST * step_s).max(DIGITS * digit_s.unwrap_or(0.0)).max(rounding(time));
        let is_straight = straight(time, step_s, 0.5 * least);
        let jumps = if is_straight { Vec::new() } else { Phases::of(time, step_s).jumps(least) };
        let jump = |(row, by_s, std_s)| Jump { row, by_s, std_s, interval_s: time[row] - time[row - 1] };
        Some(Self { step_s, usual_s, digit_s, jumps: jumps.into_iter().map(jump).collect() })
    }

    /// The rows between jumps.
    pub fn segments(&self, rows: usize) -> Vec<std::ops::Range<usize>> {
        let starts = std::iter::once(0).chain(self.jumps.iter().map(|jump| jump.row));
        let ends = self.jumps.iter().map(|jump| jump.row).chain(std::iter::once(rows));
        starts.zip(ends).map(|(from, to)| from..to).collect()
    }
}

/// What is lost where times are numbers of double precision.
pub fn rounding(time: &[f64]) -> f64 {
    let largest = time.first().map_or(0.0, |t| t.abs()).max(time.last().map_or(0.0, |t| t.abs()));
    4.0 * f64::EPSILON * largest
}

/// The largest power of ten, from 1 s down, of which all times are multiples from the first one on.
fn digit(time: &[f64]) -> Option<f64> {
    let lost = rounding(time);
    (0..=MOST_DIGITS).find_map(|digits| {
        let per_second = 10_f64.powi(digits);
        // Where so little is lost that a multiple can be told from what is none.
        let tolerance = (4.0 * lost * per_second).max(1e-6);
        let whole = |t: &f64| {
            let count = (t - time[0]) * per_second;
            (count - count.round()).abs() <= tolerance
        };
        (tolerance < 0.1 && time.iter().all(whole)).then(|| per_second.recip())
    })
}

/// The mean of the intervals where they are alike, else their median.
fn usual(time: &[f64]) -> f64 {
    let intervals = || time.windows(2).map(|pair| pair[1] - pair[0]);
    let mean = (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64;
    if intervals().all(|interval| (interval - mean).abs() <= ALIKE * mean) {
        return mean;
    }
    median_of(&mut intervals().collect::<Vec<f64>>())
}

/// The place of each row, counted in steps from the first.
pub fn places(time: &[f64], step_s: f64) -> impl Iterator<Item = f64> {
    let between = time.windows(2).map(move |pair| ((pair[1] - pair[0]) / step_s).round().max(1.0));
    std::iter::once(0.0).chain(between).scan(0.0, |place, by| {
        *place += by;
        Some(*place)
    })
}

/// Whether all times lie within a tolerance of their places on the line through the ends.
fn straight(time: &[f64], step_s: f64, tolerance: f64) -> bool {
    let count = places(time, step_s).last().unwrap_or(0.0);
    let line = (time[time.len() - 1] - time[0]) / count;
    time.iter().zip(places(time, step_s)).all(|(t, place)| (t - time[0] - line * place).abs() <= tolerance)
}

/// The step by runs of rows without a gap, which a last digit does not round; else `usual`.
fn finer(time: &[f64], usual: f64) -> f64 {
    let of_length = |length: &usize| {
        let of_run = |run: &[f64]| {
            let whole = run.windows(2).all(|pair| pair[1] - pair[0] < WHOLE * usual);
            whole.then(|| (run[*length] - run[0]) / *length as f64)
        };
        let steps: Vec<f64> = time.windows(length + 1).step_by(*length).filter_map(of_run).collect();
        (!steps.is_empty()).then(|| median(&steps))
    };
    FINE.iter().find_map(of_length).unwrap_or(usual)
}

struct Phases {
    place: Vec<f64>,
    /// Time less that of the place, s.
    phase: Vec<f64>,
}

/// A level after less the level before, about lines of one slope, with its standard deviation.
#[derive(Clone, Copy)]
struct Compared {
    by: f64,
    std: f64,
}

impl Phases {
    fn of(time: &[f64], step_s: f64) -> Self {
        let place: Vec<f64> = places(time, step_s).collect();
        let phase = time.iter().zip(&place).map(|(t, place)| t - time[0] - place * step_s).collect();
        Self { place, phase }
    }

    /// First rows after jumps, with size and standard deviation.
    fn jumps(&self, least: f64) -> Vec<(usize, f64, f64)> {
        let rows = self.phase.len();
        let mut bounds = vec![0, rows];
        let all: Vec<Compared> = (0..rows).map(|row| self.at(row, &bounds)).collect();
        let elsewhere = elsewhere(&all);
        let stands = |row: usize, of: &Compared| {
            let size = of.by.abs();
            size > least && size > SIGMAS * of.std && size > ELSEWHERE * elsewhere[row / NEIGHBOURHOOD]
        };
        let mut candidates: Vec<usize> = (0..rows).filter(|row| stands(*row, &all[*row])).collect();
        // The largest first: beside a jump the rows across it are not compared again.
        while let Some((best, _)) = candidates
            .iter()
            .map(|row| (*row, self.at(*row, &bounds)))
            .filter(|(row, of)| stands(*row, of))
            .map(|(row, of)| (row, of.by.abs() / of.std.max(0.01 * least)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
        {
            let at = bounds.partition_point(|bound| *bound < best);
            bounds.insert(at, best);
            if bounds.len() * RARE > rows + 3 * RARE {
                return Vec::new();
            }
            candidates.retain(|row| row.abs_diff(best) >= PERSISTS);
        }
        let between = |row: &usize| {
            let others: Vec<usize> = bounds.iter().copied().filter(|bound| bound != row).collect();
            let of = self.at(*row, &others);
            (*row, of.by, of.std)
        };
        bounds[1..bounds.len() - 1].iter().map(between).collect()
    }

    /// Rows before against rows from here on, as far as the next bounds.
    fn at(&self, row: usize, bounds: &[usize]) -> Compared {
        let none = Compared { by: 0.0, std: f64::INFINITY };
        let after = bounds.partition_point(|bound| *bound <= row);
        if after == 0 || after == bounds.len() {
            return none;
        }
        let (from, to) = (bounds[after - 1].max(row.saturating_sub(BESIDE)), bounds[after].min(row + BESIDE));
        if row - from < PERSISTS || to - row < PERSISTS {
            return none;
        }
        let (before, behind) = (Side::of(self, from..row), Side::of(self, row..to));
        let along = before.along + behind.along;
        let slope = (before.product + behind.product) / along;
        let apart = behind.place - before.place;
        let by = behind.phase - before.phase - slope * apart;
        let squares = (before.squares + behind.squares - slope * (before.product + behind.product)).max(0.0);
        let variance = squares / ((to - from) as f64 - 3.0);
        let (n, m) = ((row - from) as f64, (to - row) as f64);
        Compared { by, std: (variance * (1.0 / n + 1.0 / m + apart * apart / along)).sqrt() }
    }
}

/// Rows on one side: their means, and sums of squares and products about them.
struct Side {
    place: f64,
    phase: f64,
    along: f64,
    product: f64,
    squares: f64,
}

impl Side {
    fn of(phases: &Phases, rows: std::ops::Range<usize>) -> Self {
        let count = rows.len() as f64;
        let (x, y) = (&phases.place[rows.clone()], &phases.phase[rows]);
        let (place, phase) = (x.iter().sum::<f64>() / count, y.iter().sum::<f64>() / count);
        let (mut along, mut product, mut squares) = (0.0, 0.0, 0.0);
        for (x, y) in x.iter().zip(y) {
            let (x, y) = (x - place, y - phase);
            along += x * x;
            product += x * y;
            squares += y * y;
        }
        Self { place, phase, along, product, squares }
    }
}

/// What the comparison usually gives, neighbourhood by neighbourhood.
fn elsewhere(all: &[Compared]) -> Vec<f64> {
    let of = |block: &[Compared]| {
        let sizes: Vec<f64> = block.iter().filter(|of| of.std.is_finite()).map(|of| of.by.abs()).collect();
        if sizes.is_empty() { 0.0 } else { OF_NORMAL * median(&sizes) }
    };
    all.chunks(NEIGHBOURHOOD).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use noise::Stream;
    use proptest::prelude::*;

    /// Even times of which some rows may be moved.
    fn times(rows: usize, step: f64, by: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..rows).map(|row| row as f64 * step + by(row)).collect()
    }

    fn to_digit(time: &[f64], digit: f64) -> Vec<f64> {
        time.iter().map(|t| (t / digit).round() * digit).collect()
    }

    fn jumps(time: &[f64]) -> Vec<(usize, f64)> {
        Cadence::of(time).expect("times").jumps.iter().map(|jump| (jump.row, jump.by_s)).collect()
    }

    #[test]
    fn a_jump_is_found_with_its_size_even_below_a_step() {
        for by in [0.3, -0.3, 0.02, -0.45] {
            let found = jumps(&times(400, 1.0, |row| if row < 150 { 0.0 } else { by }));
            assert_eq!(found.len(), 1, "{by}");
            assert_eq!(found[0].0, 150);
            assert!((found[0].1 - by).abs() < 1e-9, "{by}: {found:?}");
        }
        // Twice, and back; with lost rows beside.
        let two = |row: usize| if (150..170).contains(&row) { 0.2 } else { 0.0 } + if row < 160 { 0.0 } else { 30.0 };
        let rows: Vec<usize> = jumps(&times(400, 1.0, two)).iter().map(|jump| jump.0).collect();
        assert_eq!(rows, [150, 170]);
    }

    #[test]
    fn lost_rows_rounding_and_a_rate_are_no_jumps() {
        assert!(jumps(&times(500, 1.0, |row| if row < 99 { 0.0 } else { 17.0 })).is_empty());
        assert!(jumps(&times(5000, 1.0003, |_| 0.0)).is_empty());
        let gap = |row: usize, step: f64| if row < 99 { 0.0 } else { 5000.0 * step };
        assert!(jumps(&times(5000, 1.0003, |row| gap(row, 1.0003))).is_empty());
        for digit in [1e-6, 1e-3] {
            for step in [1.000_01, 1.0003, 0.016_667, 60.0 / 7.0] {
                let time = to_digit(&times(6000, step, |row| gap(row, step)), digit);
                assert!(jumps(&time).is_empty(), "{digit} {step}");
                let cadence = Cadence::of(&time).expect("times");
                assert!((cadence.step_s / step - 1.0).abs() < 1e-4, "{digit} {step}");
            }
        }
        let cadence = Cadence::of(&to_digit(&times(100, 1.0003, |_| 0.0), 1e-3)).expect("times");
        assert_eq!(cadence.digit_s, Some(1e-3));
        // Seconds since 1970 to the millisecond, as double precision holds them.
        let late: Vec<f64> = to_digit(&times(3000, 0.1, |_| 0.0), 1e-3).iter().map(|t| t + 1.7e9).collect();
        assert_eq!(Cadence::of(&late).map(|of| (of.jumps.len(), of.digit_s)), Some((0, Some(0.1))));
    }

    #[test]
    fn jitter_a_wandering_step_and_a_late_row_are_no_jumps() {
        for seed in 0..20 {
            let noise: Vec<f64> = {
                let mut stream = Stream::new(seed, "jitter");
                (0..20_000).map(|_| stream.normal()).collect()
            };
            assert!(jumps(&times(20_000, 1.0, |row| 0.02 * noise[row])).is_empty(), "white {seed}");
            let mut sum = 0.0;
            let walk: Vec<f64> = noise
                .iter()
                .map(|step| {
                    sum += 0.003 * step;
                    sum
                })
                .collect();
            assert!(jumps(&times(20_000, 1.0, |row| walk[row])).is_empty(), "walk {seed}");
            let jumped = times(20_000, 1.0, |row| 0.02 * noise[row] + if row < 7000 { 0.0 } else { 0.3 });
            let found = jumps(&jumped);
            assert_eq!(found.len(), 1, "{seed}");
            assert!(found[0].0.abs_diff(7000) <= 1 && (found[0].1 - 0.3).abs() < 0.1, "{seed} {found:?}");
        }
        assert!(jumps(&times(1000, 1.0, |row| if row == 500 { 0.4 } else { 0.0 })).is_empty());
        assert!(jumps(&times(1000, 1.0, |row| if row % 40 < 20 { 0.0 } else { 0.2 })).is_empty(), "too many");
    }

    proptest! {
        /// The same jumps in times that are moved, and in those of another unit, in that unit.
        #[test]
        fn jumps_move_with_the_times(
            at in 40_usize..260,
            by in prop_oneof![-0.4_f64..-0.01, 0.01_f64..0.4],
            from in -1e6_f64..1e6,
            unit in 0.01_f64..1000.0,
        ) {
            let plain = times(300, 1.0, |row| if row < at { 0.0 } else { by });
            let found = Cadence::of(&plain).expect("times");
            // A jump of one printed digit is none.
            let shown = |of: &Cadence, by: f64| of.digit_s.is_none_or(|digit| by.abs() > 2.0 * digit);
            prop_assume!(shown(&found, by));
            prop_assert_eq!(found.jumps.len(), 1);
            let moved: Vec<f64> = plain.iter().map(|t| from + unit * t).collect();
            let of_moved = Cadence::of(&moved).expect("times");
            prop_assume!(shown(&of_moved, unit * by));
            prop_assert_eq!(of_moved.jumps.len(), 1);
            prop_assert_eq!(of_moved.jumps[0].row, at);
            prop_assert!((of_moved.jumps[0].by_s - unit * by).abs() < 1e-6 * unit);
            prop_assert!((of_moved.step_s - unit * found.step_s).abs() < 1e-6 * unit);
        }
    }
}
