//! Rows between jumps of the instruments' times: in each the two clocks differ by an offset of its own.

use std::ops::Range;

use estimate::even::EXACT;

use super::Instrument;
use super::grid::Grid;
use super::piece::Jump;

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

/// Where the times of reference or test instrument jump, in the order of rows.
pub fn boundaries(grid: &Grid, reference: &Instrument, test: &Instrument) -> Vec<Boundary> {
    let jumps = |instrument: &Instrument| -> Vec<Jump> {
        instrument.pieces.iter().filter_map(|piece| piece.jump.clone()).collect()
    };
    on_grid(grid, [reference, test], [jumps(reference), jumps(test)])
}

/// Where the times of reference or test instrument leave rows out, or go on in another recording: whether
/// rows are missing or a clock was set the times do not say.
pub fn pauses(grid: &Grid, reference: &Instrument, test: &Instrument) -> Vec<Boundary> {
    let pauses = |instrument: &Instrument| -> Vec<Jump> {
        let next = instrument.pieces.windows(2).filter(|pair| pair[1].jump.is_none());
        let between = next.map(|pair| Jump {
            recording: pair[1].id.clone(),
            path: pair[1].path.clone(),
            row: 0,
            at_s: pair[1].start_s,
            by_s: 0.0,
            std_s: 0.0,
            all_s: pair[1].start_s - pair[0].end_s() - pair[1].step_s,
            step_s: pair[1].step_s,
        });
        instrument.pieces.iter().flat_map(|piece| piece.pauses.clone()).chain(between).collect()
    };
    on_grid(grid, [reference, test], [pauses(reference), pauses(test)])
}

fn on_grid(
    grid: &Grid,
    [reference, test]: [&Instrument; 2],
    [of_reference, of_test]: [Vec<Jump>; 2],
) -> Vec<Boundary> {
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
