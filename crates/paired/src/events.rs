//! Steps and spikes of the difference, in the test instrument or in the reference.

mod attribution;
mod found;
mod levels;
mod local;
mod search;
mod step;
mod view;

pub use found::{CONFIRMED, Events, FoundEvent};
pub use step::lasting;

use estimate::events::{Search, Shape, fill};

use crate::Error;
use crate::look::Look;
use crate::noise::Noise;
use joined::Pair;

/// The events of what a look leaves of a pair whose instruments are at the same moments; of that pair no
/// readings are needed any more. The search begins with those that are `known`.
pub fn search(left: Vec<Vec<f64>>, pair: &Pair, look: &Look, known: &Events) -> Result<Events, Error> {
    let eta = look.axes.iter().map(|axis| axis.eta).collect();
    let noise = look.axes.iter().map(|axis| axis.noise.clone()).collect();
    search::search(left, eta, pair, noise, known)
}

/// Those of these events that are disturbances, or steps that last in what a look beside them leaves.
pub fn standing(left: Vec<Vec<f64>>, pair: &Pair, look: &Look, found: &Events) -> Events {
    let eta = look.axes.iter().map(|axis| axis.eta).collect();
    search::standing_of(left, eta, pair, found)
}

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
