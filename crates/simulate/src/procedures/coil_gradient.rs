use common::number::bare;
use common::{Axis, Conditions, Error, procedure};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::sequence::Sequence;
use crate::bench::{Bench, on, positive, samples};
use crate::planned::{Planned, Rows};

/// Field of one coil along its axis at the largest drive, by the scalar magnetometer: every 6 inches across
/// the 3 feet of the test volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CoilGradientProcedure {
    /// The recording's id.
    pub id: String,
    /// The coil.
    pub coil: Axis,
    /// The drive, nT; absent: the largest that the facility states.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field_nt: Option<f64>,
    /// From one place to the next, m.
    #[serde(default = "six_inches")]
    pub step_m: f64,
    /// Steps to either side of the centre.
    #[serde(default = "three")]
    pub steps: usize,
    /// Readings at each place.
    #[serde(default = "ten")]
    pub repeats: usize,
}

fn six_inches() -> f64 {
    0.1524
}

fn three() -> usize {
    3
}

fn ten() -> usize {
    10
}

impl CoilGradientProcedure {
    fn field(&self, bench: &Bench<'_>) -> f64 {
        self.field_nt.or(bench.max_nt(self.coil)).unwrap_or(0.0)
    }
}

impl Sequence for CoilGradientProcedure {
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error> {
        positive(path, "step_m", self.step_m)?;
        positive(path, "repeats", self.repeats as f64)?;
        if self.field_nt.is_none() && bench.max_nt(self.coil).is_none() {
            let expected = format!("the drive, or facility.coils.{}.max_nt, at which it is taken", self.coil);
            return Err(Error::document(format!("{path}.field_nt"), "no such key", expected));
        }
        positive(path, "field_nt", self.field(bench))?;
        bench.within(self.coil, self.field(bench), &format!("{path}.field_nt"))?;
        bench.scalar_reads(self.field(bench), &format!("{path}.field_nt"))?;
        samples(path, (2.0 * self.steps as f64 + 1.0) * self.repeats as f64, 1.0)
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let field = self.field(bench);
        let mut rows =
            Rows::new(format!("{} nT on coil {}", bare(field), self.coil), bench.timing.orientation_s);
        for place in 0..2 * self.steps + 1 {
            let position = (place as f64 - self.steps as f64) * self.step_m;
            let action = format!("scalar magnetometer to {} m along coil {}", bare(position), self.coil);
            let step = bench.set(action, on(self.coil, field), self.repeats);
            rows.step(step, bench.timing, &[("position_m", position)]);
        }
        let conditions = Conditions { coil: Some(self.coil), ..Conditions::default() };
        let id = self.id.clone();
        Ok(vec![Planned::new(procedure::COIL_GRADIENT, id, path.into(), conditions, rows, &[self.coil])])
    }
}
