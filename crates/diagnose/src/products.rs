//! Products of whitened columns, gathered once over the rows: all that is decided afterwards depends on the
//! number of columns alone.

use estimate::dot;
use faer::Mat;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

use crate::observed::Observed;
use crate::stacked::Stacked;
use crate::whitening::NoiseModel;

/// Whitened columns with their products: of most only those within a group, for a thousand columns have a million of
/// products, of which few are asked for.
#[derive(Clone, Debug)]
pub struct Products {
    ranges: Vec<Range<usize>>,
    /// For each channel the columns that are something in it, as they came.
    parts: Vec<Vec<Arc<Part>>>,
    /// For each channel and column where it stands in them.
    places: Vec<Vec<Option<(usize, usize)>>>,
    /// Row i has the products with columns from its first to i.
    gram: Vec<(usize, Vec<f64>)>,
}

/// Columns that came together, in one channel.
#[derive(Debug)]
struct Part {
    numbers: Vec<usize>,
    values: Mat<f64>,
}

impl Products {
    pub fn of(observed: &Observed<'_>) -> Self {
        let ranges: Vec<Range<usize>> = observed.channels.iter().map(|channel| channel.range()).collect();
        let channels = ranges.len();
        Self {
            ranges,
            parts: vec![Vec::new(); channels],
            places: vec![Vec::new(); channels],
            gram: Vec::new(),
        }
    }

    /// Adds columns (nT), each with its products with those from the first of its group on.
    pub fn push_groups(&mut self, noise: &NoiseModel, raw: &[Stacked], first: &[usize]) {
        let from = self.len();
        self.append(&noise.whitened(raw));
        let product = |i: usize, j: usize| -> f64 {
            let both = |channel| Some(dot(self.part(channel, i)?, self.part(channel, j)?));
            (0..self.ranges.len()).filter_map(both).sum()
        };
        let row = |(k, first): (usize, &usize)| {
            (*first, (*first..=from + k).map(|other| product(from + k, other)).collect())
        };
        let rows: Vec<_> = first.par_iter().enumerate().map(row).collect();
        self.gram.extend(rows);
    }

    /// Adds columns (nT) with their products with those from a first one on.
    pub fn push(&mut self, noise: &NoiseModel, raw: &[Stacked], first: usize) {
        self.push_white(&noise.whitened(raw), first);
    }

    /// Adds columns that are there already once more, with their products with those from a first one on.
    pub fn push_again(&mut self, columns: &[usize], first: usize) {
        let white: Vec<Stacked> = columns.iter().map(|column| self.column(*column)).collect();
        self.push_white(&white, first);
    }

    fn push_white(&mut self, white: &[Stacked], first: usize) {
        self.append(white);
        let columns: Vec<usize> = (self.gram.len()..self.len()).collect();
        let rows = self.rows(&columns, first);
        self.gram.extend(rows.into_iter().map(|row| (first, row)));
    }

    /// Forms the products of columns that have few, with all.
    pub fn complete(&mut self, columns: &[usize]) {
        let rows = self.rows(columns, 0);
        columns.iter().zip(rows).for_each(|(column, row)| self.gram[*column] = (0, row));
    }

    /// Whether a column has its products with all.
    pub fn is_complete(&self, column: usize) -> bool {
        self.gram[column].0 == 0
    }

    /// Adds columns without their products.
    fn append(&mut self, white: &[Stacked]) {
        let (from, count) = (self.len(), white.len());
        for (channel, range) in self.ranges.iter().enumerate() {
            let there: Vec<(usize, &[f64])> =
                (0..count).filter_map(|k| Some((from + k, white[k].part(channel)?))).collect();
            let mut values = Mat::zeros(range.len(), there.len());
            for (j, (_, part)) in there.iter().enumerate() {
                values.col_as_slice_mut(j).copy_from_slice(part);
            }
            let places = &mut self.places[channel];
            places.resize(from + count, None);
            let numbers: Vec<usize> = there.iter().map(|(number, _)| *number).collect();
            let part = self.parts[channel].len();
            numbers.iter().enumerate().for_each(|(j, number)| places[*number] = Some((part, j)));
            self.parts[channel].push(Arc::new(Part { numbers, values }));
        }
    }

    /// Products of columns with those from a first one to themselves.
    fn rows(&self, columns: &[usize], first: usize) -> Vec<Vec<f64>> {
        let mut rows: Vec<Vec<f64>> = columns.iter().map(|column| vec![0.0; column + 1 - first]).collect();
        let of_channel = |channel: usize| {
            let there: Vec<usize> =
                (0..columns.len()).filter(|k| self.places[channel][columns[*k]].is_some()).collect();
            let part = |k: usize| self.part(channel, columns[there[k]]).unwrap_or_default();
            let own = Mat::from_fn(self.ranges[channel].len(), there.len(), |i, k| part(k)[i]);
            let behind = |part: &&Arc<Part>| part.numbers.last().is_some_and(|last| *last >= first);
            let parts = self.parts[channel].iter().filter(behind);
            let products: Vec<(&Arc<Part>, Mat<f64>)> =
                parts.map(|part| (part, part.values.transpose() * &own)).collect();
            (there, products)
        };
        let found: Vec<_> = (0..self.ranges.len()).into_par_iter().map(of_channel).collect();
        for (there, products) in found {
            for (part, products) in products {
                for (j, k) in there.iter().enumerate() {
                    let with = part.numbers.iter().zip(products.col_as_slice(j));
                    let with = with.filter(|(other, _)| (first..=columns[*k]).contains(other));
                    with.for_each(|(other, value)| rows[*k][other - first] += value);
                }
            }
        }
        rows
    }

