use estimate::tsqr::Tsqr;
use partial::{Covered, MOST};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

use super::error::Error;
use super::grid::Grid;
use super::moments::{Block, CHANNELS};
use super::profile::Profile;
use super::pyramid::Pyramid;
use super::tile::{self, TILE};

/// A whole sample of a tile that a piece does not hold whole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row(pub i64, pub [f64; 6]);

/// All that is kept of a piece of a series, whatever its length: 80 kB of JSON at most where nothing is left
/// open, 10 kB more for each hole that another piece may fill. Pieces are joined by [`partial::merge`] and
/// answered by [`super::answer`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Partial {
    /// Where the samples stand; absent: there are none, and any grid will do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) grid: Option<Grid>,
    /// First and last place of each stretch of time that is covered; what is missing within is missing for
    /// good.
    pub(super) covered: Covered<i64>,
    /// Whole samples.
    pub samples: u64,
    /// Rows that lack a reading.
    pub missing: u64,
    /// Places without a row, within what is covered.
    pub absent: u64,
    /// Runs of such places.
    pub gaps: u64,
    /// Places, reference and test, for least squares.
    pub(super) factor: Tsqr,
    pub(super) pyramid: Pyramid,
    pub(super) profile: Profile,
    /// Samples of tiles at the ends of what is covered.
    pub(super) rows: Vec<Row>,
}

impl Default for Partial {
    /// A piece without rows, which changes none that it is joined with.
    fn default() -> Self {
        Partial {
            grid: None,
            covered: Covered::default(),
            samples: 0,
            missing: 0,
            absent: 0,
            gaps: 0,
            factor: Tsqr::new(CHANNELS),
            pyramid: Pyramid::default(),
            profile: Profile::default(),
            rows: Vec::new(),
        }
    }
}

impl partial::Partial for Partial {
    const KIND: &'static str = "diffmag";
    const VERSION: u32 = 2;
    type Error = Error;

    fn is_whole(&self) -> bool {
        self.factor.is_whole(CHANNELS)
            && self.pyramid.is_whole()
            && self.profile.is_whole()
            && self.covered.is_whole()
            && self.grid.is_some() != self.covered.span().is_none()
    }

    fn first_s(&self) -> Option<f64> {
        Some(self.span_s()?[0])
    }

    /// Blocks of the pyramid stand at absolute places and their sums keep the rounding, so that the pieces'
    /// answer is that of one pass but for the order in which the triangular factors are put together.
    fn join(&mut self, other: Self) -> Result<(), Error> {
        let (Some(grid), Some(theirs)) = (self.grid, other.grid) else {
            if self.grid.is_none() {
                *self = other;
            }
            return Ok(());
        };
        if grid != theirs {
            return Err(grid.unlike(theirs));
        }
        let ends: Vec<[i64; 2]> =
            self.covered.stretches().iter().chain(other.covered.stretches()).copied().collect();
        self.covered.merge(&other.covered).map_err(|both| {
            let [from_s, to_s] = both.map(|place| grid.time_s(place));
            partial::Error::Overlap { from_s, to_s }
        })?;
        self.samples += other.samples;
        self.missing += other.missing;
        self.absent += other.absent;
        self.gaps += other.gaps;
        self.factor.merge(&other.factor);
        self.pyramid.merge(other.pyramid);
        self.profile.merge(other.profile);
        self.rows.extend(other.rows);
        self.settle(&ends);
        self.close_to(MOST);
        Ok(())
    }
}

impl Partial {
    /// A piece of a grid, without samples so far.
    pub(super) fn on(grid: Grid) -> Self {
        Partial { grid: Some(grid), ..Self::default() }
    }

    /// Times of the first and the last place that are covered, s.
    pub fn span_s(&self) -> Option<[f64; 2]> {
        let grid = self.grid?;
        Some(self.covered.span()?.map(|place| grid.time_s(place)))
    }

    /// The same with its holes closed: what is missing there is missing for good, as it is within a piece.
    pub(super) fn closed(&self) -> Self {
        let mut closed = self.clone();
        closed.close_to(1);
        closed
    }

