//! Pieces of several instruments on one grid of times.

use common::Column;
use estimate::even::EXACT;
use estimate::resample::PASSBAND;

use super::Instrument;
use super::piece::SAME_RATE;
use crate::words;

/// Even times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// The first, s.
    pub start_s: f64,
    /// From one to the next, s.
    pub step_s: f64,
    /// How many.
    pub rows: usize,
}

/// An instrument on a grid.
pub struct OnGrid<C = Vec<Column>> {
    /// Readings, NaN where missing.
    pub columns: C,
    /// Whether a piece went through the filter.
    pub filtered: bool,
    /// What was done, in words.
    pub told: Vec<String>,
}

impl OnGrid {
    /// That of an instrument with three axes.
    pub fn three(self) -> OnGrid<[Column; 3]> {
        let columns = self.columns.try_into().unwrap_or_default();
        OnGrid { columns, filtered: self.filtered, told: self.told }
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

    /// Time of a row, s.
    pub fn time_s(&self, row: usize) -> f64 {
        self.start_s + row as f64 * self.step_s
    }

    /// The upper end of the band that the filter leaves alone, Hz.
    pub fn passband_hz(&self) -> f64 {
        PASSBAND * 0.5 / self.step_s
    }

    /// An instrument's readings at these times.
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
                told.push(words::filtered(instrument.name, piece.step_s, self.step_s, white));
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
