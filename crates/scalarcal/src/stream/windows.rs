//! Factors of rows by windows of time, 2^level s wide, at whole multiples of their width.
//!
//! Where there are more windows than are kept, all become twice as wide, and two neighbours at most become
//! one. So the times of the rows alone decide the windows, not their order or pieces.

use serde::{Deserialize, Serialize};

use crate::checks::At;
use crate::terms::Factor;

/// Windows that are kept at most.
const MOST: usize = 64;
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
    pub place: i64,
    pub at: At,
    /// First and last moment, s.
    pub span_s: [f64; 2],
    pub factor: Factor,
}

impl Window {
    fn key(&self) -> (i64, At) {
        (self.place, self.at)
    }

    pub fn join(&mut self, other: &Self) {
        self.span_s = [self.span_s[0].min(other.span_s[0]), self.span_s[1].max(other.span_s[1])];
        self.factor.join(&other.factor);
    }
}

/// Windows in the order of their places and of the ends at which their rows stand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Windows {
    /// log₂ of the width, s.
    pub level: i32,
    pub windows: Vec<Window>,
    /// Those that are being filled, one of each of the ends: not yet among the others.
    #[serde(skip)]
    open: Vec<Window>,
}

impl Default for Windows {
    fn default() -> Self {
        Self { level: LOWEST, windows: Vec::new(), open: Vec::new() }
    }
}

impl Windows {
    /// Takes a row that is later than all others.
    pub fn row(&mut self, at: At, time_s: f64, products: &[f64]) {
        let place = (time_s * (-f64::from(self.level)).exp2()).floor() as i64;
        let row = products.iter().copied();
        match self.open.iter().position(|window| window.at == at) {
            Some(number) if self.open[number].place == place => {
                self.open[number].span_s[1] = time_s;
                return self.open[number].factor.row(row);
            }
            Some(number) => {
                let before = self.open.swap_remove(number);
                self.close(before);
            }
            None => {}
        }
        let mut factor = Factor::new(products.len());
        factor.row(row);
        self.open.push(Window { place, at, span_s: [time_s, time_s], factor });
        self.widen_to_most();
    }

    /// Puts a window that was filled among the others.
    fn close(&mut self, mut window: Window) {
        window.factor.settle();
        self.windows.push(window);
        self.gather();
    }

    /// The same of all that are being filled.
    pub fn settle(&mut self) {
        self.open.sort_by_key(Window::key);
        std::mem::take(&mut self.open).into_iter().for_each(|window| self.close(window));
    }

    /// Joins what stands at one place and the same ends.
    fn gather(&mut self) {
        self.windows.sort_by_key(Window::key);
        for window in std::mem::take(&mut self.windows) {
            match self.windows.last_mut().filter(|last| last.key() == window.key()) {
                Some(last) => last.join(&window),
                None => self.windows.push(window),
            }
        }
    }

    fn places(&self) -> usize {
        let mut all: Vec<i64> = self.windows.iter().chain(&self.open).map(|window| window.place).collect();
        all.sort_unstable();
        all.dedup();
        all.len()
    }

    fn widen_to_most(&mut self) {
        while self.places() > MOST {
            self.widen();
        }
    }

    /// Makes the windows twice as wide.
    fn widen(&mut self) {
        self.level += 1;
        self.windows.iter_mut().chain(&mut self.open).for_each(|window| window.place >>= 1);
        self.gather();
    }

    /// Rows that no longer stand at some ends, because others go beyond.
    pub fn no_longer(&mut self, ends: At) {
        if ends == 0 {
            return;
        }
        self.windows.iter_mut().for_each(|window| window.at &= !ends);
        self.gather();
        self.open.sort_by_key(|window| window.at);
        let (moved, open): (Vec<Window>, _) =
            std::mem::take(&mut self.open).into_iter().partition(|one| one.at & ends != 0);
        self.open = open;
        for mut window in moved {
            window.at &= !ends;
            match self.open.iter().position(|other| other.at == window.at) {
                Some(number) if self.open[number].place == window.place => self.open[number].join(&window),
                Some(_) => self.close(window),
                None => self.open.push(window),
            }
        }
    }

    pub fn merge(&mut self, mut other: Self) {
        while self.level < other.level {
            self.widen();
        }
        while other.level < self.level {
            other.widen();
        }
        self.windows.append(&mut other.windows);
        self.gather();
        self.widen_to_most();
    }

    /// Whether the parts fit each other and the rows are so many, after reading them from outside.
    pub fn is_whole(&self, columns: usize, rows: u64) -> bool {
        let good = |window: &Window| {
            let [from, to] = window.span_s;
            from <= to && holds(from) && holds(to) && window.factor.is_whole(columns)
        };
        let found = self.windows.iter().try_fold(0u64, |sum, window| sum.checked_add(window.factor.rows));
        (LOWEST..=HIGHEST).contains(&self.level)
            && self.windows.is_sorted_by(|one, next| one.key() < next.key())
            && self.places() <= MOST
            && self.windows.iter().all(good)
            && found == Some(rows)
    }
}
