//! The joint uncertainty of what a document states.

use faer::Mat;

use super::joint::{Block, SAME, Uncertainty};
use super::stated::{Group, groups};
use crate::{Document, Error};

impl Uncertainty {
    /// Of all that a document states with an uncertainty: what `calibration.uncertainty` says, and where a
    /// stated standard uncertainty is not (or no longer) the one that follows from it, what is stated, with
    /// the covariance that stands beside it.
    ///
    /// # Errors
    ///
    /// A parameter that is undetermined; a stated covariance that none can be.
    pub fn of(document: &Document) -> Result<Self, Error> {
        let mut joint = document
            .calibration
            .as_ref()
            .and_then(|calibration| calibration.uncertainty.clone())
            .unwrap_or_default();
        for group in groups(document)? {
            joint.state(group)?;
        }
        Ok(joint)
    }

    /// What is stated of parameters counts where it is not what the sources say.
    fn state(&mut self, group: Group) -> Result<(), Error> {
        let is_undetermined = |place: &usize| !group.covariance[(*place, *place)].is_finite();
        if let Some(place) = (0..group.parameters.len()).find(is_undetermined) {
            return Err(Error::document(
                &group.parameters[place],
                "null: the recordings do not determine it, or its uncertainty",
                "a number with its uncertainty; determine it by further measurements, or leave the key out",
            ));
        }
        let std = |place: usize| group.covariance[(place, place)].max(0.0).sqrt();
        let largest = (0..group.parameters.len()).map(std).fold(0.0, f64::max);
        let anew: Vec<usize> = (0..group.parameters.len())
            .filter(|place| {
                let apart = (self.std(&group.parameters[*place]) - std(*place)).abs();
                apart > SAME * if group.alike { largest } else { std(*place) }
            })
            .collect();
        if anew.is_empty() {
            return Ok(());
        }
        // Of directions, one cosine that is not the same is another set of directions.
        let anew = if group.alike { (0..group.parameters.len()).collect() } else { anew };
        let block = Block {
            name: group.name,
            degrees_of_freedom: f64::INFINITY,
            parameters: anew.iter().map(|place| group.parameters[*place].clone()).collect(),
            covariance: Mat::from_fn(anew.len(), anew.len(), |a, b| group.covariance[(anew[a], anew[b])]),
            by: Vec::new(),
        };
        self.put(block).map_err(|found| {
            let expected = "covariances no larger than the product of the two standard uncertainties";
            Error::document(group.path, found, expected)
        })
    }
}
