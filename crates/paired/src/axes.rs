//! All axes of an instrument, on all cores.

use rayon::prelude::*;

/// What is made of each axis by its number.
pub fn each<T: Send>(count: usize, of: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..count).into_par_iter().map(of).collect()
}

/// The same of what may fail: the first error counts.
pub fn try_each<T: Send, E: Send>(
    count: usize,
    of: impl Fn(usize) -> Result<T, E> + Sync + Send,
) -> Result<Vec<T>, E> {
    each(count, of).into_iter().collect()
}
