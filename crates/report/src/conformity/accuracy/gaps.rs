//! What a budget lacks.

use common::Axis;

/// What is not in the budget, with the sensors of which that holds.
#[derive(Default)]
pub struct Gaps(Vec<(String, Vec<Axis>)>);

impl Gaps {
    /// Adds a gap of one sensor.
    pub fn add(&mut self, axis: Axis, why: &str) {
        match self.0.iter_mut().find(|(known, _)| known == why) {
            Some((_, axes)) if axes.contains(&axis) => {}
            Some((_, axes)) => axes.push(axis),
            None => self.0.push((why.into(), vec![axis])),
        }
    }

    /// A sentence each.
    pub fn sentences(self) -> Vec<String> {
        let sentence = |(why, axes): (String, Vec<Axis>)| match axes.as_slice() {
            [axis] => format!("sensor {axis}: {why}"),
            axes => {
                let names: Vec<&str> = axes.iter().map(|axis| axis.letter()).collect();
                format!("sensors {}: {why}", names.join(", "))
            }
        };
        self.0.into_iter().map(sentence).collect()
    }
}
