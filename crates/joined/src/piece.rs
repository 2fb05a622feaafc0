//! Readings of one instrument that are even in time: one piece of what its logger recorded, from one jump of
//! its times to the next.

use std::ops::Range;

use common::number::{bare, counted, duration, significant};
use common::{Code, Column, Finding, Recording};
use estimate::cadence::Cadence;
use estimate::even::{EXACT, Places};
use estimate::resample::{Resampled, resample};

use super::LEAST;
use crate::{Error, Result};

/// Steps that differ by less than this share are of one rate.
pub const SAME_RATE: f64 = 1e-4;
/// An even grid of more times the recorded rows is not made.
const SPARSE: f64 = 1000.0;

/// Readings of a piece at other times.
pub struct Read {
    /// Which of the times lie within the piece.
    pub rows: Range<usize>,
    /// The columns at these; NaN where missing.
    pub columns: Vec<Column>,
    /// What passed of the rms of white noise, where they went through the filter.
    pub white_share: Option<f64>,
}

/// One instrument in one recording, its times made even.
pub struct Piece {
    pub path: String,
    pub id: String,
    pub start_s: f64,
    pub step_s: f64,
    /// Its columns; NaN where a reading is missing.
    pub columns: Vec<Column>,
    /// What was done to the times, in words.
    pub told: Option<Finding>,
    /// The jump of the times with which it begins.
    pub jump: Option<Jump>,
    /// Where rows of its times are left out.
    pub pauses: Vec<Jump>,
}

impl Piece {
    pub fn end_s(&self) -> f64 {
        self.start_s + self.step_s * (self.columns[0].len() - 1) as f64
    }

    /// Its readings at rising times that are `step_s` apart: as they are where they were taken at these, else
    /// through the filter of the slower of both rates. None where no such time lies within it.
    pub fn read(&self, at: &[f64], step_s: f64) -> Option<Read> {
        let place = |t: &f64| (t - self.start_s) / self.step_s;
        let last = self.columns[0].len() as f64 - 1.0;
        let from = at.partition_point(|t| place(t) < -EXACT);
        let to = at.partition_point(|t| place(t) <= last + EXACT);
        if from >= to {
            return None;
        }
        let places: Vec<f64> = at[from..to].iter().map(place).collect();
        let own = |at: &f64| (at - at.round()).abs() <= EXACT;
        if (self.step_s / step_s - 1.0).abs() < SAME_RATE && places.iter().all(own) {
            let rows = || places.iter().map(|at| at.round().max(0.0) as usize);
            if rows().eq(0..self.columns[0].len()) {
                return Some(Read { rows: from..to, columns: self.columns.clone(), white_share: None });
            }
            let columns = self.columns.iter().map(|column| rows().map(|row| column[row]).collect()).collect();
            return Some(Read { rows: from..to, columns, white_share: None });
        }
        let Resampled { columns, white_share } = resample(&self.columns, &places, step_s / self.step_s);
        let columns = columns.into_iter().map(Column::from).collect();
        Some(Read { rows: from..to, columns, white_share: Some(white_share) })
    }

    /// The columns of these names (each with what is expected where it is missing) of a recording at its
    /// times, cut where these jump.
    pub fn of(
        recording: &Recording,
        path: &str,
        names: &[(String, String)],
        time: &[f64],
    ) -> Result<Vec<Self>> {
        let columns = names.iter().map(|name| column(recording, path, name)).collect::<Result<_, _>>()?;
        cut(time, columns, path, &recording.id)
    }
}

/// The pieces between jumps of the times.
pub fn cut(time: &[f64], columns: Vec<Column>, path: &str, id: &str) -> Result<Vec<Piece>> {
    let Some(cadence) = Cadence::of(time) else {
        return Ok(vec![place(time, columns, path, id)?]);
    };
    let mut pieces = Vec::new();
    for (number, rows) in cadence.segments(time.len()).into_iter().enumerate() {
        // Columns that are not cut stay the recording's own.
        let some = |column: &Column| {
            if rows.len() == time.len() { column.clone() } else { column[rows.clone()].to_vec().into() }
        };
        let jump = number.checked_sub(1).map(|before| &cadence.jumps[before]).map(|jump| Jump {
            recording: id.to_owned(),
            row: jump.row,
            at_s: time[jump.row],
            by_s: jump.by_s,
            std_s: jump.std_s,
            all_s: jump.interval_s - cadence.step_s,
        });
        let pauses = pauses(&time[rows.clone()], rows.start, cadence.step_s, id);
        let piece = place(&time[rows.clone()], columns.iter().map(some).collect(), path, id)?;
        pieces.push(Piece { jump, pauses, ..piece });
    }
    Ok(pieces)
}