    pub fn column(&self, number: usize) -> Stacked {
        let part = |channel: usize| self.part(channel, number).map(<[f64]>::to_vec);
        Stacked::new((0..self.ranges.len()).map(part).collect())
    }

    /// A whitened column in a channel; None where it is nothing there.
    pub fn part(&self, channel: usize, column: usize) -> Option<&[f64]> {
        let (part, place) = self.places[channel][column]?;
        Some(self.parts[channel][part].values.col_as_slice(place))
    }

    /// A whitened series less columns times coefficients.
    pub fn less(&self, white: &[f64], terms: &[(usize, f64)]) -> Vec<f64> {
        let mut left = white.to_vec();
        for (channel, range) in self.ranges.iter().enumerate() {
            for (column, coefficient) in terms {
                if let Some(part) = self.part(channel, *column) {
                    left[range.clone()].iter_mut().zip(part).for_each(|(l, p)| *l -= coefficient * p);
                }
            }
        }
        left
    }

    /// The products of a column with those from the first one on to itself, and that first one.
    pub fn row(&self, column: usize) -> (usize, &[f64]) {
        let (first, row) = &self.gram[column];
        (*first, row)
    }

    pub fn ranges(&self) -> &[Range<usize>] {
        &self.ranges
    }

    pub fn square(&self, column: usize) -> f64 {
        self.gram[column].1.last().copied().unwrap_or(0.0)
    }

    pub fn len(&self) -> usize {
        self.places.first().map_or(0, Vec::len)
    }

    /// The products of columns from `from` on with those of `onto`, one row of the answer a column.
    pub fn along(&self, onto: &Mat<f64>, from: usize) -> Vec<Vec<f64>> {
        let mut along = vec![vec![0.0; onto.ncols()]; self.len() - from];
        let products = |(range, parts): (&Range<usize>, &Vec<Arc<Part>>)| -> Vec<(Arc<Part>, Mat<f64>)> {
            let new = parts.iter().filter(|part| part.numbers.first().is_some_and(|number| *number >= from));
            let right = onto.subrows(range.start, range.len());
            new.map(|part| (part.clone(), part.values.transpose() * right)).collect()
        };
        let found: Vec<_> = self.ranges.par_iter().zip(&self.parts).map(products).collect();
        for (part, products) in found.into_iter().flatten() {
            for (i, column) in part.numbers.iter().enumerate() {
                along[column - from].iter_mut().enumerate().for_each(|(j, sum)| *sum += products[(i, j)]);
            }
        }
        along
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// Two channels of some rows; the third column is nothing in the first.
    pub fn some(rows: [usize; 2]) -> (Products, Vec<Stacked>) {
        let wave =
            |k: usize, rows: usize| (0..rows).map(|row| (0.3 * (k + 1) as f64 * row as f64).sin()).collect();
        let column =
            |k: usize| Stacked::new(vec![(k != 2).then(|| wave(k, rows[0])), Some(wave(k + 3, rows[1]))]);
        let columns: Vec<Stacked> = (0..4).map(column).collect();
        let empty = || vec![Vec::new(); 2];
        let ranges = vec![0..rows[0], rows[0]..rows[0] + rows[1]];
        let places = vec![Vec::new(); 2];
        let mut products = Products { ranges, parts: empty(), places, gram: Vec::new() };
        products.push_white(&columns[..2], 0);
        products.push_white(&columns[2..], 2);
        (products, columns)
    }

    pub fn product(a: &Stacked, b: &Stacked) -> f64 {
        (0..2).filter_map(|channel| Some(dot(a.part(channel)?, b.part(channel)?))).sum()
    }

    #[test]
    fn products_that_are_formed_late_are_the_same() {
        let (mut products, columns) = some([40, 30]);
        assert!(!products.is_complete(3));
        products.push_again(&[3, 1], 4);
        products.complete(&[4, 3]);
        let at = |i: usize| &columns[[0, 1, 2, 3, 3, 1][i]];
        for (i, (first, row)) in products.gram.iter().enumerate() {
            for (j, value) in (*first..=i).zip(row) {
                assert!((value - product(at(i), at(j))).abs() < 1e-12, "{i} {j}");
            }
        }
        let formed: Vec<usize> = products.gram.iter().map(|(first, _)| *first).collect();
        assert_eq!(formed, [0, 0, 2, 0, 0, 4]);
    }
}
