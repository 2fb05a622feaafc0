//! Two magnetometers over very long series: one pass in bounded memory, and pieces that are joined later to
//! the same answer.
//!
//! T = R η + d as everywhere in this crate. Kept are
//!
//! - a triangular factor of the columns, for least squares ([`estimate::tsqr`]);
//! - the differences of neighbouring blocks of 2^L samples at absolute places (Haar), as sums of their
//!   products by level: they say by octave how the instruments agree and what noise is left, and weigh η;
//! - the means of at most 64 long blocks, which hold what is slower.

mod answer;
mod check;
mod error;
mod fit;
mod grid;
mod memory;
mod moments;
mod noise;
mod octaves;
mod partial;
mod profile;
mod pyramid;
mod slow;
mod tile;

pub use self::partial::Partial;
pub use answer::{answer, document};
pub use error::Error;
use grid::Grid;

use self::partial::Row;
use ::partial::{Covered, Error as Fault, Take};
use tile::TILE;

/// Places of one triangular factorisation, a whole number of tiles.
const LEAF: usize = 1024;

/// Takes a piece of a series row by row.
#[derive(Clone, Debug, Default)]
pub struct Statistics {
    /// From one sample to the next, s; None: found from the first batch.
    step_s: Option<f64>,
    /// The grid, and what was taken on it.
    begun: Option<(Grid, Partial)>,
    rows: u64,
    first: i64,
    last: Option<i64>,
    leaf: i64,
    /// Whole samples of the leaf: places and readings.
    places: Vec<f64>,
    readings: [Vec<f64>; 6],
}

impl Statistics {
    /// Nothing yet, of samples so far apart (s); None: found from the first batch.
    pub fn every(step_s: Option<f64>) -> Self {
        Self { step_s, ..Self::default() }
    }
}

impl Take for Statistics {
    type Partial = Partial;

    /// Takes the next rows: times (s), readings of the reference's x, y, z and of the test instrument's (nT, NaN
    /// where one is missing). A row that lacks a reading is missing for all; places without a row are a gap.
    /// What comes out does not depend on how the rows are cut into batches, once the grid is known. Refuses
    /// columns of unlike length, a time that is missing, off the grid or does not rise, and a first batch
    /// without an even step.
    fn push(&mut self, columns: &[&[f64]]) -> Result<(), Error> {
        let (times, columns) = (columns[0], &columns[1..]);
        let expected = times.len();
        if let Some(odd) = columns.iter().find(|column| column.len() != expected) {
            return Err(Fault::Lengths { found: odd.len(), expected }.into());
        }
        if expected == 0 {
            return Ok(());
        }
        let grid = match (&self.begun, self.step_s) {
            (Some((grid, _)), _) => *grid,
            (None, Some(step_s)) => Grid::of(step_s, times[0])?,
            (None, None) => {
                rising(times)?;
                Grid::found(times)?
            }
        };
        let mut partial = self.begun.take().map_or_else(|| Partial::on(grid), |(_, partial)| partial);
        let mut at = 0;
        let mut taken = Ok(());
        while at < expected && taken.is_ok() {
            let run = self.take_run((grid, &mut partial), &times[at..], columns, at);
            at += run;
            if run == 0 {
                let readings = std::array::from_fn(|i| columns[i][at]);
                taken = self.take((grid, &mut partial), times[at], readings);
                at += 1;
            }
        }
        self.begun = Some((grid, partial));
        taken
    }

    fn finish(mut self) -> Result<Partial, Error> {
        let Some(((_, mut partial), last)) = self.begun.take().zip(self.last) else {
            return Ok(Partial::default());
        };
        self.close(&mut partial, last + 1);
        partial.covered = Covered::of(self.first, last);
        Ok(partial)
    }
}