/// Intervals of more than one step; `first` is the row of the recording with which these times begin.
fn pauses(time: &[f64], first: usize, step_s: f64, id: &str) -> Vec<Jump> {
    let interval_s = |row: usize| time[row] - time[row - 1];
    let long = |row: &usize| (interval_s(*row) / step_s).round() > 1.0;
    let pause = |row: usize| Jump::pause(id, first + row, time[row], interval_s(row) - step_s);
    (1..time.len()).filter(long).map(pause).collect()
}

/// Rows at their places on an even grid; rows that were never written are missing there.
/// Refused: times with a gap so long that hardly any row of the grid would be a recorded one: a clock that was set.
fn place(time: &[f64], columns: Vec<Column>, path: &str, id: &str) -> Result<Piece> {
    let Some(places) = Places::of(time) else {
        let expected = "at least two times that rise";
        return Err(Error::document(format!("{path}.columns.time_s"), counted(time.len(), "row"), expected));
    };
    if places.count() as f64 > SPARSE * time.len() as f64 {
        let interval = |row: usize| time[row + 1] - time[row];
        let longest = (0..time.len() - 1).max_by(|a, b| interval(*a).total_cmp(&interval(*b))).unwrap_or(0);
        let found = format!(
            "{} from row {longest} to row {} where rows are {} apart",
            duration(interval(longest)),
            longest + 1,
            duration(places.usual_s)
        );
        let expected = "times of one clock; was it set there? Put the rows before and after into recordings of their own";
        return Err(Error::document(format!("{path}.columns.time_s[{}]", longest + 1), found, expected));
    }
    let piece = Piece {
        path: path.to_owned(),
        id: id.to_owned(),
        start_s: places.start_s,
        step_s: places.step_s,
        columns: Vec::new(),
        told: None,
        jump: None,
        pauses: Vec::new(),
    };
    if places.even(EXACT) {
        // Rows that are all there stay the recording's own.
        let put = |column: &Column| places.put(column).into();
        let columns = if places.count() == time.len() { columns } else { columns.iter().map(put).collect() };
        return Ok(Piece { columns, ..piece });
    }
    let step_s = places.mean_step_s(time);
    let columns = columns.iter().map(|column| places.interpolated(time, column, step_s).into()).collect();
    let told = Some(Code::TimesInterpolated.said(format!(
        "\"{id}\": its times are uneven by up to {} s; its readings were interpolated to steps of {} s, which attenuates their noise unevenly",
        significant(places.scatter_s, 2),
        bare(step_s)
    )));
    Ok(Piece { start_s: time[0], step_s, columns, told, ..piece })
}

fn column(recording: &Recording, path: &str, (name, expected): &(String, String)) -> Result<Column> {
    let Some(column) = recording.columns.get(name) else {
        return Err(Error::document(format!("{path}.columns"), "no such column", expected.clone()));
    };
    let known: Vec<f64> = column.iter().copied().filter(|value| value.is_finite()).collect();
    if known.len() < LEAST {
        let found = counted(known.len(), "reading");
        return Err(Error::document(format!("{path}.columns.{name}"), found, "at least five"));
    }
    if known.iter().all(|value| *value == known[0]) {
        let found = format!("the constant reading {}", known[0]);
        let expected = "readings that follow the field; was the instrument connected?";
        return Err(Error::document(format!("{path}.columns.{name}"), found, expected));
    }
    Ok(column.clone())
}

