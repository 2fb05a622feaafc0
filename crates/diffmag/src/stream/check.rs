//! Columns of which no matrix can be told.

use common::Axis;
use estimate::tsqr::Tsqr;

use crate::Error;
use joined::{ALIKE, IN_A_PLANE, in_a_plane, other_units};

/// Places of the reference's and of the test instrument's readings among the columns.
pub const REFERENCE: [usize; 3] = [1, 2, 3];
pub const TEST: [usize; 3] = [4, 5, 6];

/// Refuses readings that never change, columns that are one, and other units.
pub fn columns(factor: &Tsqr) -> Result<(), Error> {
    let refused = |reason: String| Err(Error::Request(reason));
    let names = |instrument: &str| Axis::ALL.map(|axis| format!("{instrument}_{axis}_nt"));
    let all: Vec<String> = names("reference").into_iter().chain(names("test")).collect();
    let places = [REFERENCE, TEST].concat();
    let squares = factor.regress(&[], &places)?.squares;
    for ((name, place), squares) in all.iter().zip(&places).zip(&squares) {
        let mean = factor.mean(*place);
        if squares.sqrt() <= ALIKE * mean.abs() * (factor.count() as f64).sqrt() {
            return refused(format!(
                "{name}: found the constant reading {mean}; expected readings that follow the field; was the instrument connected?"
            ));
        }
    }
    for (later, place) in places.iter().enumerate() {
        for earlier in 0..later {
            let one = factor.regress(&[places[earlier]], &[*place])?;
            if one.squares[0].sqrt() <= ALIKE * squares[later].sqrt() {
                return refused(format!(
                    "{}: found the readings of `{}`, perhaps in another unit; expected readings of its own; was a column copied?",
                    all[later], all[earlier]
                ));
            }
        }
    }
    let [x, y, z] = REFERENCE;
    if in_a_plane(factor, [x, y], z)? {
        return Err(Error::Unanswerable(IN_A_PLANE.into()));
    }
    let size = |squares: &[f64]| squares.iter().sum::<f64>().sqrt();
    let ratio = size(&squares[3..]) / size(&squares[..3]);
    let Some((found, expected)) = other_units(ratio) else { return Ok(()) };
    refused(format!("test_x_nt, …: found {found}; expected {expected}"))
}
