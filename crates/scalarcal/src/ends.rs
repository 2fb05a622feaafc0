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
/// All six ends.
const ALL: At = 0b11_1111;

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
        let row = Self(readings.map(|value| [Some(End { first: (value, 1), next: None }); 2]));
        let (moved, beside) = self.merge(&row);
        (ALL & !beside, moved)
    }

    /// Takes the ends of other rows; gives the ends that were moved here, and those that are not the furthest
    /// there.
    pub fn merge(&mut self, other: &Self) -> (At, At) {
        let (mut here, mut there) = (0, 0);
        for (place, (mine, theirs)) in self.0.iter_mut().flatten().zip(other.0.iter().flatten()).enumerate() {
            let (Some(theirs), sign) = (theirs, SIGNS[place % 2]) else { continue };
            let Some(mine) = mine else {
                *mine = Some(*theirs);
                continue;
            };
            if mine.take(theirs.first, sign) {
                here |= 1 << place;
            } else if mine.first.0 != theirs.first.0 {
                there |= 1 << place;
            }
            if let Some(next) = theirs.next {
                mine.take(next, sign);
            }
        }
        (here, there)
    }

    /// The ends at which readings are piled up.
    pub fn piles(&self) -> At {
        self.those(|_, end| end.is_pile())
    }

    /// The ends, among some, at which a row stands.
    pub fn at(&self, readings: [f64; 3], among: At) -> At {
        among & self.those(|axis, end| end.first.0 == readings[axis])
    }

    /// The ends of which something holds, by sensor and end.
    fn those(&self, holds: impl Fn(usize, &End) -> bool) -> At {
        let ends = self.0.iter().flatten().enumerate();
        let of = |(place, end): (usize, &Option<End>)| {
            At::from(end.as_ref().is_some_and(|end| holds(place / 2, end))) << place
        };
        ends.map(of).sum()
    }

    /// The largest and the smallest reading of a sensor.
    pub fn range(&self, axis: usize) -> Option<[f64; 2]> {
        let [high, low] = self.0[axis];
        Some([high?.first.0, low?.first.0])
    }

    /// Whether all are finite numbers, after reading them from outside.
    pub fn is_whole(&self) -> bool {
        let all = self.0.iter().flatten().flatten();
        all.flat_map(|end| [Some(end.first), end.next]).flatten().all(|(value, _)| value.is_finite())
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
