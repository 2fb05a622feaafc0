//! Rows between jumps of the instruments' times: in each the two clocks differ by an offset of its own.

use std::ops::Range;

use super::Instrument;
use super::grid::Grid;
use super::piece::EXACT;

/// Rows in which no instrument's times jump.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// The rows.
    pub rows: Range<usize>,
    /// How much later the test instrument's times are here than in the segment that all are compared with, s; zero until somebody finds it.
    pub late_s: f64,
}

/// A jump of an instrument's times.
#[derive(Clone, Debug, PartialEq)]
pub struct Jump {
    /// Id of the recording.
    pub recording: String,
    /// JSON path of the recording.
    pub path: String,
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
    /// The usual step there, s.
    pub step_s: f64,
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

/// Where the times of reference or test instrument jump, in the order of rows.
pub fn boundaries(grid: &Grid, reference: &Instrument, test: &Instrument) -> Vec<Boundary> {
    let jumps = |instrument: &Instrument| -> Vec<Jump> {
        instrument.pieces.iter().filter_map(|piece| piece.jump.clone()).collect()
    };
    let (of_reference, of_test) = (jumps(reference), jumps(test));
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
