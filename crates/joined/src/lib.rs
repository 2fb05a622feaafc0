//! Several instruments, each in recordings of its own or all in one, on one even grid of times; what cannot
//! be joined is told by its place.
//!
//! Times are never spread: a series is cut where its times jump, and where they are uneven it is read at its
//! own times. The clocks of two instruments may differ, in each [`Segment`] by another offset; that is for
//! those to find who hold the readings against each other.
//!
//! diffmag (`read`), diagnose (`gathered`) and series (`onto`, `read_at`) use this crate. Series are cut
//! where their times jump (`estimate::cadence`; `estimate::even` decides for all stages which times are even)
//! and put on the grid of the slower instrument, by `estimate::resample` where times differ.

use common::number::{counted, duration};
use common::time::Start;
use common::{Axis, Column, Document, Finding, Gap, NoiseOfSensors, Recording, procedure};
use estimate::resample::PASSBAND;
use physics::memory::bridged;

mod beside;
mod check;
mod gather;
mod grid;
mod main_field;
mod piece;
mod reading;

pub use beside::beside;
pub use check::{ALIKE, IN_A_PLANE, in_a_plane, other_units};
pub use common::Error;
pub use gather::{Gathered, gathered};
pub use grid::{Boundary, Segment};
use grid::{Grid, OnGrid};
pub use main_field::state_main_field;
pub use piece::Jump;
use piece::Piece;
pub use reading::{Onto, Reading, Way, onto, read_at, usual_step_s};

type Result<T, E = Error> = std::result::Result<T, E>;

/// Seconds in a day.
pub const DAY_S: f64 = 86_400.0;
/// Fewer samples than these say nothing.
const LEAST: usize = 5;
const NOTHING: &str = "no recording with the procedure `differential`; diffmag needs `reference_x_nt`, … and `test_x_nt`, … of two magnetometers side by side";
/// Names of the instruments, as their columns begin.
const NAMES: [&str; 3] = ["reference", "test", "third"];
/// Readings that are missing stand on straight lines; with more than one in so many missing these would be
/// most of what is fitted.
const WHOLE: usize = 2;

struct Instrument {
    name: &'static str,
    /// In the order of time, without overlap.
    pieces: Vec<Piece>,
}

impl Instrument {
    fn start_s(&self) -> f64 {
        self.pieces[0].start_s
    }

    fn end_s(&self) -> f64 {
        self.pieces[self.pieces.len() - 1].end_s()
    }

    fn longest(&self) -> &Piece {
        let rows = |piece: &&Piece| piece.columns[0].len();
        self.pieces.iter().rev().max_by_key(rows).unwrap_or(&self.pieces[0])
    }

    /// Moments of an even step for which it has rows, at most.
    fn moments(&self, step_s: f64) -> usize {
        self.pieces.iter().map(|piece| ((piece.end_s() - piece.start_s) / step_s).round() as usize + 1).sum()
    }

    fn step_s(&self) -> f64 {
        self.longest().step_s
    }

    fn jumps(&self) -> Vec<Jump> {
        self.pieces.iter().filter_map(|piece| piece.jump.clone()).collect()
    }

    /// Where its times leave rows out, or go on in another recording: whether rows are missing or a clock was
    /// set the times do not say.
    fn pauses(&self) -> Vec<Jump> {
        let next = self.pieces.windows(2).filter(|pair| pair[1].jump.is_none());
        let between = next.map(|pair| {
            let all_s = pair[1].start_s - pair[0].end_s() - pair[1].step_s;
            Jump::pause(&pair[1].id, 0, pair[1].start_s, all_s)
        });
        self.pieces.iter().flat_map(|piece| piece.pauses.clone()).chain(between).collect()
    }

    /// That it has no moment in common with another.
    fn apart_from(&self, other: &Self) -> Error {
        let times = |of: &Self| format!("from {} to {}", duration(of.start_s()), duration(of.end_s()));
        let (one, two) = (times(other), times(self));
        let found = format!("readings of the {} instrument {one}, of the {} {two}", other.name, self.name);
        let expected = "recordings that overlap in time; look at `start` and at the clocks";
        Error::document(format!("{}.columns.time_s", other.pieces[0].path), found, expected)
    }
}

