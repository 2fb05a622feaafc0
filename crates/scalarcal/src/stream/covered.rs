//! The times that pieces cover.

use serde::{Deserialize, Serialize};

use super::Error;

/// Stretches at most; of more the two with the shortest time between them are taken as one.
const MOST: usize = 512;

/// First and last moment of each stretch, s.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Covered(Vec<[f64; 2]>);

impl Covered {
    /// Adds a stretch.
    ///
    /// # Errors
    ///
    /// [`Error::Overlap`] where a part of it is there.
    pub fn add(&mut self, stretch: [f64; 2]) -> Result<(), Error> {
        let place = self.0.partition_point(|other| other[1] < stretch[0]);
        if let Some(other) = self.0.get(place).filter(|other| other[0] <= stretch[1]) {
            let (from_s, to_s) = (stretch[0].max(other[0]), stretch[1].min(other[1]));
            return Err(Error::Overlap { from_s, to_s });
        }
        self.0.insert(place, stretch);
        if self.0.len() > MOST {
            let between = |place: &usize| self.0[place + 1][0] - self.0[*place][1];
            let shortest = (0..MOST).min_by(|a, b| between(a).total_cmp(&between(b)));
            let place = shortest.expect("there is one between");
            self.0[place][1] = self.0.remove(place + 1)[1];
        }
        Ok(())
    }

    /// Adds all of another.
    ///
    /// # Errors
    ///
    /// As [`Covered::add`].
    pub fn merge(&mut self, other: &Self) -> Result<(), Error> {
        other.0.iter().try_for_each(|stretch| self.add(*stretch))
    }

    /// The first and the last moment, s.
    pub fn span_s(&self) -> Option<[f64; 2]> {
        Some([self.0.first()?[0], self.0.last()?[1]])
    }

    /// Whether they rise, after reading them from outside.
    pub fn is_whole(&self) -> bool {
        let all: Vec<f64> = self.0.iter().flatten().copied().collect();
        self.0.len() <= MOST && all.iter().all(|time| time.is_finite()) && all.is_sorted()
    }
}
