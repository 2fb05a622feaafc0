//! What readings show by themselves: a sensor's logger repeats what it read before, and codes are coarse.

use common::{Axis, Document};

/// Rows to either side of a stretch that say how often a reading is that before it.
const AROUND: usize = 300;
/// Fewest rows of a stretch.
const LEAST: usize = 4;
/// Fewest pairs of neighbours around one.
const PAIRS: usize = 20;
/// A stretch that is as probable by chance is none.
const BY_CHANCE: f64 = 1e-4;

/// A stretch of equal readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Frozen {
    pub axis: Axis,
    /// Moment of the first of them on the clock of its recording, and how long they last, s.
    pub time_s: f64,
    pub duration_s: f64,
}

/// The stretches of a document's recordings, and the document without the readings that repeat the first of each.
pub fn without_frozen(document: &Document) -> (Vec<Frozen>, Document) {
    let (mut found, mut less) = (Vec::new(), document.clone());
    for recording in &mut less.recordings {
        let Some(time_s) = recording.column("time_s").map(<[f64]>::to_vec) else { continue };
        for axis in Axis::ALL {
            for name in [format!("test_{axis}_nt"), format!("sensor_{axis}_nt"), format!("sensor_{axis}_v")] {
                let Some(column) = recording.columns.get_mut(&name) else { continue };
                for (from, to) in stretches(column) {
                    column[from + 1..to].fill(f64::NAN);
                    let duration_s = time_s[to - 1] - time_s[from];
                    found.push(Frozen { axis, time_s: time_s[from], duration_s });
                }
            }
        }
    }
    (found, less)
}

/// Stretches of equal readings that are improbable by how often neighbours are equal around them.
fn stretches(values: &[f64]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut from = 0;
    for row in 1..=values.len() {
        if row < values.len() && values[row] == values[from] {
            continue;
        }
        if row - from >= LEAST {
            let sides = [from.saturating_sub(AROUND)..from, row..(row + AROUND).min(values.len())];
            let pairs = || sides.iter().flat_map(|side| values[side.clone()].windows(2));
            let equal = pairs().filter(|pair| pair[0] == pair[1]).count() as f64;
            let usual = (equal + 1.0) / (pairs().count() as f64 + 2.0);
            if pairs().count() >= PAIRS
                && values.len() as f64 * usual.powi((row - from - 1) as i32) < BY_CHANCE
            {
                found.push((from, row));
            }
        }
        from = row;
    }
    found
}

/// Readings take so few values, as a share of their number.
const FEW: f64 = 0.25;
/// Steps between these are whole numbers of the width within this share of it.
const WHOLE: f64 = 0.1;
/// Fewest values and codes.
const CODES: usize = 3;

/// The width of the codes of each sensor whose readings a document holds in nT, where they are coarse.
pub fn coarse(document: &Document) -> Vec<(Axis, f64)> {
    let of = |axis: Axis| {
        let names = [format!("test_{axis}_nt"), format!("sensor_{axis}_nt")];
        let columns = document.recordings.iter().flat_map(|r| names.iter().filter_map(|name| r.column(name)));
        let values: Vec<f64> = columns.flatten().copied().filter(|value| value.is_finite()).collect();
        Some((axis, width(values)?))
    };
    Axis::ALL.into_iter().filter_map(of).collect()
}

/// The width of which all differences of some values are whole numbers; None where they take too many.
fn width(mut values: Vec<f64>) -> Option<f64> {
    let count = values.len();
    values.sort_by(f64::total_cmp);
    values.dedup();
    if values.len() < CODES || values.len() as f64 > FEW * count as f64 {
        return None;
    }
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let (mut above, mut below) = (0.0, 0.0);
    for step in &steps {
        let codes = (step / least).round();
        (above, below) = (above + codes * step, below + codes * codes);
    }
    let width = above / below;
    let is_whole = |step: &f64| (step / width - (step / width).round()).abs() < WHOLE;
    steps.iter().all(is_whole).then_some(width)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_repeats_is_found_where_it_is_improbable() {
        let mut stream = noise::Stream::new(3, "frozen");
        let mut fine: Vec<f64> = (0..500).map(|_| stream.normal()).collect();
        assert_eq!(stretches(&fine), []);
        fine[100..120].fill(0.25);
        assert_eq!(stretches(&fine), [(100, 120)]);
        // Codes as wide as that repeat by themselves.
        let coarse: Vec<f64> = fine.iter().map(|value| (0.3 * value).round()).collect();
        assert_eq!(stretches(&coarse[..100]), []);
        assert_eq!(stretches(&[0.0; 50]), []);
    }

    #[test]
    fn widths_are_those_of_the_codes() {
        let mut stream = noise::Stream::new(4, "coarse");
        let fine: Vec<f64> = (0..2000).map(|_| 3.0 * stream.normal()).collect();
        assert_eq!(width(fine.clone()), None);
        // Printed with two digits.
        let coarse = fine.iter().map(|x| (100.0 * 1.237 * (x / 1.237).round()).round() / 100.0).collect();
        let found = width(coarse).expect("codes");
        assert!((found - 1.237).abs() < 2e-3, "{found}");
    }
}
