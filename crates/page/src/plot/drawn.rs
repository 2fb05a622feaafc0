//! What is drawn.

use crate::number;
use crate::table::{Cell, Header, Table};

/// A plot.
#[derive(Clone, Debug, Default)]
pub struct Plot {
    /// Unique within the page, and the name of the file of its data: lower case letters, digits and hyphens.
    pub id: String,
    /// What it shows.
    pub title: String,
    /// The horizontal axis.
    pub x: Dimension,
    /// The vertical axis.
    pub y: Dimension,
    /// What is drawn.
    pub series: Vec<Series>,
    /// What the reader must know of bars and bands.
    pub note: String,
    /// One step along x is as long as one along y: maps.
    pub map: bool,
}

/// An axis of a plot.
#[derive(Clone, Debug, Default)]
pub struct Dimension {
    /// What runs along it.
    pub label: String,
    /// Its unit; empty where it has none.
    pub unit: String,
    /// Whether it is logarithmic.
    pub log: bool,
}

/// Points that belong together.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// How it is drawn.
    pub mark: Mark,
    /// Number of its colour and shape; the axes x, y and z have 0, 1 and 2.
    pub style: usize,
    /// The points.
    pub points: Vec<Point>,
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
    /// Along the horizontal axis.
    pub x: f64,
    /// Along the vertical axis.
    pub y: f64,
    /// Ends of its bar or band.
    pub bar: Option<[f64; 2]>,
}

/// Parts a line: nothing is missing here.
const GAP: Point = Point { x: f64::NAN, y: f64::NAN, bar: None };

impl Dimension {
    /// A linear axis.
    pub fn linear(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), unit: unit.into(), log: false }
    }

    /// A logarithmic axis.
    pub fn log(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { log: true, ..Self::linear(label, unit) }
    }

    /// Label and unit.
    pub fn text(&self) -> String {
        if self.unit.is_empty() { self.label.clone() } else { format!("{} ({})", self.label, self.unit) }
    }
}

impl Plot {
    /// A plot without series as yet.
    pub fn new(id: impl Into<String>, title: impl Into<String>, x: Dimension, y: Dimension) -> Self {
        Self { id: id.into(), title: title.into(), x, y, ..Self::default() }
    }

    /// With a note below it.
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }

    /// Adds a series, unless it has no points.
    pub fn push(&mut self, series: Series) {
        if !series.points.is_empty() {
            self.series.push(series);
        }
    }
}

impl Series {
    /// A series of x and y; the longer one is cut.
    pub fn new(name: impl Into<String>, mark: Mark, style: usize, x: &[f64], y: &[f64]) -> Self {
        let points = x.iter().zip(y).map(|(x, y)| Point { x: *x, y: *y, bar: None }).collect();
        Self { name: name.into(), mark, style, points }
    }

    /// Adds points after a gap.
    pub fn append(&mut self, x: &[f64], y: &[f64]) {
        if !self.points.is_empty() {
            self.points.push(GAP);
        }
        self.points.extend(x.iter().zip(y).map(|(x, y)| Point { x: *x, y: *y, bar: None }));
    }

    /// Its points without the gaps between its parts.
    pub fn values(&self) -> impl Iterator<Item = &Point> {
        self.points.iter().filter(|point| !(point.x.is_nan() && point.y.is_nan()))
    }

    /// With bars of ± one standard uncertainty.
    pub fn with_std(mut self, std: &[f64]) -> Self {
        for (point, std) in self.points.iter_mut().zip(std) {
            point.bar = Some([point.y - std, point.y + std]);
        }
        self
    }

    /// With bars or a band between two limits.
    pub fn between(mut self, low: &[f64], high: &[f64]) -> Self {
        for (point, (low, high)) in self.points.iter_mut().zip(low.iter().zip(high)) {
            point.bar = Some([*low, *high]);
        }
        self
    }
}

impl Plot {
    /// Its points as a table.
    pub fn table(&self) -> Table {
        let mut headers = vec![
            Header { name: "series".into(), unit: String::new() },
            Header { name: self.x.label.clone(), unit: self.x.unit.clone() },
            Header { name: self.y.label.clone(), unit: self.y.unit.clone() },
        ];
        let bars = self.series.iter().flat_map(|series| &series.points).any(|point| point.bar.is_some());
        if bars {
            headers
                .extend(["low", "high"].map(|name| Header { name: name.into(), unit: self.y.unit.clone() }));
        }
        let mut rows = Vec::new();
        for series in &self.series {
            for point in series.values() {
                let mut row = vec![series.name.as_str().into(), point.x.into(), point.y.into()];
                if bars {
                    row.extend(point.bar.map_or([Cell::Empty, Cell::Empty], |bar| bar.map(Cell::Number)));
                }
                rows.push(row);
            }
        }
        Table { caption: self.title.clone(), headers, rows }
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
