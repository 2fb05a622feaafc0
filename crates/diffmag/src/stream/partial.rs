use estimate::tsqr::Tsqr;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

use super::moments::{Block, CHANNELS};
use super::profile::Profile;
use super::pyramid::Pyramid;
use super::tile::{self, TILE};
use super::{Error, Grid};

/// What such a file is of.
const KIND: &str = "diffmag";
/// Of the files written here.
const VERSION: u32 = 1;

/// A whole sample of a tile that a piece does not hold whole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row(pub i64, pub [f64; 6]);

/// All that is kept of a piece of a series, whatever its length: 80 kB of JSON at most. Pieces are joined by [`merge`] and answered
/// by [`super::answer`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Partial {
    /// What kind of piece this is: `diffmag`.
    #[serde(rename = "fluxcal-partial")]
    pub kind: String,
    /// Version of the format.
    pub version: u32,
    /// Where the samples stand.
    pub grid: Grid,
    /// First and last place of each stretch of time that is covered; what is missing within is missing for good.
    pub covered: Vec<[i64; 2]>,
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

impl Partial {
    /// A piece without samples.
    pub(super) fn new(grid: Grid) -> Self {
        Partial {
            kind: KIND.into(),
            version: VERSION,
            grid,
            covered: Vec::new(),
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

    /// Reads a piece from JSON.
    ///
    /// # Errors
    ///
    /// [`Error::Format`] for a text that is none, of another kind or of a later version.
    pub fn parse(text: &str) -> Result<Self, Error> {
        #[derive(Deserialize)]
        struct Head {
            #[serde(rename = "fluxcal-partial")]
            kind: String,
            version: u32,
        }
        let failed = |error: common::Error| Error::Format(error.to_string());
        let head: Head = common::at_path(text).map_err(failed)?;
        if head.kind != KIND || head.version != VERSION {
            let Head { kind, version } = head;
            return Err(Error::Format(format!(
                "found `{kind}` in version {version}, expected `{KIND}` in version {VERSION}"
            )));
        }
        let read: Partial = common::at_path(text).map_err(failed)?;
        let sums = read.factor.is_whole(CHANNELS) && read.pyramid.is_whole() && read.profile.is_whole();
        if !sums || !read.covered.iter().flatten().is_sorted() {
            return Err(Error::Format(
                "its sums are not those of such a piece, or what it covers does not rise; was it edited?"
                    .into(),
            ));
        }
        Ok(read)
    }

    /// The piece as JSON, each number so that it comes back the same.
    pub fn to_text(&self) -> String {
        serde_json::to_string(self).expect("a piece has string keys")
    }

    /// Times of the first and the last place that are covered, s.
    pub fn span_s(&self) -> Option<[f64; 2]> {
        let (first, last) = (self.covered.first()?, self.covered.last()?);
        Some([self.grid.time_s(first[0]), self.grid.time_s(last[1])])
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

/// Joins pieces of one series, in any order; between them there may be holes, which other pieces fill later.
///
/// Blocks of the pyramid stand at absolute places and their sums keep the rounding, so that the pieces' answer is that of one
/// pass but for the order in which the triangular factors are put together.
///
/// # Errors
///
/// [`Error::Empty`] of none, [`Error::Unlike`] for other grids, [`Error::Overlap`] where two pieces cover the same place.
pub fn merge(mut pieces: Vec<Partial>) -> Result<Partial, Error> {
    pieces.sort_by_key(|piece| piece.covered.first().copied());
    let grid = pieces.first().ok_or(Error::Empty)?.grid;
    if let Some(other) = pieces.iter().find(|piece| piece.grid != grid) {
        return Err(Error::Unlike(grid.to_string(), other.grid.to_string()));
    }
    let mut ranges: Vec<[i64; 2]> = pieces.iter().flat_map(|piece| &piece.covered).copied().collect();
    ranges.sort_unstable();
    let mut merged = Partial::new(grid);
    for [first, last] in &ranges {
        match merged.covered.last_mut() {
            Some(before) if *first <= before[1] => {
                let (from_s, to_s) = (grid.time_s(*first), grid.time_s(before[1].min(*last)));
                return Err(Error::Overlap { from_s, to_s });
            }
            Some(before) if *first == before[1] + 1 => before[1] = *last,
            _ => merged.covered.push([*first, *last]),
        }
    }
    let mut rows = Vec::new();
    for piece in pieces {
        merged.samples += piece.samples;
        merged.missing += piece.missing;
        merged.absent += piece.absent;
        merged.gaps += piece.gaps;
        merged.factor.merge(&piece.factor);
        merged.pyramid.merge(piece.pyramid);
        merged.profile.merge(piece.profile);
        rows.extend(piece.rows);
    }
    // Tiles that no piece held whole and that are whole now.
    let size = TILE as i64;
    let mut tiles = by_tile(&rows);
    let ragged = ranges.iter().flat_map(|[first, last]| {
        let [head, tail] = [first.div_euclid(size), last.div_euclid(size)];
        [(first.rem_euclid(size) != 0).then_some(head), ((last + 1).rem_euclid(size) != 0).then_some(tail)]
    });
    for tile in ragged.flatten().collect::<BTreeSet<i64>>() {
        if merged.covered.iter().any(|[first, last]| *first <= tile * size && (tile + 1) * size - 1 <= *last)
        {
            merged.take_tile(tile, &tiles.remove(&tile).unwrap_or_default());
        }
    }
    merged.rows = tiles.into_values().flatten().collect();
    Ok(merged)
}
