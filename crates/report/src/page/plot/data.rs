//! The numbers of a plot for the page's script, which zooms and exports: JSON with columns in base64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

use super::drawn::{Dimension, Interval, Mark, Plot, Point, Series, Timeline, Toggle};

/// Up to so many points keep every digit; longer series are single precision about their first value.
const EXACT: usize = 2_000;
/// So many numbers are written into one page at most: 5.3 bytes each in single precision.
const MOST: usize = 800_000;

/// Rows that one entry stands for, so that the data of all plots of a page stay within its size.
pub fn rows_per_entry<'a>(plots: impl Iterator<Item = &'a Plot> + Clone) -> usize {
    let numbers = |rows: usize| -> usize {
        plots.clone().flat_map(|plot| &plot.series).map(|series| numbers_of(series, rows)).sum()
    };
    (0..).map(|power| 1 << power).find(|rows| numbers(*rows) <= MOST).unwrap_or(1)
}

fn numbers_of(series: &Series, rows: usize) -> usize {
    let count = series.points.len();
    let bars = if series.points.first().is_some_and(|point| point.bar.is_some()) { 3 } else { 1 };
    // Times that are not regular take double precision.
    let times = if regular(&series.points).is_some() { 0 } else { 2 };
    if rows == 1 || count <= EXACT { count * (bars + times) } else { count / rows * (2 + times) }
}

/// The plot as JSON, safe within a page.
pub fn data(plot: &Plot, rows: usize) -> String {
    let written = Written {
        x: &plot.x,
        y: &plot.y,
        map: plot.map,
        time: plot.time.as_ref(),
        series: plot.series.iter().map(|series| column(series, rows)).collect(),
        marks: &plot.marks,
        toggles: plot.toggles.iter().map(switched).collect(),
        held_out: plot.held_out_nt,
        spectrum: plot.spectrum,
    };
    let json = serde_json::to_string(&written).unwrap_or_default();
    json.replace('&', "\\u0026").replace('<', "\\u003c").replace('>', "\\u003e")
}

#[derive(Serialize)]
struct Written<'a> {
    x: &'a Dimension,
    y: &'a Dimension,
    map: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<&'a Timeline>,
    series: Vec<WrittenSeries<'a>>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    marks: &'a [Interval],
    #[serde(skip_serializing_if = "Vec::is_empty")]
    toggles: Vec<WrittenToggle<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    held_out: Option<f64>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    spectrum: bool,
}

#[derive(Serialize)]
struct WrittenSeries<'a> {
    name: &'a str,
    mark: Mark,
    style: usize,
    x: Places,
    #[serde(skip_serializing_if = "Option::is_none")]
    y: Option<Numbers>,
    #[serde(skip_serializing_if = "Option::is_none")]
    low: Option<Numbers>,
    #[serde(skip_serializing_if = "Option::is_none")]
    high: Option<Numbers>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bin: Option<usize>,
}

#[derive(Serialize)]
struct WrittenToggle<'a> {
    name: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<&'a str>,
    series: usize,
    y: Numbers,
    #[serde(skip_serializing_if = "Option::is_none")]
    held_out_nt: Option<f64>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Places {
    Regular { from: f64, step: f64, count: usize },
    Each(Numbers),
}

#[derive(Serialize)]
#[serde(untagged)]
enum Numbers {
    Double { f64: String },
    Single { base: f64, f32: String },
}

