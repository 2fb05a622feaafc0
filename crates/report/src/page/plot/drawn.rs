//! What is drawn.

use serde::Serialize;

use crate::page::number;
use crate::page::table::{Cell, Header, Table};

#[derive(Clone, Debug, Default)]
pub struct Plot {
    /// Unique within the page, and the name of the file of its data: lower case letters, digits and hyphens.
    pub id: String,
    pub title: String,
    pub x: Dimension,
    pub y: Dimension,
    pub series: Vec<Series>,
    /// What the reader must know of bars and bands.
    pub note: String,
    /// One step along x is as long as one along y: maps.
    pub map: bool,
    /// Stands above the next one, with the same axis of time.
    pub stacked: bool,
    /// Where x is the time of a recording.
    pub time: Option<Timeline>,
    /// Intervals of x that the page's words speak of.
    pub marks: Vec<Interval>,
    /// Explanations that can be switched off.
    pub toggles: Vec<Toggle>,
    /// The rms of readings that were held out, with all explanations, nT.
    pub held_out_nt: Option<f64>,
    /// Whether the spectrum of what can be switched is of use.
    pub spectrum: bool,
}

/// The time of a recording, along x.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Timeline {
    #[serde(skip)]
    pub recording: String,
    /// Plots of one group move together: those of a recording, and of others that overlap with it.
    pub group: String,
    /// Length of a step of 1 along x, s.
    pub unit_s: f64,
    /// Unix time of x = 0, s, where it is known.
    pub epoch_s: Option<f64>,
}

impl Timeline {
    /// Unix time of a recording's time where it is known, else that time, s.
    pub fn moment(&self, time_s: f64) -> f64 {
        self.epoch_s.unwrap_or_default() + time_s
    }
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Interval {
    pub name: String,
    pub from: f64,
    pub to: f64,
    /// Id of the page's element that speaks of it.
    pub id: String,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Toggle {
    pub name: String,
    pub id: Option<String>,
    /// Number of the series that it is taken off from.
    pub series: usize,
    /// What it takes off, point by point.
    pub y: Vec<f64>,
    /// The rms of readings that were held out, without it, nT.
    pub held_out_nt: Option<f64>,
}

#[derive(Clone, Debug, Default, Serialize)]
pub struct Dimension {
    /// What runs along it.
    pub label: String,
    /// Its unit; empty where it has none.
    pub unit: String,
    pub log: bool,
}

#[derive(Clone, Debug, Default)]
pub struct Series {
    pub name: String,
    pub mark: Mark,
    /// Number of its colour and shape; the axes x, y and z have 0, 1 and 2.
    pub style: usize,
    pub points: Vec<Point>,
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mark {
    /// A shape at each point, with a bar from low to high.
    #[default]
    Points,
    /// A line, with a band from low to high.
    Line,
    /// A dashed line, for what is fitted or a limit.
    Dashes,
}

/// One point; what is missing is NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    pub x: f64,
    pub y: f64,
    /// Ends of its bar or band.
    pub bar: Option<[f64; 2]>,
}

impl Dimension {
    pub fn linear(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), unit: unit.into(), log: false }
    }

    /// A logarithmic axis, with its unit in brackets.
    pub fn log(text: &str) -> Self {
        Self { log: true, ..Self::from(text) }
    }

    pub fn text(&self) -> String {
        if self.unit.is_empty() { self.label.clone() } else { format!("{} ({})", self.label, self.unit) }
    }
}

impl From<&str> for Dimension {
    /// A linear axis, with its unit in brackets: `"offset [nT]"`.
    fn from(text: &str) -> Self {
        let Header { name, unit } = text.into();
        Self::linear(name, unit)
    }
}

impl Plot {
    pub fn new(id: impl Into<String>, title: impl Into<String>) -> Self {
        Self { id: id.into(), title: title.into(), ..Self::default() }
    }

    pub fn axes(self, x: impl Into<Dimension>, y: impl Into<Dimension>) -> Self {
        Self { x: x.into(), y: y.into(), ..self }
    }

    pub fn note(self, note: impl Into<String>) -> Self {
        Self { note: note.into(), ..self }
    }

    /// With this series, unless it has no points.
    pub fn with(mut self, series: Series) -> Self {
        self.push(series);
        self
    }

    /// Adds a series, unless it has no points.
    pub fn push(&mut self, series: Series) {
        if !series.points.is_empty() {
            self.series.push(series);
        }
    }

    /// All points, and the gaps between parts of a series.
    pub fn points(&self) -> impl Iterator<Item = &Point> {
        self.series.iter().flat_map(|series| &series.points)
    }

