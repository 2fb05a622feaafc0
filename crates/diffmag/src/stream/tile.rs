use estimate::exact::Sum;

use super::moments::{Block, CHANNELS, Level, PRODUCTS, at};

/// Levels within a tile.
pub const TILE_LEVELS: usize = 6;
/// Places of a tile.
pub const TILE: usize = 1 << TILE_LEVELS;

const HALF: usize = TILE / 2;

/// Readings of a tile, then their sums over blocks.
type Values = [[f64; TILE]; 6];

/// Adds the differences within a tile of which no sample is missing, and gives its sums. The order of the
/// additions is fixed, so that a tile gives the same bytes wherever its piece begins.
pub fn full(first_place: i64, readings: [&[f64]; 6], levels: &mut [Level]) -> Block {
    let mut values = [[0.0; TILE]; 6];
    values.iter_mut().zip(readings).for_each(|(to, from)| to.copy_from_slice(from));
    let halvings: [fn(&mut Values) -> [f64; PRODUCTS]; TILE_LEVELS] =
        [halve::<HALF>, halve::<16>, halve::<8>, halve::<4>, halve::<2>, halve::<1>];
    for (number, (level, halve)) in levels.iter_mut().zip(halvings).enumerate() {
        level.add_products((HALF >> number) as u64, &halve(&mut values));
    }
    let mut sums = [Sum::default(); CHANNELS];
    sums[0] = Sum::of(TILE as f64 * first_place as f64);
    sums[0].add((TILE * (TILE - 1) / 2) as f64);
    (0..6).for_each(|i| sums[i + 1] = Sum::of(values[i][0]));
    Block { count: TILE as u64, sums }
}

/// Puts sums of neighbours in the place of the values, and gives the products of their differences.
fn halve<const PAIRS: usize>(values: &mut Values) -> [f64; PRODUCTS] {
    let mut differences = [[0.0; PAIRS]; 6];
    for (values, differences) in values.iter_mut().zip(&mut differences) {
        for pair in 0..PAIRS {
            let (before, after) = (values[2 * pair], values[2 * pair + 1]);
            differences[pair] = after - before;
            values[pair] = before + after;
        }
    }
    let length = (HALF / PAIRS) as f64;
    let mut products = [0.0; PRODUCTS];
    // The difference of the places is the length of a block.
    products[0] = length * length * PAIRS as f64;
    for i in 0..6 {
        products[at(0, i + 1)] = dot(&differences[i], &[1.0; PAIRS]);
        for j in i..6 {
            products[at(i + 1, j + 1)] = dot(&differences[i], &differences[j]) / (length * length);
        }
    }
    products
}

/// Σ a b, up to four sums side by side.
#[inline]
fn dot<const COUNT: usize>(a: &[f64; COUNT], b: &[f64; COUNT]) -> f64 {
    let mut sums = [0.0; 4];
    for from in (0..COUNT).step_by(4) {
        for k in 0..COUNT.min(4) {
            sums[k] += a[from + k] * b[from + k];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}
