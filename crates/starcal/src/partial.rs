//! What is kept of a flight, whatever its length: products of the rows, by windows of time, cameras, directions and
//! places, so that weights and terms can be chosen after the rows have gone.

use estimate::linear::gram;
use faer::{Mat, MatRef};
use partial::{Covered, MOST, Sample};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use crate::layout::{CAMERAS, Layout};

/// Most windows; when there are more, all become twice as wide.
const WINDOWS: usize = 64;
/// Width of the first ones, 2^k s: more than an orbit.
const FIRST: u32 = 13;
/// Where a row was taken: quiet, and polar or disturbed.
pub const PLACES: usize = 2;
/// Delays: of the readings, of the attitudes, and of the Earth's rotation.
pub const DELAYS: usize = 3;
/// Along the field, across it and the camera's boresight, and across both.
pub const DIRECTIONS: usize = 3;

/// A row of the sample: time, s; readings, nT; the first camera's quaternion; the field in GEO, ITRF and ICRF, nT.
pub const WIDTH: usize = 17;
const KEPT: usize = 256;

/// Why rows cannot be taken, or pieces not be joined.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum Error {
    #[error(transparent)]
    Piece(#[from] partial::Error),
    #[error("row {row}: found {found}; expected {expected}")]
    NoField { row: u64, found: String, expected: String },
}

impl common::Told for Error {}

/// Products of the rows of one camera, direction and kind of place: the lower triangle, column by column.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Products {
    pub rows: f64,
    sums: Vec<f64>,
}

impl Products {
    /// Adds rows of `width` numbers each.
    pub fn add(&mut self, rows: &[f64], width: usize) {
        let count = rows.len() / width;
        if count == 0 {
            return;
        }
        let gram = gram(MatRef::from_row_major_slice(rows, count, width));
        let own = (0..width).flat_map(|j| (j..width).map(move |i| (i, j)));
        self.sums.resize(width * (width + 1) / 2, 0.0);
        self.sums.iter_mut().zip(own).for_each(|(sum, (i, j))| *sum += gram[(i, j)]);
        self.rows += count as f64;
    }

    fn join(&mut self, other: &Self) {
        self.rows += other.rows;
        self.sums.resize(self.sums.len().max(other.sums.len()), 0.0);
        self.sums.iter_mut().zip(&other.sums).for_each(|(sum, more)| *sum += more);
    }

    /// The square of a combination of the columns, summed over the rows.
    pub fn squares(&self, of: &[f64]) -> f64 {
        let width = of.len();
        let places = (0..width).flat_map(|j| (j..width).map(move |i| (i, j)));
        let sums = self.sums.iter().zip(places);
        sums.map(|(sum, (i, j))| sum * of[i] * of[j] * if i == j { 1.0 } else { 2.0 }).sum()
    }

    pub fn add_to(&self, sum: &mut Mat<f64>, weight: f64) {
        let width = sum.ncols();
        let places = (0..width).flat_map(|j| (j..width).map(move |i| (i, j)));
        for (value, (i, j)) in self.sums.iter().zip(places) {
            sum[(i, j)] += weight * value;
            if i != j {
                sum[(j, i)] += weight * value;
            }
        }
    }
}

/// Products of a window, by camera, kind of place and direction.
pub type Window = Vec<[[Products; DIRECTIONS]; PLACES]>;

/// All that is kept of a piece of a flight.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Partial {
    pub(crate) layout: Layout,
    /// What is covered, s.
    pub(crate) covered: Covered<f64>,
    /// Rows that are used, that lack a value, that no camera saw, and of which an attitude or the magnitude is none.
    pub(crate) rows: u64,
    pub(crate) missing: u64,
    pub(crate) blind: u64,
    pub(crate) odd: u64,
    /// Width of the windows, 2^k s.
    exponent: u32,
    windows: BTreeMap<i64, Window>,
    /// A few rows, by which mistakes of the attitude are known.
    pub(crate) sample: Sample<WIDTH, KEPT>,
}

