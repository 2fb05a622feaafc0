//! The ends of the sensors' ranges, by how often the largest and the smallest reading came. Of two sets of
//! rows they are found from those of each.

use common::Axis;
use serde::{Deserialize, Serialize};

/// The furthest reading of a sensor stands at the end of its range where it came this many times as often as
/// the next.
const PILED_UP: u64 = 5;
/// Rows of such a pile at least.
const LEAST: u64 = 5;
/// Which way the ends lie.
const SIGNS: [f64; 2] = [1.0, -1.0];

/// The furthest reading one way and the one next to it, each with how often it came.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct End {
    first: (f64, u64),
    #[serde(default, skip_serializing_if = "Option::is_none")]
    next: Option<(f64, u64)>,
}

impl End {
    /// Takes a reading that came so often; whether it goes beyond what was the furthest.
    fn take(&mut self, (value, count): (f64, u64), sign: f64) -> bool {
        let beyond = |other: f64| sign * value > sign * other;
        if beyond(self.first.0) {
            self.next = Some(self.first);
            self.first = (value, count);
            return true;
        }
        if value == self.first.0 {
            self.first.1 += count;
            return false;
        }
        match &mut self.next {
            Some(next) if value == next.0 => next.1 += count,
            Some(next) if !beyond(next.0) => {}
            next => *next = Some((value, count)),
        }
        false
    }

    fn is_pile(&self) -> bool {
        let (_, count) = self.first;
        count >= LEAST && self.next.is_some_and(|(_, beside)| count >= PILED_UP * beside)
    }
}

/// Which of the six ends a row stands at: bit 2 k for the upper end of sensor k, 2 k + 1 for the lower.
pub type At = u8;

/// The ends of three sensors, upper and lower.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Ends([[Option<End>; 2]; 3]);

impl Ends {
    /// Whether there were no rows.
    pub fn is_empty(&self) -> bool {
        self.0.iter().flatten().all(Option::is_none)
    }

    /// Takes a row; gives the ends at which it stands, and those that it moved.
    pub fn take(&mut self, readings: [f64; 3]) -> (At, At) {
        let (mut at, mut moved) = (0, 0);
        for (axis, value) in readings.into_iter().enumerate() {
            for (side, sign) in SIGNS.into_iter().enumerate() {
                let bit = 1 << (2 * axis + side);
                let end = &mut self.0[axis][side];
                match end {
                    Some(end) => {
                        // Most readings are neither of the two.
                        if end.next.is_some_and(|(next, _)| sign * value < sign * next) {
                            continue;
                        }
                        if end.take((value, 1), sign) {
                            moved |= bit;
                        }
                        if end.first.0 == value {
                            at |= bit;
                        }
                    }
                    None => {
                        *end = Some(End { first: (value, 1), next: None });
                        at |= bit;
                    }
                }
            }
        }
        (at, moved)
    }

    /// Takes the ends of other rows; gives the ends that were moved here, and those that are not the furthest
    /// there.
    pub fn merge(&mut self, other: &Self) -> (At, At) {
        let (mut here, mut there) = (0, 0);
        for axis in 0..3 {
            for (side, sign) in SIGNS.into_iter().enumerate() {
                let bit = 1 << (2 * axis + side);
                let Some(theirs) = other.0[axis][side] else { continue };
                match &mut self.0[axis][side] {
                    Some(mine) => {
                        if mine.take(theirs.first, sign) {
                            here |= bit;
                        } else if mine.first.0 != theirs.first.0 {
                            there |= bit;
                        }
                        if let Some(next) = theirs.next {
                            mine.take(next, sign);
                        }
                    }
                    mine => *mine = Some(theirs),
                }
            }
        }
        (here, there)
    }

    /// The ends at which readings are piled up.
    pub fn piles(&self) -> At {
        let is = |axis: usize, side: usize| self.0[axis][side].is_some_and(|end| end.is_pile());
        let all = (0..3).flat_map(|axis| (0..2).map(move |side| (axis, side)));
        all.filter(|(axis, side)| is(*axis, *side)).map(|(axis, side)| 1 << (2 * axis + side)).sum()
    }

    /// The ends, among some, at which a row stands.
    pub fn at(&self, readings: [f64; 3], among: At) -> At {
        let mut at = 0;
        for (axis, value) in readings.into_iter().enumerate() {
            for side in 0..2 {
                let bit = 1 << (2 * axis + side);
                if among & bit != 0 && self.0[axis][side].is_some_and(|end| end.first.0 == value) {
                    at |= bit;
                }
            }
        }
        at
    }

    /// The largest and the smallest reading of a sensor.
    pub fn range(&self, axis: usize) -> Option<[f64; 2]> {
        let [high, low] = self.0[axis];
        Some([high?.first.0, low?.first.0])
    }

    /// Whether all are finite numbers, after reading them from outside.
    pub fn is_whole(&self) -> bool {
        let all = self.0.iter().flatten().flatten();
        let numbers = |end: &End| end.first.0.is_finite() && end.next.is_none_or(|next| next.0.is_finite());
        all.into_iter().all(numbers)
    }
}

/// The first sensor that stands at an end.
pub fn sensor(at: At) -> Option<Axis> {
    Axis::ALL.into_iter().find(|axis| at >> (2 * axis.index()) & 3 != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn piles_of_parts_are_those_of_all() {
        let value = |row: usize| [(row as f64 * 0.7).sin().clamp(-0.9, 2.0), row as f64, -(row as f64)];
        let rows: Vec<[f64; 3]> = (0..100).map(value).collect();
        let of = |rows: &[[f64; 3]]| {
            let mut ends = Ends::default();
            for row in rows {
                ends.take(*row);
            }
            ends
        };
        let whole = of(&rows);
        assert_eq!(whole.piles(), 2);
        for cuts in [[10, 50], [1, 3], [90, 99]] {
            let parts = [&rows[..cuts[0]], &rows[cuts[0]..cuts[1]], &rows[cuts[1]..]];
            for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
                let mut joined = Ends::default();
                for part in order {
                    joined.merge(&of(parts[part]));
                }
                assert_eq!(joined, whole);
            }
        }
        assert_eq!(sensor(whole.at([-0.9, 0.0, 0.0], whole.piles())), Some(Axis::X));
        assert_eq!(sensor(whole.at([0.1, 99.0, 0.0], whole.piles())), None);
    }
}
