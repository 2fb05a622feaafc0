//! The three axes of an instrument, on all cores.

/// What is made of each axis by its number.
pub fn each<T: Send>(of: impl Fn(usize) -> T + Sync) -> [T; 3] {
    let (x, (y, z)) = rayon::join(|| of(0), || rayon::join(|| of(1), || of(2)));
    [x, y, z]
}

/// The same of what may fail: the first error counts.
pub fn try_each<T: Send, E: Send>(of: impl Fn(usize) -> Result<T, E> + Sync) -> Result<[T; 3], E> {
    let [x, y, z] = each(of);
    Ok([x?, y?, z?])
}