/// The instruments at the same moments.
#[derive(Clone, Debug, Default)]
pub struct Pair {
    /// Ids of the recordings.
    pub recordings: Vec<String>,
    /// Time of the first row, s.
    pub first_s: f64,
    /// From one sample to the next, s.
    pub step_s: f64,
    /// Readings of the reference, nT; rows that are not whole stand on straight lines between those that are.
    pub reference: [Column; 3],
    /// Readings of the test instrument in the same way, nT: three axes, or one magnitude.
    pub test: Vec<Column>,
    /// Readings of a third instrument on straight lines over its own gaps, nT.
    pub third: Option<[Column; 3]>,
    /// Noise of the reference, where a recording declares it.
    pub reference_noise: Option<NoiseOfSensors>,
    /// Rows in which neither reference nor test misses a reading.
    pub whole: Vec<bool>,
    /// Where an instrument went through a filter: above this frequency the difference is not what was
    /// recorded, Hz.
    pub highest_hz: Option<f64>,
    /// First rows after the steps that are to be fitted to each test axis, with the standard uncertainties of the
    /// sizes that were taken off in their places, nT.
    pub steps: Vec<Vec<(usize, f64)>>,
    /// Rows between jumps of one instrument's times.
    pub segments: Vec<Segment>,
    /// Where times jump.
    pub boundaries: Vec<Boundary>,
    /// Where the times of one instrument leave rows out, or go on in another recording: a clock may have been
    /// set there.
    pub pauses: Vec<Boundary>,
    /// What was done to bring them together, in words.
    pub told: Vec<Finding>,
}

impl Pair {
    /// How many samples are whole.
    pub fn samples(&self) -> usize {
        self.whole.iter().filter(|whole| **whole).count()
    }

    /// Time of a row, s.
    pub fn time_s(&self, row: usize) -> f64 {
        self.first_s + row as f64 * self.step_s
    }

    /// Times of all rows, s.
    pub fn times_s(&self) -> Vec<f64> {
        (0..self.whole.len()).map(|row| self.time_s(row)).collect()
    }

    /// Time from the middle of the recording, s.
    pub fn since_middle_s(&self, row: usize) -> f64 {
        (row as f64 - 0.5 * (self.whole.len() as f64 - 1.0)) * self.step_s
    }

    /// The same of all rows, days.
    pub fn days(&self) -> Vec<f64> {
        (0..self.whole.len()).map(|row| self.since_middle_s(row) / DAY_S).collect()
    }

    /// The segment of a row.
    pub fn segment(&self, row: usize) -> &Segment {
        let number = self.segments.partition_point(|segment| segment.rows.end <= row);
        &self.segments[number.min(self.segments.len() - 1)]
    }

    /// Time from the middle of the row's segment, s.
    pub fn since_middle_of_segment_s(&self, row: usize) -> f64 {
        let rows = &self.segment(row).rows;
        (row as f64 - 0.5 * ((rows.start + rows.end) as f64 - 1.0)) * self.step_s
    }

    /// Cuts the series at more places: each segment between them has a clock of its own.
    pub fn cut(&mut self, at: Vec<Boundary>) {
        self.boundaries.extend(at);
        self.boundaries.sort_by_key(|boundary| boundary.row);
        self.segments = grid::segments(self.whole.len(), &self.boundaries);
    }

    /// Some rows of reference and test instrument, as one segment.
    pub fn part(&self, rows: std::ops::Range<usize>) -> Self {
        let some = |column: &Column| Column::from(column[rows.clone()].to_vec());
        let steps = |steps: &Vec<(usize, f64)>| {
            let inside = steps.iter().filter(|(step, _)| *step > rows.start && *step < rows.end);
            inside.map(|(step, std)| (step - rows.start, *std)).collect()
        };
        Self {
            first_s: self.time_s(rows.start),
            step_s: self.step_s,
            reference: self.reference.each_ref().map(some),
            test: self.test.iter().map(some).collect(),
            whole: self.whole[rows.clone()].to_vec(),
            highest_hz: self.highest_hz,
            steps: self.steps.iter().map(steps).collect(),
            segments: grid::segments(rows.len(), &[]),
            ..Self::default()
        }
    }

    /// The same without readings: which rows are whole, and when.
    pub fn frame(self) -> Self {
        Self {
            reference: Default::default(),
            test: vec![Column::default(); self.test.len()],
            third: None,
            ..self
        }
    }

    /// The steps of a test axis as columns: 0 before, 1 after.
    pub fn step_columns(&self, axis: usize) -> impl Iterator<Item = Vec<f64>> {
        let rows = self.whole.len();
        self.steps[axis]
            .iter()
            .map(move |(step, _)| (0..rows).map(|row| if row < *step { 0.0 } else { 1.0 }).collect())
    }

    /// Puts the rows that are not whole onto straight lines, all columns alike.
    pub fn bridge(&mut self) {
        if !self.whole.contains(&false) {
            return;
        }
        let rows: Vec<f64> = (0..self.whole.len()).map(|row| row as f64).collect();
        for column in self.reference.iter_mut().chain(&mut self.test) {
            for (value, _) in column.iter_mut().zip(&self.whole).filter(|(_, whole)| !**whole) {
                *value = f64::NAN;
            }
            *column = bridged(&rows, std::mem::take(column).into()).into();
        }
    }

