//! The times that pieces cover.

use serde::{Deserialize, Serialize};

/// Stretches of time at most. Of more, the shortest hole is closed for good.
pub const MOST: usize = 512;

/// A moment: a number of seconds, or the number of a place on a grid.
pub trait Moment: Copy + PartialOrd {
    /// Whether nothing lies between this and a later one.
    fn is_next_to(self, later: Self) -> bool;

    /// How far it is to a later one.
    fn until(self, later: Self) -> f64;

    /// Whether it is a moment at all.
    fn is_whole(self) -> bool;
}

impl Moment for f64 {
    fn is_next_to(self, _: Self) -> bool {
        false
    }

    fn until(self, later: Self) -> f64 {
        later - self
    }

    fn is_whole(self) -> bool {
        self.is_finite()
    }
}

impl Moment for i64 {
    fn is_next_to(self, later: Self) -> bool {
        self.checked_add(1) == Some(later)
    }

    fn until(self, later: Self) -> f64 {
        later as f64 - self as f64
    }

    fn is_whole(self) -> bool {
        true
    }
}

/// First and last moment of each stretch, in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Covered<T>(Vec<[T; 2]>);

impl<T> Default for Covered<T> {
    fn default() -> Self {
        Covered(Vec::new())
    }
}

impl<T: Moment> Covered<T> {
    /// One stretch.
    pub fn of(first: T, last: T) -> Self {
        Covered(vec![[first, last]])
    }

    /// The stretches.
    pub fn stretches(&self) -> &[[T; 2]] {
        &self.0
    }

    /// The first and the last moment.
    pub fn span(&self) -> Option<[T; 2]> {
        Some([self.0.first()?[0], self.0.last()?[1]])
    }

    /// Adds the stretches of another. Those with nothing between them become one.
    ///
    /// Errors: from when to when both cover the same.
    pub fn merge(&mut self, other: &Self) -> Result<(), [T; 2]> {
        let mut all: Vec<[T; 2]> = Vec::with_capacity(self.0.len() + other.0.len());
        let (mut mine, mut theirs) = (self.0.iter().peekable(), other.0.iter().peekable());
        loop {
            let next = match (mine.peek(), theirs.peek()) {
                (Some(a), Some(b)) if a[0] <= b[0] => mine.next(),
                (_, Some(_)) => theirs.next(),
                _ => mine.next(),
            };
            let Some([first, last]) = next.copied() else { break };
            match all.last_mut() {
                Some(before) if first <= before[1] => {
                    return Err([first, if last < before[1] { last } else { before[1] }]);
                }
                Some(before) if before[1].is_next_to(first) => before[1] = last,
                _ => all.push([first, last]),
            }
        }
        self.0 = all;
        Ok(())
    }

    /// Closes the shortest (first) hole if there are more than `most`; the moments beside it.
    pub fn close(&mut self, most: usize) -> Option<[T; 2]> {
        if self.0.len() <= most {
            return None;
        }
        let hole = |at: &usize| self.0[*at][1].until(self.0[at + 1][0]);
        let at = (0..self.0.len() - 1).min_by(|a, b| hole(a).total_cmp(&hole(b)))?;
        let [first, last] = self.0.remove(at + 1);
        let before = std::mem::replace(&mut self.0[at][1], last);
        Some([before, first])
    }

    /// Whether the stretches rise and are not too many, after reading them from outside.
    pub fn is_whole(&self) -> bool {
        self.0.len() <= MOST
            && self.0.iter().flatten().all(|moment| moment.is_whole())
            && self.0.iter().all(|[first, last]| first <= last)
            && self.0.windows(2).all(|pair| pair[0][1] < pair[1][0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretches_grow_together_and_holes_close() {
        let mut places = Covered::of(0_i64, 9);
        places.merge(&Covered(vec![[10, 19], [40, 49], [21, 30]][..2].to_vec())).expect("apart");
        assert_eq!(places.stretches(), [[0, 19], [40, 49]]);
        assert_eq!(places.merge(&Covered::of(15, 30)), Err([15, 19]));
        assert_eq!(places.merge(&Covered::of(45, 46)), Err([45, 46]));
        assert_eq!(places.stretches(), [[0, 19], [40, 49]]);
        places.merge(&Covered::of(21, 25)).expect("apart");
        assert_eq!(places.close(3), None);
        assert_eq!(places.close(2), Some([19, 21]));
        assert_eq!(places.stretches(), [[0, 25], [40, 49]]);
        assert!(places.is_whole() && !Covered(vec![[3.0, 1.0]]).is_whole());
        let mut times = Covered::of(0.0, 1.0);
        times.merge(&Covered::of(1.5, 2.0)).expect("apart");
        assert_eq!((times.stretches().len(), times.span()), (2, Some([0.0, 2.0])));
        assert_eq!(times.merge(&Covered::of(2.0, 3.0)), Err([2.0, 2.0]));
    }
}
