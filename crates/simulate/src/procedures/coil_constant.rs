use common::number::bare;
use common::{Axis, Conditions, Error, procedure};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::sequence::Sequence;
use crate::bench::{Bench, on, positive, samples};
use crate::planned::{Planned, Rows};

/// Field of one coil against its current, by the scalar magnetometer: from the smallest field that it reads
/// to the largest of the coil in steps, the same with the current reversed, ten readings of each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CoilConstantProcedure {
    /// The recording's id.
    pub id: String,
    /// The coil.
    pub coil: Axis,
    /// Smallest field, nT.
    #[serde(default = "from")]
    pub from_nt: f64,
    /// Largest field, nT.
    #[serde(default = "to")]
    pub to_nt: f64,
    /// From one field to the next, nT.
    #[serde(default = "step")]
    pub step_nt: f64,
    /// Readings at each.
    #[serde(default = "ten")]
    pub repeats: usize,
}

fn from() -> f64 {
    20_000.0
}

fn to() -> f64 {
    60_000.0
}

fn step() -> f64 {
    5_000.0
}

fn ten() -> usize {
    10
}

impl CoilConstantProcedure {
    fn levels(&self) -> f64 {
        ((self.to_nt - self.from_nt) / self.step_nt + 1e-9).floor() + 1.0
    }
}

impl Sequence for CoilConstantProcedure {
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error> {
        positive(path, "step_nt", self.step_nt)?;
        positive(path, "from_nt", self.from_nt)?;
        positive(path, "repeats", self.repeats as f64)?;
        if self.to_nt < self.from_nt {
            let found = format!("{}, below from_nt = {}", self.to_nt, self.from_nt);
            return Err(Error::document(format!("{path}.to_nt"), found, "the largest field of the range"));
        }
        bench.within(self.coil, self.to_nt, &format!("{path}.to_nt"))?;
        bench.scalar_reads(self.from_nt, &format!("{path}.from_nt"))?;
        bench.scalar_reads(self.to_nt, &format!("{path}.to_nt"))?;
        samples(path, 2.0 * self.levels() * self.repeats as f64, 2.0)
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let mut rows = Rows::new("scalar magnetometer to the coils' centre", bench.timing.orientation_s);
        for sign in [1.0, -1.0] {
            for level in 0..self.levels() as usize {
                let field = sign * (self.from_nt + level as f64 * self.step_nt);
                let step = bench.set(
                    format!("{} nT on coil {}", bare(field), self.coil),
                    on(self.coil, field),
                    self.repeats,
                );
                rows.step(step, bench.timing, &[]);
            }
        }
        let conditions = Conditions { coil: Some(self.coil), ..Conditions::default() };
        let id = self.id.clone();
        Ok(vec![Planned::new(procedure::COIL_CONSTANT, id, path.into(), conditions, rows, &[self.coil])])
    }
}