    /// Closes holes, the shortest first, until so many stretches are left.
    fn close_to(&mut self, most: usize) {
        let size = TILE as i64;
        let mut ends = Vec::new();
        while let Some([before, after]) = self.covered.close(most) {
            self.absent += (after - before - 1) as u64;
            self.gaps += 1;
            self.pyramid.insert_empty(before.div_euclid(size) + 1, after.div_euclid(size));
            ends.extend([[after, before]]);
        }
        self.settle(&ends);
    }

    /// Takes the tiles that no piece held whole and that are whole now: tiles at the beginning or the end of
    /// stretches that have grown together.
    fn settle(&mut self, stretches: &[[i64; 2]]) {
        let size = TILE as i64;
        let ragged = stretches.iter().flat_map(|[first, last]| {
            let [head, tail] = [first.div_euclid(size), last.div_euclid(size)];
            [
                (first.rem_euclid(size) != 0).then_some(head),
                ((last + 1).rem_euclid(size) != 0).then_some(tail),
            ]
        });
        let ragged: BTreeSet<i64> = ragged.flatten().filter(|tile| self.is_covered(*tile)).collect();
        if ragged.is_empty() {
            return;
        }
        let of = |row: &Row| row.0.div_euclid(size);
        let (rows, left) =
            std::mem::take(&mut self.rows).into_iter().partition(|row| ragged.contains(&of(row)));
        self.rows = left;
        let mut tiles = by_tile(&rows);
        for tile in ragged {
            self.take_tile(tile, &tiles.remove(&tile).unwrap_or_default());
        }
    }

    fn is_covered(&self, tile: i64) -> bool {
        let [first, last] = [tile * TILE as i64, (tile + 1) * TILE as i64 - 1];
        let stretches = self.covered.stretches();
        let at = stretches.partition_point(|stretch| stretch[1] < last);
        stretches.get(at).is_some_and(|stretch| stretch[0] <= first)
    }

    /// Takes the samples of a tile that is known whole.
    pub(super) fn take_tile(&mut self, tile: i64, rows: &[Row]) {
        let Some((first, last)) = rows.first().zip(rows.last()) else {
            return self.pyramid.insert_empty(tile, tile + 1);
        };
        let mut block = Block::default();
        if rows.len() == TILE {
            let mut columns = [[0.0; TILE]; 6];
            for (at, row) in rows.iter().enumerate() {
                (0..6).for_each(|i| columns[i][at] = row.1[i]);
            }
            return self.take_full(tile, columns.each_ref().map(|column| column.as_slice()));
        }
        let mut rest = rows.iter().peekable();
        for place in tile * TILE as i64..(tile + 1) * TILE as i64 {
            let row = rest.next_if(|row| row.0 == place);
            let sample = row.map(|row| Block::sample(place, row.1)).unwrap_or_default();
            block.add(&sample);
            self.pyramid.insert(0, place, sample);
        }
        self.profile.add(first.0, last.0, &block);
    }

    /// The same of a tile that has all samples, column by column.
    pub(super) fn take_full(&mut self, tile: i64, readings: [&[f64]; 6]) {
        let first = tile * TILE as i64;
        self.pyramid.levels_to(tile::TILE_LEVELS);
        let block = tile::full(first, readings, &mut self.pyramid.levels);
        self.profile.add(first, first + TILE as i64 - 1, &block);
        self.pyramid.insert(tile::TILE_LEVELS as u8, tile, block);
    }

    /// The profile with the samples at the ends.
    pub(super) fn whole_profile(&self) -> Profile {
        let mut profile = self.profile.clone();
        for (_, rows) in by_tile(&self.rows) {
            let mut block = Block::default();
            rows.iter().for_each(|row| block.add(&Block::sample(row.0, row.1)));
            profile.add(rows[0].0, rows[rows.len() - 1].0, &block);
        }
        profile
    }
}

/// Rows in order, by their tile.
fn by_tile(rows: &[Row]) -> BTreeMap<i64, Vec<Row>> {
    let mut tiles = BTreeMap::<i64, Vec<Row>>::new();
    rows.iter().for_each(|row| tiles.entry(row.0.div_euclid(TILE as i64)).or_default().push(*row));
    tiles.values_mut().for_each(|rows| rows.sort_by_key(|row| row.0));
    tiles
}
