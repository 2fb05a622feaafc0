//! The numbers of a plot for the page's script, which zooms and exports: JSON with columns in base64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::drawn::{Plot, Point, Series, Toggle};

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

pub fn data(plot: &Plot, rows: usize) -> String {
    let unless_empty = |list: Vec<Value>| (!list.is_empty()).then(|| list.into());
    let written = object([
        ("x", Some(json!(plot.x))),
        ("y", Some(json!(plot.y))),
        ("map", Some(plot.map.into())),
        ("time", plot.time.as_ref().map(|time| json!(time))),
        ("series", Some(plot.series.iter().map(|series| column(series, rows)).collect())),
        ("marks", unless_empty(plot.marks.iter().map(|mark| json!(mark)).collect())),
        ("toggles", unless_empty(plot.toggles.iter().map(switched).collect())),
        ("held_out", plot.held_out_nt.map(Value::from)),
        ("spectrum", plot.spectrum.then(|| true.into())),
    ]);
    written.to_string().replace('&', "\\u0026").replace('<', "\\u003c").replace('>', "\\u003e")
}

fn object<const N: usize>(entries: [(&str, Option<Value>); N]) -> Value {
    entries.into_iter().filter_map(|(key, value)| Some((key, value?))).collect()
}

fn column(series: &Series, rows: usize) -> Value {
    let points = &series.points;
    let binned = rows > 1 && points.len() > EXACT;
    let rows = if binned { rows } else { 1 };
    let starts: Vec<f64> = points.iter().step_by(rows).map(|point| point.x).collect();
    let x = match regular(points) {
        Some([from, step]) => json!({"from": from, "step": step * rows as f64, "count": starts.len()}),
        None => double(&starts),
    };
    let limits: Option<Vec<[f64; 2]>> = if binned {
        Some(points.chunks(rows).map(extent).collect())
    } else {
        let bars = points.iter().map(|point| point.bar.unwrap_or([f64::NAN; 2]));
        points.iter().any(|point| point.bar.is_some()).then(|| bars.collect())
    };
    let limit = |end: usize| {
        limits.as_ref().map(|all| numbers(&all.iter().map(|ends| ends[end]).collect::<Vec<f64>>()))
    };
    let y = || numbers(&points.iter().map(|point| point.y).collect::<Vec<f64>>());
    object([
        ("name", Some(series.name.as_str().into())),
        ("mark", Some(json!(series.mark))),
        ("style", Some(series.style.into())),
        ("x", Some(x)),
        ("y", (!binned).then(y)),
        ("low", limit(0)),
        ("high", limit(1)),
        ("bin", binned.then(|| rows.into())),
    ])
}

fn switched(toggle: &Toggle) -> Value {
    object([
        ("name", Some(toggle.name.as_str().into())),
        ("id", toggle.id.as_deref().map(Value::from)),
        ("series", Some(toggle.series.into())),
        ("y", Some(numbers(&toggle.y))),
        ("held_out_nt", toggle.held_out_nt.map(Value::from)),
    ])
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

fn numbers(values: &[f64]) -> Value {
    if values.len() <= EXACT {
        return double(values);
    }
    let base = values.iter().copied().find(|value| value.is_finite()).unwrap_or_default();
    let bytes: Vec<u8> = values.iter().flat_map(|value| ((value - base) as f32).to_le_bytes()).collect();
    json!({"base": base, "f32": STANDARD.encode(bytes)})
}

fn double(values: &[f64]) -> Value {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    json!({"f64": STANDARD.encode(bytes)})
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::plot::Mark;

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
        let json: Value = serde_json::from_str(&text).expect("JSON");
        let series = &json["series"][0];
        let found = [&series["bin"], &series["x"]["step"], &series["x"]["count"]].map(Value::as_f64);
        assert_eq!(found, [8.0, 8.0, 250_000.0].map(Some));
        let decoded = |text: &Value| STANDARD.decode(text.as_str().expect("base64")).expect("bytes");
        let bin = 4 * (999 / rows);
        let found = decoded(&series["high"]["f32"])[bin..bin + 4].try_into().map(f32::from_le_bytes);
        let found = f64::from(found.expect("four")) + series["high"]["base"].as_f64().expect("a number");
        assert!((found - 1e9).abs() < 64.0, "{found}");

        let series = Series::points("a", 0, &[0.0, 5.0], &[0.1, f64::NAN]).with_std(&[0.01, 1.0]);
        let json: Value = serde_json::from_str(&data(&Plot::new("p", "P").with(series), rows)).expect("JSON");
        assert_eq!(decoded(&json["series"][0]["y"]["f64"])[..8], 0.1_f64.to_le_bytes());
        assert_eq!(json["series"][0]["bin"], Value::Null);
    }
}