    /// Runs of rows that are not whole.
    pub fn gaps(&self) -> Vec<Gap> {
        let mut gaps = Vec::new();
        let mut row = 0;
        while row < self.whole.len() {
            let samples = self.whole[row..].iter().take_while(|whole| !**whole).count();
            if samples > 0 {
                let (from_s, to_s) = (self.time_s(row), self.time_s(row + samples - 1));
                gaps.push(Gap { from_s, to_s, samples, ..Gap::default() });
            }
            row += samples.max(1);
        }
        gaps
    }
}

/// Reads the differential recordings of a document: both instruments in one, each in its own, several pieces
/// of each.
pub fn read(document: &Document) -> Result<Pair> {
    let found = of_procedure(document, procedure::DIFFERENTIAL);
    let (first, _) = *found.first().ok_or_else(|| Error::Request(NOTHING.into()))?;
    let start = earliest(&found)?;
    let mut instruments = NAMES.map(|name| Instrument { name, pieces: Vec::new() });
    for (index, recording) in &found {
        let path = format!("recordings[{index}]");
        let time = times(recording, &path, start)?;
        if !NAMES.iter().any(|name| reads(recording, name)) {
            let expected = "`reference_x_nt`, … or `test_x_nt`, …: the readings of an instrument";
            return Err(Error::document(format!("{path}.columns"), "no such column", expected));
        }
        for Instrument { name, pieces } in &mut instruments {
            if reads(recording, name) {
                let columns = Axis::ALL.map(|axis| {
                    let column = format!("{name}_{axis}_nt");
                    let expected = format!("`{column}`, the readings of the {name} instrument along {axis}");
                    (column, expected)
                });
                pieces.extend(Piece::of(recording, &path, &columns, &time)?);
            }
        }
    }
    instruments.iter_mut().try_for_each(order)?;
    for Instrument { name, pieces } in &instruments[..2] {
        if pieces.is_empty() {
            let expected =
                format!("`{name}_x_nt`, … of the {name} instrument, in this recording or in one of its own");
            return Err(Error::document(format!("recordings[{first}].columns"), "no such column", expected));
        }
    }
    join(&found, &instruments)
}

/// The recordings of a procedure, with their places in the document.
fn of_procedure<'a>(document: &'a Document, procedure: &str) -> Vec<(usize, &'a Recording)> {
    let all = document.recordings.iter().enumerate();
    all.filter(|(_, recording)| recording.procedure == procedure).collect()
}

/// Whether a recording has readings of an instrument.
fn reads(recording: &Recording, instrument: &str) -> bool {
    Axis::ALL.into_iter().any(|axis| recording.axis_column(instrument, axis, "nt").is_some())
}

/// The earliest `start`. Recordings on a clock of the day and on the campaign's clock do not go together.
fn earliest(found: &[(usize, &Recording)]) -> Result<Option<Start>> {
    let with = found.iter().find(|(_, recording)| recording.start().is_some());
    let without = found.iter().find(|(_, recording)| recording.start().is_none());
    if let (Some((with, _)), Some((without, _))) = (with, without) {
        let message = format!("no such key, where recordings[{with}] has one");
        let expected =
            "`start` in all recordings that are joined or in none: else their times have no common zero";
        return Err(Error::document(format!("recordings[{without}].start"), message, expected));
    }
    let starts = found.iter().filter_map(|(_, recording)| recording.start());
    Ok(starts.min_by(|a, b| a.unix_s.total_cmp(&b.unix_s)))
}

/// The times of a recording that is long enough for a fit, from the common zero.
fn times(recording: &Recording, path: &str, zero: Option<Start>) -> Result<Vec<f64>> {
    recording.at_hand(path)?;
    let rows = recording.rows();
    if rows < LEAST {
        let found = counted(rows, "row");
        let expected = "at least five: a regression has four unknowns for each axis";
        return Err(Error::document(format!("{path}.columns"), found, expected));
    }
    let origin_s = recording.start().zip(zero).map_or(0.0, |(own, zero)| own.unix_s - zero.unix_s);
    rising(recording, path, origin_s)
}

