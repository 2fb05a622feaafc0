//! Steps and spikes of the difference, in the test instrument or in the reference.

mod attribution;
mod found;
mod levels;
mod local;
mod search;
mod step;
mod view;

pub use found::{CONFIRMED, Events, FoundEvent};
pub(crate) use search::{search, standing};
pub use step::lasting;

use estimate::events::{Search, Shape, fill};

use crate::Error;
use crate::noise::Noise;

/// Whether in rows that are out a difference is off what stands around them: by [`CONFIRMED`] uncertainties
/// of a single reading.
///
/// `left` are the differences with the readings of these rows in them; `out` are all rows that are out.
pub fn off(
    left: &[Vec<f64>],
    out: &[bool],
    step_s: f64,
    noise: &[&Noise],
    disturbed: &[&FoundEvent],
) -> Result<Vec<bool>, Error> {
    let mut off = vec![false; disturbed.len()];
    for (left, noise) in left.iter().zip(noise) {
        let density = |f: f64| noise.level(f);
        let likely = fill(left, out, step_s, &density)?;
        let search = Search::new(&likely, step_s, &density)?;
        for (off, event) in off.iter_mut().zip(disturbed) {
            let far =
                |row: usize| (left[row] - likely[row]).abs() >= CONFIRMED * search.size(Shape::Spike, row).1;
            *off |= (event.from..=event.to).any(far);
        }
    }
    Ok(off)
}
