use std::collections::HashMap;

use super::drawn::{Plot, Point, Series};
use crate::page::number;

/// Columns of a drawing in which the lowest and the highest point stand for all.
const COLUMNS: usize = 400;

/// The plot with its long series thinned, and a sentence where that was done: of each 1/400 of the width the
/// lowest and the highest point remain, so that no excursion is lost.
pub fn thinned(mut plot: Plot) -> (Plot, Option<String>) {
    let count = |plot: &Plot| plot.series.iter().flat_map(Series::values).count();
    let rows = count(&plot);
    let log = plot.x.log;
    plot.series.iter_mut().for_each(|series| thin(series, log));
    let kept = count(&plot);
    let note = (kept < rows).then(|| {
        format!(
            "Of {rows} rows {kept} are drawn and in the data: the lowest and the highest of each 1/{COLUMNS} of the width."
        )
    });
    (plot, note)
}

fn thin(series: &mut Series, log: bool) {
    if series.points.len() <= 2 * COLUMNS {
        return;
    }
    let along = |point: &Point| if log { point.x.log10() } else { point.x };
    let Some([low, high]) = number::ends(series.points.iter().map(along)) else { return };
    // In each column the lowest and the highest row, and the last that is missing: there a line is parted.
    let mut columns: HashMap<usize, [Option<usize>; 3]> = HashMap::new();
    let mut column = 0;
    for (row, point) in series.points.iter().enumerate() {
        if along(point).is_finite() {
            column = (((along(point) - low) / (high - low) * COLUMNS as f64) as usize).min(COLUMNS - 1);
        }
        // A gap between parts is where the first of them ends.
        let [lowest, highest, missing] = columns.entry(column).or_default();
        if !point.y.is_finite() {
            *missing = Some(row);
        }
        if !point.y.is_finite() || !along(point).is_finite() {
            continue;
        }
        if lowest.is_none_or(|lowest| point.y < series.points[lowest].y) {
            *lowest = Some(row);
        }
        if highest.is_none_or(|highest| point.y > series.points[highest].y) {
            *highest = Some(row);
        }
    }
    let mut rows: Vec<usize> = columns.into_values().flatten().flatten().collect();
    rows.sort_unstable();
    rows.dedup();
    series.points = rows.into_iter().map(|row| series.points[row]).collect();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::plot::Mark;

    #[test]
    fn excursions_and_gaps_survive_and_a_short_series_is_left() {
        let x: Vec<f64> = (0..100_000).map(f64::from).collect();
        let mut y: Vec<f64> = x.iter().map(|x| (x / 500.0).sin()).collect();
        y[54_321] = 40.0;
        y[30_000..30_500].fill(f64::NAN);
        let short = Series::new("short", Mark::Line, 1, &[1.0, 2.0], &[3.0, f64::NAN]);
        let plot = Plot::new("p", "P").with(Series::new("long", Mark::Line, 0, &x, &y)).with(short);
        let (plot, note) = thinned(plot);
        assert!(plot.series[0].points.len() <= 2 * COLUMNS + 3);
        assert!(plot.series[0].points.iter().any(|point| point.y.is_nan()));
        assert!(plot.series[0].points.iter().any(|point| point.x == 54_321.0 && point.y == 40.0));
        assert_eq!(plot.series[1].points.len(), 2);
        let mut parted = Series::new("parted", Mark::Line, 0, &x[..600], &y[..600]);
        parted.append(&x[9000..9600], &y[9000..9600]);
        let (parted, _) = thinned(Plot::new("q", "Q").with(parted));
        assert!(parted.points().any(|point| point.x.is_nan()));
        assert!(note.expect("a note").starts_with("Of 100002 rows "));
    }
}
