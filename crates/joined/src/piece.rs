//! Readings of one instrument that are even in time: one piece of what its logger recorded, from one jump of its times to the next.

use common::number::{counted, duration};
use common::{Error as Fault, Recording};
use estimate::cadence::{Cadence, rounding};
use estimate::resample::pchip;
use estimate::stats::median;

use super::LEAST;
use super::segments::Jump;
use crate::{Error, words};

/// Times count as even when each lies within this share of a step of its place, or within what the last digit rounds.
pub const EXACT: f64 = 1e-3;
/// What the last digit rounds, in its units: a half, and what a line through rounded times is off.
const ROUNDED: f64 = 0.75;
/// An interval of so many usual ones is a gap.
const GAP: f64 = 3.0;
/// An even grid of more times the recorded rows is not made.
const SPARSE: f64 = 1000.0;

/// One instrument in one recording, its times made even.
pub struct Piece {
    /// JSON path of the recording.
    pub path: String,
    /// Time of the first row, s.
    pub start_s: f64,
    /// From one row to the next, s.
    pub step_s: f64,
    /// Its columns; NaN where a reading is missing.
    pub columns: Vec<Vec<f64>>,
    /// What was done to the times, in words.
    pub told: Option<String>,
    /// The jump of the times with which it begins.
    pub jump: Option<Jump>,
}

impl Piece {
    /// Time of the last row, s.
    pub fn end_s(&self) -> f64 {
        self.start_s + self.step_s * (self.columns[0].len() - 1) as f64
    }

    /// The columns of these names (each with what is expected where it is missing) of a recording at its times, cut where these jump.
    pub fn of(
        recording: &Recording,
        path: &str,
        names: &[(String, String)],
        time: &[f64],
    ) -> Result<Vec<Self>, Error> {
        let columns: Vec<Vec<f64>> =
            names.iter().map(|name| column(recording, path, name)).collect::<Result<_, _>>()?;
        cut(time, columns, path, &recording.id)
    }
}

/// The pieces between jumps of the times.
fn cut(time: &[f64], columns: Vec<Vec<f64>>, path: &str, id: &str) -> Result<Vec<Piece>, Error> {
    let Some(cadence) = Cadence::of(time) else {
        return Ok(vec![place(time, columns, 0.0, path, id)?]);
    };
    let digit_s = cadence.digit_s.unwrap_or(0.0);
    if cadence.jumps.is_empty() {
        return Ok(vec![place(time, columns, digit_s, path, id)?]);
    }
    let mut pieces = Vec::new();
    for (number, rows) in cadence.segments(time.len()).into_iter().enumerate() {
        let columns = columns.iter().map(|column| column[rows.clone()].to_vec()).collect();
        let jump = number.checked_sub(1).map(|before| &cadence.jumps[before]);
        let piece = place(&time[rows], columns, digit_s, path, id)?;
        let jump = jump.map(|jump| Jump {
            recording: id.to_owned(),
            path: path.to_owned(),
            row: jump.row,
            at_s: time[jump.row],
            by_s: jump.by_s,
            std_s: jump.std_s,
            all_s: jump.interval_s - cadence.step_s,
            step_s: cadence.step_s,
        });
        pieces.push(Piece { jump, ..piece });
    }
    Ok(pieces)
}

/// Rows at their places on an even grid; rows that were never written are missing there. `digit_s` is the unit of the last digit in which
/// times are written.
///
/// # Errors
///
/// Times with a gap so long that hardly any row of the grid would be a recorded one: a clock that was set.
fn place(time: &[f64], columns: Vec<Vec<f64>>, digit_s: f64, path: &str, id: &str) -> Result<Piece, Error> {
    let intervals: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual = median(&intervals);
    let fine = Cadence::of(time).map_or(usual, |cadence| cadence.step_s);
    let mut places = vec![0.0];
    for interval in &intervals {
        places.push(places[places.len() - 1] + (interval / fine).round().max(1.0));
    }
    let last = time.len() - 1;
    if places[last] > SPARSE * time.len() as f64 {
        let longest = (0..last).max_by(|a, b| intervals[*a].total_cmp(&intervals[*b])).unwrap_or(0);
        let found = format!(
            "{} from row {longest} to row {} where rows are {} apart",
            duration(intervals[longest]),
            longest + 1,
            duration(usual)
        );
        let expected = "times of one clock; was it set there? Put the rows before and after into recordings of their own";
        return Err(
            Fault::document(format!("{path}.columns.time_s[{}]", longest + 1), found, expected).into()
        );
    }
    let ends = (time[0], (time[last] - time[0]) / places[last]);
    let scatter = |(start_s, step_s): (f64, f64)| {
        let off = places.iter().zip(time).map(|(place, t)| (t - start_s - place * step_s).abs());
        off.fold(0.0, f64::max)
    };
    let tolerance = (EXACT * fine).max(ROUNDED * digit_s).max(rounding(time));
    let (start_s, step_s) = if scatter(ends) <= EXACT * fine { ends } else { line(&places, time) };
    let scatter = scatter((start_s, step_s));
    let path = path.to_owned();
    if scatter <= tolerance {
        let rows = places[last] as usize + 1;
        let even = |column: Vec<f64>| {
            let mut even = vec![f64::NAN; rows];
            places.iter().zip(column).for_each(|(place, value)| even[*place as usize] = value);
            even
        };
        let columns = columns.into_iter().map(even).collect();
        return Ok(Piece { path, start_s, step_s, columns, told: None, jump: None });
    }
    let between: Vec<f64> = intervals.iter().copied().filter(|interval| *interval <= GAP * usual).collect();
    let step_s = between.iter().sum::<f64>() / between.len() as f64;
    let start_s = time[0];
    let rows = ((time[last] - start_s) / step_s + 1e-6).floor() as usize + 1;
    let at: Vec<f64> = (0..rows).map(|row| start_s + row as f64 * step_s).collect();
    let columns = columns.iter().map(|column| interpolated(time, column, &at, GAP * usual)).collect();
    let told = Some(words::uneven(id, scatter, step_s));
    Ok(Piece { path, start_s, step_s, columns, told, jump: None })
}

