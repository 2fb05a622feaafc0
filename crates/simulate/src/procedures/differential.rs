use common::number::{bare, duration};
use common::{Conditions, Error, procedure};
use serde::{Deserialize, Serialize};

use super::{MONTH_S, Sequence, whole};
use crate::bench::{Bench, positive, samples};
use crate::planned::{Planned, Reads, Rows, Surroundings};

/// A reference and a test magnetometer side by side in the natural field: a month at one sample a minute.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DifferentialProcedure {
    /// The recording's id.
    pub id: String,
    /// Length, s.
    #[serde(default = "whole::<MONTH_S>")]
    pub length_s: f64,
    /// From one sample to the next, s.
    #[serde(default = "whole::<60>")]
    pub step_s: f64,
}

impl Sequence for DifferentialProcedure {
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error> {
        positive(path, [("length_s", self.length_s), ("step_s", self.step_s)])?;
        if bench.outside.is_none() {
            let expected = "the natural field that both magnetometers see: main_field_nt and its variations";
            return Err(Error::document("truth.outside", "no such key", expected));
        }
        if bench.differential.is_none() {
            let expected = "the axes and scales of the two magnetometers";
            return Err(Error::document("truth.differential", "no such key", expected));
        }
        samples(path, self.length_s / self.step_s, 5.0)
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let mut rows = Rows::new("both magnetometers on their pillars", bench.timing.orientation_s);
        let action = format!("record {} at {} s", duration(self.length_s), bare(self.step_s));
        rows.series(bench.record(action, self.length_s, self.step_s), self.step_s, |_| {
            nalgebra::Vector3::zeros()
        });
        let (id, kind) = (self.id.clone(), procedure::DIFFERENTIAL);
        Ok(vec![Planned {
            reads: Reads::Differential,
            surroundings: Surroundings::Open,
            ..Planned::new(kind, id, path, Conditions::default(), rows, &[])
        }])
    }
}