impl Partial {
    pub(crate) fn new(layout: Layout) -> Self {
        Self { layout, exponent: FIRST, ..Self::default() }
    }

    /// The number of coefficients of a camera and what they are to explain: the vectors of all signals, the delays and
    /// the field.
    pub(crate) fn width(&self, camera: usize) -> usize {
        3 * self.layout.signals(camera).len() + DELAYS + 1
    }

    pub(crate) fn width_s(&self) -> f64 {
        2f64.powi(self.exponent as i32)
    }

    pub(crate) fn window(&self, time_s: f64) -> i64 {
        (time_s / self.width_s()).floor() as i64
    }

    /// The windows with the middle of each, s.
    pub(crate) fn windows(&self) -> impl Iterator<Item = (f64, &Window)> {
        let width = self.width_s();
        self.windows.iter().map(move |(at, window)| ((*at as f64 + 0.5) * width, window))
    }

    /// The products of a window, which is made where there is none.
    pub(crate) fn at(&mut self, window: i64) -> &mut Window {
        let cameras = self.layout.cameras.len();
        self.windows.entry(window).or_insert_with(|| vec![Default::default(); cameras])
    }

    /// Makes windows wider until there are not too many.
    pub(crate) fn settle(&mut self) {
        while self.windows.len() > WINDOWS {
            self.widen();
        }
    }

    fn widen(&mut self) {
        self.exponent += 1;
        for (at, window) in std::mem::take(&mut self.windows) {
            add(self.windows.entry(at.div_euclid(2)).or_default(), &window);
        }
    }
}

fn add(window: &mut Window, other: &Window) {
    window.resize(window.len().max(other.len()), Default::default());
    for (mine, other) in window.iter_mut().flatten().flatten().zip(other.iter().flatten().flatten()) {
        mine.join(other);
    }
}

impl partial::Partial for Partial {
    const KIND: &'static str = "starcal";
    const VERSION: u32 = 1;
    type Error = Error;

    fn is_whole(&self) -> bool {
        let widths: Vec<usize> = (0..self.layout.cameras.len()).map(|camera| self.width(camera)).collect();
        let products = |one: &Products, width: usize| {
            let count = if one.rows > 0.0 { width * (width + 1) / 2 } else { 0 };
            one.sums.len() == count && one.rows.is_finite() && one.sums.iter().all(|sum| sum.is_finite())
        };
        let cameras = &self.layout.cameras;
        !cameras.is_empty()
            && cameras.iter().all(|camera| (1..=CAMERAS).contains(camera))
            && self.covered.is_whole()
            && self.sample.is_whole()
            && (FIRST..64).contains(&self.exponent)
            && self.windows.values().all(|window| {
                window.len() == widths.len()
                    && window
                        .iter()
                        .zip(&widths)
                        .all(|(camera, width)| camera.iter().flatten().all(|one| products(one, *width)))
            })
    }

    fn first_s(&self) -> Option<f64> {
        Some(self.covered.span()?[0])
    }

    fn join(&mut self, mut other: Self) -> Result<(), Error> {
        if self.layout != other.layout {
            let said = |layout: &Layout| {
                format!(
                    "with attitudes from {} and the columns {}",
                    layout.frame.name(),
                    layout.names().join(", ")
                )
            };
            let [first, second] = [&self.layout, &other.layout].map(said);
            return Err(partial::Error::Unlike { first, second, expected: "the same columns in all" }.into());
        }
        let overlap = |[from_s, to_s]: [f64; 2]| partial::Error::Overlap { from_s, to_s };
        self.covered.merge(&other.covered).map_err(overlap)?;
        while self.covered.close(MOST).is_some() {}
        self.rows += other.rows;
        self.missing += other.missing;
        self.blind += other.blind;
        self.odd += other.odd;
        while self.exponent < other.exponent {
            self.widen();
        }
        while other.exponent < self.exponent {
            other.widen();
        }
        for (at, window) in &other.windows {
            add(self.windows.entry(*at).or_default(), window);
        }
        self.settle();
        self.sample.merge(&other.sample);
        Ok(())
    }
}
