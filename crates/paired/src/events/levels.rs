//! The level after some rows against the level before, held against what the same series does elsewhere.

use std::ops::Range;

use super::local;

/// Means of so many rows are held against each other.
const MEANS: [usize; 3] = [4, 16, LONGEST];
pub const LONGEST: usize = 64;
/// Rows on either side from which the noise of a difference of means is told: those near, and those of a
/// wider neighbourhood.
const NEAR: usize = 256;
const WIDE: usize = 2048;
/// Fewer differences than these tell no noise.
const LEAST: usize = 12;
/// Rows after which a pass is over.
pub const PASS: usize = 128;
/// Means of few and of many rows say the same of a step within so many uncertainties.
const ALIKE: f64 = 5.0;
/// So many readings on either side of disturbed rows say where these lie until the likely readings are known.
const BESIDE: usize = 8;

/// The readings of a series that are known, without its steps.
pub struct Levels {
    /// Of each row, how many known ones are before it.
    before: Vec<usize>,
    /// Sums of the known readings up to each.
    sums: Vec<f64>,
}

/// What is known of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Net {
    /// nT, of the series without steps.
    pub size: f64,
    /// Standard uncertainty by what the same means do elsewhere, nT.
    pub std: f64,
    /// How far means of fewer and more rows are from this one, in the uncertainties of both, at most.
    pub unlike: f64,
}

impl Net {
    /// Whether the level is another one: a step of this size and not a flank.
    pub fn is_level(&self) -> bool {
        self.unlike <= ALIKE
    }

    /// Whether another one, of rows farther away, is nearer to this one than to no step at all.
    pub fn agrees(&self, far: Option<Net>) -> bool {
        far.is_none_or(|far| (far.size - self.size).abs() < far.size.abs())
    }
}

impl Levels {
    /// Of a series without its steps; what is in rows that are out does not count.
    pub fn of(series: &[f64], out: &[bool]) -> Self {
        let (mut before, mut sums, mut sum) = (Vec::with_capacity(series.len() + 1), vec![0.0], 0.0);
        for (value, out) in series.iter().zip(out) {
            before.push(sums.len() - 1);
            if !out {
                sum += value;
                sums.push(sum);
            }
        }
        before.push(sums.len() - 1);
        Self { before, sums }
    }

    /// Mean of the `count` readings from number `gap` after the first `at` on less that of the `count` before
    /// them.
    fn difference(&self, at: usize, gap: usize, count: usize) -> f64 {
        let sum = |from: usize| self.sums[from + count] - self.sums[from];
        (sum(at + gap) - sum(at - count)) / count as f64
    }

    /// The same as [`Levels::net`] with so many rows left out on either side that a pass is over, or half of
    /// those up to the next steps, which begin and end the `between`: what does not last there is no step.
    pub fn lasting(&self, from: usize, after: usize, removed: f64, between: Range<usize>) -> Option<Net> {
        let before = PASS.min((from - between.start) / 2);
        let since = PASS.min(between.end.saturating_sub(after) / 2);
        self.net_within(from - before, after + since, removed, between)
    }

    /// By how much the level from row `after` on is above that before row `from`, of which `removed` was
    /// taken off; None where too little is known.
    ///
    /// Means of 4, 16 and 64 readings on either side are held against each other. The noise of each is told
    /// from the same differences elsewhere: before, after and in a wider neighbourhood, the largest of these,
    /// by their median and by what a twentieth exceeds.
    pub fn net(&self, from: usize, after: usize, removed: f64) -> Option<Net> {
        self.net_within(from, after, removed, 0..self.before.len() - 1)
    }

    /// The same from levels in some rows only; the noise is that of all around.
    fn net_within(&self, from: usize, after: usize, removed: f64, within: Range<usize>) -> Option<Net> {
        let (last, first) = (self.before[from], self.before[after]);
        let (least, most) = (self.before[within.start], self.before[within.end]);
        let known = self.sums.len() - 1;
        let gap = after - from;
        let mut found: Vec<(f64, f64)> = Vec::new();
        for count in MEANS {
            if last < least + count || first + count > most {
                continue;
            }
            let stride = ((2 * count + gap) / 8).max(1);
            let spread = |low: usize, high: usize| -> Option<f64> {
                let mut sizes: Vec<f64> = (low.max(count)..high.min(known.saturating_sub(count + gap)))
                    .step_by(stride)
                    .filter(|at| at + gap + count <= last || *at >= first + count)
                    .map(|at| self.difference(at, gap, count).abs())
                    .collect();
                (sizes.len() >= LEAST).then(|| local::spread(&mut sizes))
            };
            let reach = |rows: usize| rows.max(4 * (2 * count + gap));
            let low = |rows: usize| last.saturating_sub(reach(rows) + gap);
            let high = |rows: usize| first + reach(rows);
            let spreads = [spread(low(NEAR), last), spread(first, high(NEAR)), spread(low(WIDE), high(WIDE))];
            let Some(std) = spreads.into_iter().flatten().reduce(f64::max).filter(|std| *std > 0.0) else {
                continue;
            };
            let before = (self.sums[last] - self.sums[last - count]) / count as f64;
            let since = (self.sums[first + count] - self.sums[first]) / count as f64;
            found.push((since - before + removed, std));
        }
        let (size, std) = found.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let unlike =
            found.iter().map(|(other, own)| (other - size).abs() / own.hypot(std)).fold(0.0, f64::max);
        Some(Net { size, std, unlike })
    }
}

