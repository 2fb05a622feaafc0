//! Factors of rows by windows of time, 2^level s wide, at whole multiples of their width.
//!
//! Where there are more windows than are kept, all become twice as wide, and two neighbours at most become
//! one. Which windows there are is then decided by the times of the rows alone, whatever their order and the
//! pieces in which they came.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use crate::ends::At;
use crate::factor::Factor;

/// Windows that are kept at most.
pub const MOST: usize = 64;
/// log₂ of the width at the beginning, s.
const LOWEST: i32 = -20;
/// The same at the end, and times that are held, s: a window is then told exactly.
const HIGHEST: i32 = 60;
const FURTHEST_S: f64 = 1e12;

/// Whether a time can be placed in windows of any width.
pub fn holds(time_s: f64) -> bool {
    time_s.abs() < FURTHEST_S
}

/// Rows of a window that stand at the same ends of the sensors' ranges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Window {
    /// First and last moment, s.
    pub span_s: [f64; 2],
    pub factor: Factor,
}

impl Window {
    pub fn join(&mut self, other: &Self) {
        self.span_s = [self.span_s[0].min(other.span_s[0]), self.span_s[1].max(other.span_s[1])];
        self.factor.join(&other.factor);
    }
}

/// Windows by their place and the ends at which their rows stand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Listed", into = "Listed")]
pub struct Closed {
    /// log₂ of the width, s.
    pub level: i32,
    windows: BTreeMap<(i64, At), Window>,
}

/// As they are written.
#[derive(Serialize, Deserialize)]
#[serde(expecting = "an object")]
struct Listed {
    level: i32,
    windows: Vec<Placed>,
}

#[derive(Serialize, Deserialize)]
#[serde(expecting = "an object")]
struct Placed {
    place: i64,
    at: At,
    #[serde(flatten)]
    window: Window,
}

impl From<Listed> for Closed {
    fn from(listed: Listed) -> Self {
        let windows = listed.windows.into_iter().map(|one| ((one.place, one.at), one.window)).collect();
        Self { level: listed.level, windows }
    }
}

impl From<Closed> for Listed {
    fn from(closed: Closed) -> Self {
        let of = |((place, at), window)| Placed { place, at, window };
        Self { level: closed.level, windows: closed.windows.into_iter().map(of).collect() }
    }
}

impl Default for Closed {
    fn default() -> Self {
        Self { level: LOWEST, windows: BTreeMap::new() }
    }
}

impl Closed {
    /// Place, ends at which the rows stand, and the rows of each window, in the order of time.
    pub fn iter(&self) -> impl Iterator<Item = (i64, At, &Window)> {
        self.windows.iter().map(|((place, at), window)| (*place, *at, window))
    }

    fn add(&mut self, key: (i64, At), window: &Window) {
        self.windows.entry(key).and_modify(|own| own.join(window)).or_insert_with(|| window.clone());
    }

    fn places(&self) -> usize {
        let mut before = None;
        self.windows.keys().filter(|(place, _)| before.replace(*place) != Some(*place)).count()
    }

    /// Makes the windows twice as wide.
    fn widen(&mut self) {
        self.level += 1;
        for ((place, at), window) in std::mem::take(&mut self.windows) {
            self.add((place >> 1, at), &window);
        }
    }

    /// Rows that no longer stand at some ends, because others go beyond.
    pub fn no_longer(&mut self, ends: At) {
        for (key, window) in self.windows.extract_if(.., |(_, at), _| *at & ends != 0).collect::<Vec<_>>() {
            self.add((key.0, key.1 & !ends), &window);
        }
    }

    pub fn merge(&mut self, mut other: Self) {
        while self.level < other.level {
            self.widen();
        }
        while other.level < self.level {
            other.widen();
        }
        other.windows.iter().for_each(|(key, window)| self.add(*key, window));
        while self.places() > MOST {
            self.widen();
        }
    }

    /// Whether the parts fit each other and the rows are so many, after reading them from outside.
    pub fn is_whole(&self, columns: usize, rows: u64) -> bool {
        let good = |window: &Window| {
            let [from, to] = window.span_s;
            from <= to && holds(from) && holds(to) && window.factor.is_whole(columns)
        };
        let found = self.windows.values().try_fold(0u64, |sum, window| sum.checked_add(window.factor.rows));
        (LOWEST..=HIGHEST).contains(&self.level)
            && self.places() <= MOST
            && self.windows.values().all(good)
            && found == Some(rows)
    }
}

/// Rows of the window that is being filled.
struct Open {
    place: i64,
    span_s: [f64; 2],
    filling: Factor,
}

impl Open {
    fn take(&mut self, time_s: f64, products: &[f64]) {
        self.span_s[1] = time_s;
        self.filling.row(products.iter().copied());
    }
}

/// Windows that are being filled, with those that are closed.
pub struct Windows {
    columns: usize,
    closed: Closed,
    per_second: f64,
    open: BTreeMap<At, Open>,
}

impl Windows {
    /// None yet, of rows with so many columns.
    pub fn new(columns: usize) -> Self {
        let closed = Closed::default();
        Self { columns, per_second: (-f64::from(closed.level)).exp2(), closed, open: BTreeMap::new() }
    }

    pub fn row(&mut self, at: At, time_s: f64, products: &[f64]) {
        let place = (time_s * self.per_second).floor() as i64;
        match self.open.get_mut(&at) {
            Some(open) if open.place == place => open.take(time_s, products),
            _ => self.begin(at, place, time_s).take(time_s, products),
        }
    }

    /// Closes the window that is filled by rows at some ends, and begins another.
    fn begin(&mut self, at: At, place: i64, time_s: f64) -> &mut Open {
        self.close(at);
        let filling = Factor::new(self.columns);
        self.open.insert(at, Open { place, span_s: [time_s, time_s], filling });
        while self.places() > MOST {
            self.closed.widen();
            self.per_second *= 0.5;
            self.open.values_mut().for_each(|open| open.place >>= 1);
        }
        self.open.get_mut(&at).expect("it was begun")
    }

    fn places(&self) -> usize {
        let mut more: Vec<i64> = self.open.values().map(|open| open.place).collect();
        more.sort_unstable();
        more.dedup();
        let there =
            |place: &&i64| self.closed.windows.range((**place, 0)..=(**place, At::MAX)).next().is_none();
        self.closed.places() + more.iter().filter(there).count()
    }

    fn close(&mut self, at: At) {
        if let Some(Open { place, span_s, filling }) = self.open.remove(&at) {
            self.closed.add((place, at), &Window { span_s, factor: filling.finish() });
        }
    }

    /// Rows that no longer stand at some ends, because another goes beyond.
    pub fn no_longer(&mut self, ends: At) {
        self.closed.no_longer(ends);
        let of: Vec<At> = self.open.keys().copied().filter(|at| at & ends != 0).collect();
        for at in of {
            let Some(open) = self.open.remove(&at) else { continue };
            let left = at & !ends;
            match self.open.get_mut(&left) {
                Some(other) if other.place == open.place => {
                    other.span_s = [other.span_s[0].min(open.span_s[0]), other.span_s[1].max(open.span_s[1])];
                    other.filling.join(&open.filling);
                }
                Some(_) => {
                    let Open { place, span_s, filling } = open;
                    self.closed.add((place, left), &Window { span_s, factor: filling.finish() });
                }
                None => drop(self.open.insert(left, open)),
            }
        }
    }

    pub fn closed(mut self) -> Closed {
        let all: Vec<At> = self.open.keys().copied().collect();
        all.into_iter().for_each(|at| self.close(at));
        self.closed
    }
}