/// A jump of an instrument's times.
#[derive(Clone, Debug, PartialEq)]
pub struct Jump {
    /// Id of the recording.
    pub recording: String,
    /// First row of the recording after it.
    pub row: usize,
    /// The time of that row, s.
    pub at_s: f64,
    /// How much later the times are from there on, beyond whole steps, s.
    pub by_s: f64,
    /// Standard deviation of that, by the times themselves, s.
    pub std_s: f64,
    /// How much later they are if the sampling went on, s: the interval less one step.
    pub all_s: f64,
}

impl Jump {
    /// Rows that are left out, or the beginning of another recording.
    pub fn pause(recording: &str, row: usize, at_s: f64, all_s: f64) -> Self {
        Self { recording: recording.to_owned(), row, at_s, by_s: 0.0, std_s: 0.0, all_s }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(time: &[f64]) -> Vec<Column> {
        vec![time.iter().map(|t| 5.0 + 0.5 * t).collect(); 3]
    }

    fn placed(time: &[f64]) -> Piece {
        place(time, columns(time), "recordings[0]", "it").expect("placed")
    }

    fn pieces(time: &[f64]) -> Vec<Piece> {
        cut(time, columns(time), "recordings[0]", "it").expect("cut")
    }

    #[test]
    fn rows_that_were_never_written_are_missing() {
        let piece = placed(&[0.0, 1.0, 2.0, 5.0, 6.0, 7.0]);
        assert!((piece.step_s - 1.0).abs() < 1e-12 && piece.told.is_none());
        let missing: Vec<bool> = piece.columns[0].iter().map(|value| value.is_nan()).collect();
        assert_eq!(missing[2..6], [false, true, true, false]);
        // A slow drift of the stamps against their nominal step is no scatter.
        let time: Vec<f64> = (0..5000).map(|k| 1.0003 * f64::from(k)).collect();
        assert!(placed(&time).told.is_none());
    }

    #[test]
    fn uneven_times_are_interpolated() {
        let time: Vec<f64> = (0..60).map(|k| f64::from(k) + 0.45 * f64::from(k * 7 % 5 - 2) / 2.0).collect();
        let piece = placed(&time);
        assert!(piece.told.is_some());
        for (row, value) in piece.columns[0].iter().enumerate() {
            let t = piece.start_s + row as f64 * piece.step_s;
            assert!((value - 5.0 - 0.5 * t).abs() < 1e-9, "a straight line stays one");
        }
    }

    #[test]
    fn a_clock_that_was_set_is_told_by_its_row() {
        let time: Vec<f64> = (0..40).map(|row| f64::from(row) + if row < 20 { 0.0 } else { 1.7e9 }).collect();
        let refused = place(&time, columns(&time), "recordings[0]", "it");
        let said = "recordings[0].columns.time_s[20]: found 19680 days from row 19 to row 20";
        let refused = refused.err().expect("refused").to_string();
        assert!(refused.starts_with(said), "{refused}");
    }

    #[test]
    fn times_that_jump_are_cut_and_not_spread() {
        let time: Vec<f64> = (0..400).map(|k| f64::from(k) + if k < 150 { 0.0 } else { 0.4 }).collect();
        let pieces = pieces(&time);
        assert_eq!(pieces.len(), 2);
        assert!(pieces.iter().all(|piece| piece.told.is_none() && (piece.step_s - 1.0).abs() < 1e-9));
        assert!((pieces[1].start_s - 150.4).abs() < 1e-9 && pieces[0].columns[0].len() == 150);
        let jump = pieces[1].jump.as_ref().expect("a jump");
        assert!((jump.by_s - 0.4).abs() < 1e-9 && (jump.all_s - 0.4).abs() < 1e-9 && jump.row == 150);
    }

    #[test]
    fn rounded_times_are_even() {
        for (step, digit) in [(0.100_3, 1e-3), (1.000_03, 1e-3), (0.016_667, 1e-6), (0.003_333, 1e-3)] {
            let time: Vec<f64> = (0..3000).map(|k| (f64::from(k) * step / digit).round() * digit).collect();
            let pieces = pieces(&time);
            assert!(pieces.len() == 1 && pieces[0].told.is_none(), "{step} {digit}");
            assert!((pieces[0].step_s / step - 1.0).abs() < 1e-4);
        }
    }
}