/// A series with straight lines between the levels on either side where rows are out.
pub fn levelled(mut series: Vec<f64>, out: &[bool]) -> Vec<f64> {
    let known: Vec<usize> = (0..series.len()).filter(|row| !out[*row]).collect();
    if known.len() == series.len() || known.is_empty() {
        return series;
    }
    let level =
        |rows: &[usize], series: &[f64]| rows.iter().map(|row| series[*row]).sum::<f64>() / rows.len() as f64;
    let own = series.clone();
    let mut row = 0;
    while row < series.len() {
        if !out[row] {
            row += 1;
            continue;
        }
        let before = known.partition_point(|known| *known < row);
        let after = known.get(before).copied().unwrap_or(series.len());
        let left = &known[before.saturating_sub(BESIDE)..before];
        let right = &known[before..(before + BESIDE).min(known.len())];
        let (a, b) = match (left.is_empty(), right.is_empty()) {
            (true, _) => (level(right, &own), level(right, &own)),
            (_, true) => (level(left, &own), level(left, &own)),
            _ => (level(left, &own), level(right, &own)),
        };
        let rows = (after - row + 1) as f64;
        for (place, value) in series[row..after].iter_mut().enumerate() {
            *value = a + (b - a) * (place + 1) as f64 / rows;
        }
        row = after;
    }
    series
}

#[cfg(test)]
mod tests {
    use super::*;

    fn white(seed: u64, rows: usize) -> Vec<f64> {
        let mut stream = noise::Stream::new(seed, "levels");
        (0..rows).map(|_| stream.normal()).collect()
    }

    fn net(series: &[f64], out: &[bool], from: usize, after: usize) -> Net {
        Levels::of(series, out).net(from, after, 0.0).expect("enough rows")
    }

    #[test]
    fn a_step_is_one_and_noise_is_none() {
        let mut largest = 0.0_f64;
        for seed in 0..200 {
            let mut series = white(seed, 3000);
            let none = net(&series, &[false; 3000], 1500, 1500);
            largest = largest.max((none.size / none.std).abs());
            series[1500..].iter_mut().for_each(|value| *value += 5.0);
            let step = net(&series, &[false; 3000], 1500, 1500);
            assert!(step.is_level() && step.size > 10.0 * step.std, "{step:?}");
            assert!((step.size - 5.0).abs() < 5.0 * step.std, "{step:?}");
        }
        assert!(largest < 4.5, "{largest}");
    }

    #[test]
    fn a_flank_is_no_step() {
        let mut series = white(1, 3000);
        (1400..1600).for_each(|row| series[row] += 0.2 * (row - 1400) as f64);
        series[1600..].iter_mut().for_each(|value| *value += 40.0);
        let flank = net(&series, &[false; 3000], 1500, 1500);
        assert!(!flank.is_level() || flank.size.abs() < 6.0 * flank.std, "{flank:?}");
    }

    #[test]
    fn a_pass_and_two_jumps_that_die_away_do_not_last() {
        let mut pass = white(3, 3000);
        (1500..3000).for_each(|row| pass[row] += 12.0 * (-((row as f64 - 1500.0) / 40.0).powi(2)).exp());
        let mut jumps = white(4, 3000);
        let decay = |row: usize, at: usize| if row < at { 0.0 } else { (-((row - at) as f64) / 8.0).exp() };
        (0..3000).for_each(|row| jumps[row] += 30.0 * (decay(row, 1580) - decay(row, 1500)));
        // As if the one led back from the other.
        jumps[1500..1580].iter_mut().for_each(|value| *value += 15.0);
        for (series, at, removed, between) in
            [(&pass, 1500, 0.0, 0..3000), (&jumps, 1500, -15.0, 0..1580), (&jumps, 1580, 15.0, 1500..3000)]
        {
            let levels = Levels::of(series, &[false; 3000]);
            let near = levels.net(at, at, removed).expect("enough rows");
            assert!(!near.agrees(levels.lasting(at, at, removed, between)), "{near:?}");
        }
    }

    #[test]
    fn the_level_across_rows_that_are_out() {
        let mut series = white(2, 3000);
        let mut out = vec![false; 3000];
        (1000..1050).for_each(|row| (series[row], out[row]) = (f64::NAN, true));
        series[1050..].iter_mut().for_each(|value| *value += 4.0);
        let step = net(&series, &out, 1000, 1050);
        assert!(step.is_level() && (step.size - 4.0).abs() < 4.0 * step.std, "{step:?}");
    }
}