    pub fn table(&self) -> Table {
        let header = |name: &str, unit: &str| Header { name: name.into(), unit: unit.into() };
        let [x, y] = [&self.x, &self.y];
        let mut headers = vec![header("series", ""), header(&x.label, &x.unit), header(&y.label, &y.unit)];
        let bars = self.points().any(|point| point.bar.is_some());
        if bars {
            headers.extend(["low", "high"].map(|name| header(name, &y.unit)));
        }
        let row = |series: &Series, point: &Point| {
            let mut row = vec![series.name.as_str().into(), Cell::Number(point.x), Cell::Number(point.y)];
            if bars {
                row.extend(point.bar.map_or([Cell::Empty, Cell::Empty], |bar| bar.map(Cell::Number)));
            }
            row
        };
        let rows =
            self.series.iter().flat_map(|one| one.values().map(move |point| row(one, point))).collect();
        Table { caption: self.title.clone(), headers, rows }
    }

    /// Its points as CSV: a line each, with the name of its series; empty where a number is missing.
    pub fn csv(&self) -> String {
        let quoted = |text: &str| {
            let special = text.contains([',', '"', '\n']);
            if special { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
        };
        let cell = |cell: &Cell| match cell {
            Cell::Text(text) => quoted(text),
            Cell::Number(number) if number.is_finite() => number.to_string(),
            _ => String::new(),
        };
        let Table { headers, rows, .. } = self.table();
        let bars = if headers.len() > 3 { ",low,high" } else { "" };
        let mut text = format!("series,{},{}{bars}\n", quoted(&self.x.text()), quoted(&self.y.text()));
        for row in rows {
            text += &(row.iter().map(cell).collect::<Vec<_>>().join(",") + "\n");
        }
        text
    }

    /// How many points are missing or have no place on a logarithmic axis, as a sentence.
    pub fn undrawn(&self) -> Option<String> {
        let lost = |value: f64, log: bool| !value.is_finite() || (log && value <= 0.0);
        let points = self.series.iter().flat_map(Series::values);
        let count = points.filter(|point| lost(point.x, self.x.log) || lost(point.y, self.y.log)).count();
        let log = if self.x.log || self.y.log { ", or not above zero on a logarithmic axis" } else { "" };
        (count > 0)
            .then(|| format!("Not drawn, missing or not finite{log}: {}.", number::counted(count, "point")))
    }
}

impl Series {
    /// A series of x and y; the longer one is cut.
    pub fn new(name: impl Into<String>, mark: Mark, style: usize, x: &[f64], y: &[f64]) -> Self {
        let mut series = Self { name: name.into(), mark, style, points: Vec::new() };
        series.append(x, y);
        series
    }

    pub fn points(name: impl Into<String>, style: usize, x: &[f64], y: &[f64]) -> Self {
        Self::new(name, Mark::Points, style, x, y)
    }

    /// Adds points, after a gap where there are others already.
    pub fn append(&mut self, x: &[f64], y: &[f64]) {
        if !self.points.is_empty() {
            self.points.push(Point { x: f64::NAN, y: f64::NAN, bar: None });
        }
        self.points.extend(x.iter().zip(y).map(|(x, y)| Point { x: *x, y: *y, bar: None }));
    }

    /// Its points without the gaps between its parts.
    pub fn values(&self) -> impl Iterator<Item = &Point> {
        self.points.iter().filter(|point| !(point.x.is_nan() && point.y.is_nan()))
    }

    pub fn with_std(mut self, std: &[f64]) -> Self {
        for (point, std) in self.points.iter_mut().zip(std) {
            point.bar = Some([point.y - std, point.y + std]);
        }
        self
    }

    pub fn between(mut self, low: &[f64], high: &[f64]) -> Self {
        for (point, (low, high)) in self.points.iter_mut().zip(low.iter().zip(high)) {
            point.bar = Some([*low, *high]);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_quoted_and_gaps_empty() {
        let plot = Plot::new("p", "P")
            .axes("t [s]", "B [nT]")
            .with(Series::new("a, \"b\"", Mark::Line, 0, &[0.5, 1.0], &[f64::NAN, 2.0]))
            .with(Series::points("c", 0, &[0.0], &[1.0]).with_std(&[0.25]));
        assert_eq!(
            plot.csv(),
            "series,t (s),B (nT),low,high\n\"a, \"\"b\"\"\",0.5,,,\n\"a, \"\"b\"\"\",1,2,,\nc,0,1,0.75,1.25\n"
        );
    }
}
