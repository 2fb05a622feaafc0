//! Pieces of several instruments on one grid of times, and the rows between jumps of their times: in each the
//! two clocks differ by an offset of its own.

use common::number::{bare, significant};
use common::{Code, Column, Finding};
use estimate::even::EXACT;
use std::ops::Range;

use super::Instrument;
use super::piece::{Jump, SAME_RATE};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    pub start_s: f64,
    pub step_s: f64,
    pub rows: usize,
}

/// An instrument on a grid.
pub struct OnGrid {
    /// Readings, NaN where missing.
    pub columns: Vec<Column>,
    /// Whether a piece went through the filter.
    pub filtered: bool,
    /// What was done, in words.
    pub told: Vec<Finding>,
}

impl OnGrid {
    /// The columns of an instrument with three axes.
    pub fn three(self) -> [Column; 3] {
        self.columns.try_into().unwrap_or_default()
    }
}

impl Grid {
    /// The times of the slower of two instruments, of the test instrument where they are as fast, while both
    /// record; None where they never do.
    pub fn of(reference: &Instrument, test: &Instrument) -> Option<Self> {
        let slower = if reference.step_s() > test.step_s() * (1.0 + SAME_RATE) { reference } else { test };
        let piece = slower.longest();
        let from = reference.start_s().max(test.start_s());
        let to = reference.end_s().min(test.end_s());
        let step_s = piece.step_s;
        let first = ((from - piece.start_s) / step_s - EXACT).ceil();
        let last = ((to - piece.start_s) / step_s + EXACT).floor();
        (last >= first).then(|| Self {
            start_s: piece.start_s + first * step_s,
            step_s,
            rows: (last - first) as usize + 1,
        })
    }

    pub fn time_s(&self, row: usize) -> f64 {
        self.start_s + row as f64 * self.step_s
    }

    pub fn whole(&self, reads: &[OnGrid]) -> Vec<bool> {
        let all = |row: usize| reads.iter().flat_map(|read| &read.columns).all(|one| one[row].is_finite());
        (0..self.rows).map(all).collect()
    }

    pub fn read(&self, instrument: &Instrument) -> OnGrid {
        let at: Vec<f64> = (0..self.rows).map(|row| self.time_s(row)).collect();
        let nothing = Column::from(vec![f64::NAN; self.rows]);
        let mut columns = vec![nothing; instrument.longest().columns.len()];
        let (mut told, mut filtered) = (Vec::new(), false);
        for piece in &instrument.pieces {
            told.extend(piece.told.clone());
            let Some(read) = piece.read(&at, self.step_s) else { continue };
            if let Some(white) = read.white_share {
                filtered = true;
                told.push(Code::Filtered.said(format!(
                    "the {} instrument's readings, {} s apart, were filtered to the grid of {} s: {} % of the rms of its white noise passes, and the noise is estimated below 0.9 of half the sampling rate",
                    instrument.name,
                    bare(piece.step_s),
                    bare(self.step_s),
                    significant(100.0 * white, 2)
                )));
            }
            if read.rows == (0..self.rows) {
                columns = read.columns;
                continue;
            }
            for (column, values) in columns.iter_mut().zip(read.columns) {
                column[read.rows.clone()].copy_from_slice(&values);
            }
        }
        told.dedup();
        OnGrid { columns, filtered, told }
    }
}

/// Rows in which no instrument's times jump.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// The rows.
    pub rows: Range<usize>,
    /// How much later the test instrument's times are here than in the segment that all are compared with, s;
    /// zero until somebody finds it.
    pub late_s: f64,
}

/// A jump on the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    /// First row after it.
    pub row: usize,
    /// Name of the instrument whose times jump; None where both have the same times.
    pub instrument: Option<&'static str>,
    /// How.
    pub jump: Jump,
}

/// Where on the grid the times of the reference or the test instrument jump or pause, as `jumps` lists it, in
/// the order of rows.
pub fn on_grid(
    grid: &Grid,
    [reference, test]: [&Instrument; 2],
    jumps: impl Fn(&Instrument) -> Vec<Jump>,
) -> Vec<Boundary> {
    let [of_reference, of_test] = [reference, test].map(jumps);
    let mut found: Vec<Boundary> = Vec::new();
    for (instrument, jumps, others) in
        [(reference.name, &of_reference, &of_test), (test.name, &of_test, &of_reference)]
    {
        for jump in jumps {
            let shared = others.contains(jump);
            let row = ((jump.at_s - grid.start_s) / grid.step_s - EXACT).ceil();
            if !(row > 0.0 && row < grid.rows as f64) || (shared && instrument == test.name) {
                continue;
            }
            let instrument = (!shared).then_some(instrument);
            found.push(Boundary { row: row as usize, instrument, jump: jump.clone() });
        }
    }
    found.sort_by_key(|boundary| boundary.row);
    found
}

/// The rows between jumps that one instrument has and the other has not.
pub fn segments(rows: usize, boundaries: &[Boundary]) -> Vec<Segment> {
    let mut starts: Vec<usize> =
        boundaries.iter().filter(|of| of.instrument.is_some()).map(|of| of.row).collect();
    starts.insert(0, 0);
    starts.dedup();
    let ends: Vec<usize> = starts.iter().skip(1).copied().chain([rows]).collect();
    starts.into_iter().zip(ends).map(|(from, to)| Segment { rows: from..to, late_s: 0.0 }).collect()
}