/// The line t = a + b k of least squares.
fn line(places: &[f64], time: &[f64]) -> (f64, f64) {
    let count = places.len() as f64;
    let (k, t) = (places.iter().sum::<f64>() / count, time.iter().sum::<f64>() / count);
    let (mut above, mut below) = (0.0, 0.0);
    for (place, time) in places.iter().zip(time) {
        above += (place - k) * (time - t);
        below += (place - k).powi(2);
    }
    let step = above / below;
    (t - step * k, step)
}

/// What is known, read at other times; NaN within gaps.
fn interpolated(time: &[f64], column: &[f64], at: &[f64], gap_s: f64) -> Vec<f64> {
    let known: Vec<(f64, f64)> =
        time.iter().copied().zip(column.iter().copied()).filter(|(_, value)| value.is_finite()).collect();
    let (time, values): (Vec<f64>, Vec<f64>) = known.into_iter().unzip();
    let mut read = pchip(&time, &values, at);
    for (value, t) in read.iter_mut().zip(at) {
        let after = time.partition_point(|known| known < t);
        if after > 0 && after < time.len() && time[after] - time[after - 1] > gap_s {
            *value = f64::NAN;
        }
    }
    read
}

fn column(recording: &Recording, path: &str, (name, expected): &(String, String)) -> Result<Vec<f64>, Error> {
    let Some(column) = recording.column(name) else {
        return Err(Fault::document(format!("{path}.columns"), "no such column", expected.clone()).into());
    };
    let known: Vec<f64> = column.iter().copied().filter(|value| value.is_finite()).collect();
    if known.len() < LEAST {
        let found = counted(known.len(), "reading");
        return Err(Fault::document(format!("{path}.columns.{name}"), found, "at least five").into());
    }
    if known.iter().all(|value| *value == known[0]) {
        let found = format!("the constant reading {}", known[0]);
        let expected = "readings that follow the field; was the instrument connected?";
        return Err(Fault::document(format!("{path}.columns.{name}"), found, expected).into());
    }
    Ok(column.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placed(time: &[f64]) -> Piece {
        let column: Vec<f64> = time.iter().map(|t| 5.0 + 0.5 * t).collect();
        place(time, vec![column.clone(), column.clone(), column], 0.0, "recordings[0]", "it").expect("placed")
    }

    #[test]
    fn a_clock_that_was_set_is_told_by_its_row() {
        let time: Vec<f64> = (0..40).map(|row| f64::from(row) + if row < 20 { 0.0 } else { 1.7e9 }).collect();
        let column = vec![1.0; 40];
        let refused = place(&time, vec![column.clone(), column.clone(), column], 0.0, "recordings[0]", "it");
        let said = refused.err().expect("refused").to_string();
        assert!(
            said.starts_with("recordings[0].columns.time_s[20]: found 19680 days from row 19 to row 20"),
            "{said}"
        );
    }

    #[test]
    fn rows_that_were_never_written_are_missing() {
        let piece = placed(&[0.0, 1.0, 2.0, 5.0, 6.0, 7.0]);
        assert!((piece.step_s - 1.0).abs() < 1e-12 && piece.told.is_none());
        assert_eq!(
            piece.columns[0].iter().map(|v| v.is_nan()).collect::<Vec<_>>()[2..6],
            [false, true, true, false]
        );
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
    fn times_that_jump_are_cut_and_not_spread() {
        let time: Vec<f64> = (0..400).map(|k| f64::from(k) + if k < 150 { 0.0 } else { 0.4 }).collect();
        let column: Vec<f64> = time.iter().map(|t| 5.0 + 0.5 * t).collect();
        let pieces =
            cut(&time, vec![column.clone(), column.clone(), column], "recordings[0]", "it").expect("cut");
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
            let column: Vec<f64> = time.iter().map(|t| 5.0 + 0.5 * t).collect();
            let pieces =
                cut(&time, vec![column.clone(), column.clone(), column], "recordings[0]", "it").expect("cut");
            assert!(pieces.len() == 1 && pieces[0].told.is_none(), "{step} {digit}");
            assert!((pieces[0].step_s / step - 1.0).abs() < 1e-4);
        }
    }
}