/// The times of a recording, from the common zero: all there, and rising.
fn rising(recording: &Recording, path: &str, origin_s: f64) -> Result<Vec<f64>> {
    recording.at_hand(path)?;
    let Some(time) = recording.column("time_s") else {
        let expected = "`time_s`: samples are put together by their times";
        return Err(Error::document(format!("{path}.columns"), "no such column", expected));
    };
    let key = format!("{path}.columns.time_s");
    if let Some(row) = time.iter().position(|t| !t.is_finite()) {
        let found = format!("null in row {row}");
        let expected = "a time in every row; leave out rows of which nobody knows when they were";
        return Err(Error::document(key, found, expected));
    }
    if let Some(row) = time.windows(2).position(|pair| pair[1] <= pair[0]) {
        let found = format!("{} after {} in row {}", time[row + 1], time[row], row + 1);
        return Err(Error::document(key, found, "times that rise; sort the rows, and take doubles out"));
    }
    Ok(time.iter().map(|t| t + origin_s).collect())
}

/// Sorts the pieces of an instrument by time and refuses those that overlap.
fn order(instrument: &mut Instrument) -> Result<()> {
    instrument.pieces.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    for pair in instrument.pieces.windows(2) {
        if pair[1].start_s <= pair[0].end_s() {
            let found = format!(
                "readings of the {} instrument from {} on, where {} goes on to {}",
                instrument.name,
                duration(pair[1].start_s),
                pair[0].path,
                duration(pair[0].end_s())
            );
            let expected =
                "pieces of one instrument that follow each other; take out what was recorded twice";
            return Err(Error::document(format!("{}.columns.time_s", pair[1].path), found, expected));
        }
    }
    Ok(())
}

fn join(found: &[(usize, &Recording)], [reference, test, third]: &[Instrument; 3]) -> Result<Pair> {
    let path = &test.pieces[0].path;
    let grid = Grid::of(reference, test).ok_or_else(|| reference.apart_from(test))?;
    let sparse = |together: usize| {
        let found = format!("readings of both instruments at {together} of {} moments", grid.rows);
        let expected = "gaps shorter than what was recorded; keep the longest part without large gaps, or mend a wrong time";
        Error::document(format!("{path}.columns.time_s"), found, expected)
    };
    // Before a place is made for each moment: recordings may lie years apart.
    let most = reference.moments(grid.step_s).min(test.moments(grid.step_s));
    if most.saturating_mul(WHOLE) < grid.rows {
        return Err(sparse(most));
    }
    let boundaries = grid::on_grid(&grid, [reference, test], Instrument::jumps);
    let pauses = grid::on_grid(&grid, [reference, test], Instrument::pauses);
    let paths = [&reference.pieces[0].path, path];
    let reads = [reference, test].map(|instrument| grid.read(instrument));
    let whole = grid.whole(&reads);
    let together = whole.iter().filter(|whole| **whole).count();
    if together < LEAST {
        let found = format!("{} in which both instruments read", counted(together, "row"));
        let expected = "at least five: do the two recordings overlap in time?";
        return Err(Error::document(format!("{path}.columns"), found, expected));
    }
    if together * WHOLE < grid.rows {
        return Err(sparse(together));
    }
    let third = (!third.pieces.is_empty()).then(|| grid.read(third));
    let mut told = reads.iter().chain(&third).flat_map(|read| read.told.clone()).collect::<Vec<_>>();
    // One recording with several instruments says the same of each.
    told.dedup();
    let filtered = reads.iter().any(|read| read.filtered);
    let [reference, test] = reads.map(OnGrid::three);
    check::check(paths, &reference, &test)?;
    let rows: Vec<f64> = (0..grid.rows).map(|row| row as f64).collect();
    let mut pair = Pair {
        recordings: found.iter().map(|(_, recording)| recording.id.clone()).collect(),
        first_s: grid.time_s(0),
        step_s: grid.step_s,
        highest_hz: filtered.then(|| PASSBAND * 0.5 / grid.step_s),
        reference,
        test: test.into(),
        third: third.map(|third| third.three().map(|column| bridged(&rows, column.into()).into())),
        reference_noise: reference_noise(found)?,
        segments: grid::segments(whole.len(), &boundaries),
        boundaries,
        pauses,
        whole,
        steps: vec![Vec::new(); 3],
        told,
    };
    pair.bridge();
    Ok(pair)
}

/// The noise of the reference that a recording declares, which is that of all.
fn reference_noise(found: &[(usize, &Recording)]) -> Result<Option<NoiseOfSensors>> {
    let declared = |(index, recording): &(usize, &Recording)| {
        recording.conditions.reference_noise.clone().map(|noise| (*index, noise))
    };
    let Some((index, noise)) = found.iter().find_map(declared) else { return Ok(None) };
    if let Some(axis) = Axis::ALL.into_iter().find(|axis| noise.of(*axis).is_none()) {
        let expected = "that of each of the reference's three axes, or one for all";
        let key = format!("recordings[{index}].conditions.reference_noise.{axis}");
        return Err(Error::document(key, "no noise", expected));
    }
    Ok(Some(noise))
}
