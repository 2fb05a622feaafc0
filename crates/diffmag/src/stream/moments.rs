use estimate::exact::Sum;
use serde::{Deserialize, Serialize};

/// Place number, the reference's x, y, z and the test's x, y, z.
pub const CHANNELS: usize = 7;
pub const PRODUCTS: usize = CHANNELS * (CHANNELS + 1) / 2;

/// Where the product of channels i ≤ j stands.
pub const fn at(i: usize, j: usize) -> usize {
    i * (2 * CHANNELS - i - 1) / 2 + j
}

/// The samples of a block of places: how many are whole, and their sums.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Block {
    pub count: u64,
    pub sums: [Sum; CHANNELS],
}

impl Block {
    pub fn sample(place: i64, readings: [f64; 6]) -> Self {
        let mut sums = [Sum::of(place as f64); CHANNELS];
        sums[1..].iter_mut().zip(readings).for_each(|(sum, reading)| *sum = Sum::of(reading));
        Block { count: 1, sums }
    }

    pub fn add(&mut self, other: &Block) {
        self.count += other.count;
        self.sums.iter_mut().zip(&other.sums).for_each(|(to, from)| to.add_sum(*from));
    }

    pub fn means(&self) -> [f64; CHANNELS] {
        self.sums.map(|sum| sum.over(self.count as f64).value())
    }

    /// The means of `later` less those of this, both of `length` places: none unless each has three quarters
    /// of its samples. Scaled so that the variance of white noise is 2σ²/length whatever is missing.
    pub fn difference(&self, later: &Block, length: u64) -> Option<[f64; CHANNELS]> {
        if 4 * self.count.min(later.count) < 3 * length {
            return None;
        }
        let (before, after, length) = (self.count as f64, later.count as f64, length as f64);
        let mut difference = [0.0; CHANNELS];
        if self.count == later.count {
            let scale = (before / length).sqrt() / before;
            for (to, (a, b)) in difference.iter_mut().zip(self.sums.iter().zip(&later.sums)) {
                *to = b.less(*a) * scale;
            }
        } else {
            let scale = (2.0 * before * after / ((before + after) * length)).sqrt();
            for (to, (a, b)) in difference.iter_mut().zip(self.sums.iter().zip(&later.sums)) {
                *to = b.over(after).less(a.over(before)) * scale;
            }
        }
        Some(difference)
    }
}

/// Haar differences of one level: blocks of 2^L places less the blocks before them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Level {
    pub count: u64,
    /// Pairs of which a block has too few samples.
    pub broken: u64,
    /// Σ δ_i δ_j, see [`at`].
    pub products: Vec<Sum>,
}

impl Level {
    pub fn add(&mut self, other: &Level) {
        self.count += other.count;
        self.broken += other.broken;
        if self.products.is_empty() {
            self.products.clone_from(&other.products);
        } else {
            self.products.iter_mut().zip(&other.products).for_each(|(to, from)| to.add_sum(*from));
        }
    }

    /// Adds products of so many differences.
    #[inline]
    pub fn add_products(&mut self, count: u64, products: &[f64; PRODUCTS]) {
        self.count += count;
        if self.products.is_empty() {
            self.products = vec![Sum::default(); PRODUCTS];
        }
        self.products.iter_mut().zip(products).for_each(|(to, from)| to.add(*from));
    }

    pub fn add_difference(&mut self, difference: &[f64; CHANNELS]) {
        let mut products = [0.0; PRODUCTS];
        for i in 0..CHANNELS {
            for j in i..CHANNELS {
                products[at(i, j)] = difference[i] * difference[j];
            }
        }
        self.add_products(1, &products);
    }

    /// Σ δ_i δ_j.
    pub fn product(&self, i: usize, j: usize) -> Sum {
        self.products.get(at(i.min(j), i.max(j))).copied().unwrap_or_default()
    }
}