fn column(series: &Series, rows: usize) -> WrittenSeries<'_> {
    let points = &series.points;
    let binned = rows > 1 && points.len() > EXACT;
    let rows = if binned { rows } else { 1 };
    let starts: Vec<f64> = points.iter().step_by(rows).map(|point| point.x).collect();
    let x = match regular(points) {
        Some([from, step]) => Places::Regular { from, step: step * rows as f64, count: starts.len() },
        None => Places::Each(double(&starts)),
    };
    let limits: Option<Vec<[f64; 2]>> = if binned {
        Some(points.chunks(rows).map(extent).collect())
    } else {
        points
            .iter()
            .any(|point| point.bar.is_some())
            .then(|| points.iter().map(|point| point.bar.unwrap_or([f64::NAN; 2])).collect())
    };
    let limit = |end: usize| {
        limits.as_ref().map(|all| numbers(&all.iter().map(|ends| ends[end]).collect::<Vec<f64>>()))
    };
    WrittenSeries {
        name: &series.name,
        mark: series.mark,
        style: series.style,
        x,
        y: (!binned).then(|| numbers(&points.iter().map(|point| point.y).collect::<Vec<f64>>())),
        low: limit(0),
        high: limit(1),
        bin: binned.then_some(rows),
    }
}

fn switched(toggle: &Toggle) -> WrittenToggle<'_> {
    let Toggle { name, id, series, y, held_out_nt } = toggle;
    let y = numbers(y);
    WrittenToggle { name, id: id.as_deref(), series: *series, y, held_out_nt: *held_out_nt }
}

/// The smallest and the largest value of some rows.
fn extent(points: &[Point]) -> [f64; 2] {
    let values = points.iter().map(|point| point.y);
    values.fold([f64::NAN; 2], |[low, high], value| [low.min(value), high.max(value)])
}

/// The first place and the step, where all are as far apart.
fn regular(points: &[Point]) -> Option<[f64; 2]> {
    let [first, .., last] = points else { return None };
    let step = (last.x - first.x) / (points.len() - 1) as f64;
    let at = |row: usize| first.x + step * row as f64;
    let all = points.iter().enumerate().all(|(row, point)| (point.x - at(row)).abs() <= 1e-6 * step.abs());
    all.then_some([first.x, step])
}

fn numbers(values: &[f64]) -> Numbers {
    if values.len() <= EXACT {
        return double(values);
    }
    let base = values.iter().copied().find(|value| value.is_finite()).unwrap_or_default();
    let bytes: Vec<u8> = values.iter().flat_map(|value| ((value - base) as f32).to_le_bytes()).collect();
    Numbers::Single { base, f32: STANDARD.encode(bytes) }
}

fn double(values: &[f64]) -> Numbers {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    Numbers::Double { f64: STANDARD.encode(bytes) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_series_is_the_extent_of_bins_and_a_short_one_is_exact() {
        let x: Vec<f64> = (0..2_000_000).map(f64::from).collect();
        let mut y = x.clone();
        y[999] = 1e9;
        let long = Plot::new("p", "P").with(Series::new("<a>", Mark::Line, 0, &x, &y));
        let rows = rows_per_entry([&long].into_iter());
        assert_eq!(rows, 8);
        let text = data(&long, rows);
        assert!(text.len() < 6_000_000 && text.contains("\\u003ca\\u003e"), "{}", text.len());
        let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let series = &json["series"][0];
        assert_eq!(
            [&series["bin"], &series["x"]["step"], &series["x"]["count"]].map(|n| n.as_f64()),
            [Some(8.0), Some(8.0), Some(250_000.0)]
        );
        let high = STANDARD.decode(series["high"]["f32"].as_str().expect("base64")).expect("bytes");
        let bin = 4 * (999 / rows);
        let found = f32::from_le_bytes(high[bin..bin + 4].try_into().expect("four"));
        let found = f64::from(found) + series["high"]["base"].as_f64().expect("a number");
        assert!((found - 1e9).abs() < 64.0, "{found}");

        let short =
            Plot::new("p", "P").with(Series::measured("a", 0, [[0.0, 0.1, 0.01], [5.0, f64::NAN, 1.0]]));
        let json: serde_json::Value = serde_json::from_str(&data(&short, rows)).expect("JSON");
        let y = STANDARD.decode(json["series"][0]["y"]["f64"].as_str().expect("base64")).expect("bytes");
        assert_eq!(y[..8], 0.1_f64.to_le_bytes());
        assert_eq!(json["series"][0]["bin"], serde_json::Value::Null);
    }
}
