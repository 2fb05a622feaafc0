//! Columns over all channels that are nothing in most of them.

use std::sync::Arc;

use crate::observed::Observed;

/// A column, channel by channel; None where it is zero throughout. Copies share their values.
#[derive(Clone, Debug)]
pub struct Stacked(Vec<Option<Arc<[f64]>>>);

impl Stacked {
    /// Channel by channel.
    pub fn new(parts: Vec<Option<Vec<f64>>>) -> Self {
        Self(parts.into_iter().map(|part| part.map(Arc::from)).collect())
    }

    /// Of a column over all readings.
    pub fn of(observed: &Observed<'_>, dense: &[f64]) -> Self {
        let part = |range: std::ops::Range<usize>| {
            let part = &dense[range];
            part.iter().any(|value| *value != 0.0).then(|| part.into())
        };
        Self(observed.channels.iter().map(|channel| part(channel.range())).collect())
    }

    /// Over all readings.
    pub fn dense(&self, observed: &Observed<'_>) -> Vec<f64> {
        let parts = observed.channels.iter().zip(&self.0);
        let mut dense = vec![0.0; observed.rows];
        for (channel, part) in parts {
            if let Some(part) = part {
                dense[channel.range()].copy_from_slice(part);
            }
        }
        dense
    }

    /// Its values in a channel; None where they are all zero.
    pub fn part(&self, channel: usize) -> Option<&[f64]> {
        self.0[channel].as_deref()
    }

    pub fn is_zero(&self) -> bool {
        self.0.iter().all(Option::is_none)
    }

    pub fn is_finite(&self) -> bool {
        self.0.iter().flatten().all(|part| part.iter().all(|value| value.is_finite()))
    }

    /// Sum of the squares, and the number of values in channels where it is something.
    pub fn squares(&self) -> (f64, usize) {
        let parts = self.0.iter().flatten();
        parts.fold((0.0, 0), |(sum, count), part| {
            (sum + part.iter().map(|v| v * v).sum::<f64>(), count + part.len())
        })
    }

    /// In how many readings it is something.
    pub fn readings(&self) -> usize {
        self.0.iter().flatten().flat_map(|part| part.iter()).filter(|value| **value != 0.0).count()
    }

    /// Share of its sum of squares in readings from or to which another column changes by more than it is there.
    pub fn share_at_edges(&self, other: &Self) -> f64 {
        let both = self.0.iter().zip(&other.0);
        let both = both.filter_map(|(own, other)| Some((own.as_ref()?, other.as_ref()?)));
        let at_edge = |own: f64, others: &[f64]| others.windows(2).any(|w| (w[1] - w[0]).abs() > own.abs());
        let of = |(own, other): (&Arc<[f64]>, &Arc<[f64]>)| -> f64 {
            let rows = own.iter().enumerate().filter(|(row, own)| {
                **own != 0.0 && at_edge(**own, &other[row.saturating_sub(1)..(row + 2).min(other.len())])
            });
            rows.map(|(_, own)| own * own).sum()
        };
        both.map(of).sum::<f64>() / self.squares().0.max(f64::MIN_POSITIVE)
    }

    /// Columns times factors, added up.
    pub fn sum(columns: &[(&Self, f64)]) -> Self {
        let channels = columns.first().map_or(0, |(column, _)| column.0.len());
        let of = |channel: usize| {
            let mut sum: Option<Vec<f64>> = None;
            for (part, factor) in columns.iter().filter_map(|(c, f)| Some((c.0[channel].as_ref()?, f))) {
                match &mut sum {
                    Some(sum) => sum.iter_mut().zip(part.iter()).for_each(|(s, p)| *s += factor * p),
                    None => sum = Some(part.iter().map(|p| factor * p).collect()),
                }
            }
            sum
        };
        Self::new((0..channels).map(of).collect())
    }

    /// The column times something in each channel where it is not zero; None: zero there.
    pub fn times(&self, of: impl Fn(usize) -> Option<Vec<f64>>) -> Self {
        let part = |(channel, part): (usize, &Option<Arc<[f64]>>)| {
            let part = part.as_ref()?;
            Some(part.iter().zip(of(channel)?).map(|(p, f)| p * f).collect())
        };
        Self::new(self.0.iter().enumerate().map(part).collect())
    }

    /// The column times Chebyshev polynomials of something from −1 to 1, each over its order, from the first on.
    pub fn times_polynomials(&self, orders: usize, of: impl Fn(usize) -> Option<Vec<f64>>) -> Vec<Self> {
        let channels = self.0.len();
        let mut all = vec![vec![None; channels]; orders];
        for (channel, part) in self.0.iter().enumerate() {
            let Some((part, x)) = part.as_ref().and_then(|part| Some((part, of(channel)?))) else { continue };
            let mut before = part.to_vec();
            let mut now: Vec<f64> = part.iter().zip(&x).map(|(p, x)| p * x).collect();
            for (order, parts) in all.iter_mut().enumerate() {
                parts[channel] = Some(now.iter().map(|value| value / (order + 1) as f64).collect());
                // T_{k+1} = 2 x T_k − T_{k−1}.
                for ((x, before), now) in x.iter().zip(&mut before).zip(&mut now) {
                    (*before, *now) = (*now, 2.0 * x * *now - *before);
                }
            }
        }
        all.into_iter().map(Self::new).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_at_edges_of_another_column_are_told() {
        let own = Stacked::new(vec![Some(vec![0.0, 3.0, 0.0, 0.0, 0.0, -3.0])]);
        let other = Stacked::new(vec![Some(vec![0.0, 0.0, 5.0, 5.0, 5.0, 5.0])]);
        assert_eq!(own.share_at_edges(&other), 0.5);
        assert_eq!(other.share_at_edges(&own), 0.0);
    }
}