impl Statistics {
    /// Takes the whole samples at the next places of the leaf, one after the other; gives how many.
    fn take_run(
        &mut self,
        (grid, partial): (Grid, &mut Partial),
        times: &[f64],
        columns: &[&[f64]],
        from: usize,
    ) -> usize {
        let Some(next) = self.last.map(|last| last + 1) else { return 0 };
        let room = ((self.leaf + 1) * LEAF as i64 - next).max(0) as usize;
        let times = &times[..room.min(times.len())];
        let on = |(at, time): (usize, &f64)| grid.holds(*time, next + at as i64);
        let mut run = times.iter().enumerate().position(|at| !on(at)).unwrap_or(times.len());
        for column in columns {
            let rest = &column[from..from + run];
            run = rest.iter().position(|reading| !reading.is_finite()).unwrap_or(run);
        }
        self.places.extend((next..next + run as i64).map(|place| place as f64));
        for (to, column) in self.readings.iter_mut().zip(columns) {
            to.extend_from_slice(&column[from..from + run]);
        }
        partial.samples += run as u64;
        self.rows += run as u64;
        self.last = Some(next + run as i64 - 1);
        run
    }

    fn take(
        &mut self,
        (grid, partial): (Grid, &mut Partial),
        time_s: f64,
        readings: [f64; 6],
    ) -> Result<(), Error> {
        let row = self.rows;
        if !time_s.is_finite() {
            return Err(Fault::NoTime { row }.into());
        }
        let step_s = grid.step_s;
        let place = grid.place(time_s).map_err(|off| Error::OffGrid { row, time_s, off, step_s })?;
        match self.last {
            Some(last) if place <= last => return Err(Fault::Backwards { row, time_s }.into()),
            Some(last) if place > last + 1 => {
                partial.absent += (place - last - 1) as u64;
                partial.gaps += 1;
            }
            Some(_) => {}
            None => {
                self.first = place;
                self.leaf = place.div_euclid(LEAF as i64);
            }
        }
        let leaf = place.div_euclid(LEAF as i64);
        if leaf != self.leaf {
            self.close(partial, (self.leaf + 1) * LEAF as i64);
            let (from, to) = ((self.leaf + 1) * (LEAF / TILE) as i64, leaf * (LEAF / TILE) as i64);
            partial.pyramid.insert_empty(from, to);
            self.leaf = leaf;
        }
        if readings.iter().all(|reading| reading.is_finite()) {
            self.places.push(place as f64);
            self.readings.iter_mut().zip(readings).for_each(|(column, reading)| column.push(reading));
            partial.samples += 1;
        } else {
            partial.missing += 1;
        }
        self.rows += 1;
        self.last = Some(place);
        Ok(())
    }

    /// Ends the leaf, of which the places before `end` are known.
    fn close(&mut self, partial: &mut Partial, end: i64) {
        let start = self.first;
        let readings = self.readings.each_ref().map(|column| column.as_slice());
        partial.factor.push(&[&[self.places.as_slice()], &readings[..]].concat());
        let size = TILE as i64;
        let mut at = 0;
        for tile in self.leaf * (LEAF / TILE) as i64..(self.leaf + 1) * (LEAF / TILE) as i64 {
            let (first, after) = (tile * size, (tile + 1) * size);
            if after <= start || first >= end {
                continue;
            }
            let count =
                self.places[at..].iter().take(TILE).take_while(|place| **place < after as f64).count();
            let rows = at..at + count;
            at += count;
            if count == TILE {
                partial.take_full(tile, readings.map(|column| &column[rows.clone()]));
                continue;
            }
            let rows: Vec<Row> =
                rows.map(|row| Row(self.places[row] as i64, readings.map(|column| column[row]))).collect();
            if start <= first && after <= end {
                partial.take_tile(tile, &rows);
            } else {
                partial.rows.extend(rows);
            }
        }
        self.places.clear();
        self.readings.iter_mut().for_each(Vec::clear);
    }
}

/// Times in which a grid can be looked for.
fn rising(times: &[f64]) -> Result<(), Error> {
    if let Some(row) = times.iter().position(|time| !time.is_finite()) {
        return Err(Fault::NoTime { row: row as u64 }.into());
    }
    match times.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(row) => Err(Fault::Backwards { row: row as u64 + 1, time_s: times[row + 1] }.into()),
        None => Ok(()),
    }
}
