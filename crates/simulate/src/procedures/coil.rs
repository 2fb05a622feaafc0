use common::number::bare;
use common::{Axis, Conditions, Error, procedure};
use serde::{Deserialize, Serialize};

use super::{Sequence, count, whole};
use crate::bench::{Bench, on, positive, samples};
use crate::planned::{Planned, Rows};

/// Field of one coil against its current, by the scalar magnetometer: from the smallest field that it reads
/// to the largest of the coil in steps, the same with the current reversed, ten readings of each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CoilConstantProcedure {
    /// The recording's id.
    pub id: String,
    /// The coil.
    pub coil: Axis,
    /// Smallest field, nT.
    #[serde(default = "whole::<20_000>")]
    pub from_nt: f64,
    /// Largest field, nT.
    #[serde(default = "whole::<60_000>")]
    pub to_nt: f64,
    /// From one field to the next, nT.
    #[serde(default = "whole::<5_000>")]
    pub step_nt: f64,
    /// Readings at each.
    #[serde(default = "count::<10>")]
    pub repeats: usize,
}

impl CoilConstantProcedure {
    fn levels(&self) -> f64 {
        ((self.to_nt - self.from_nt) / self.step_nt + 1e-9).floor() + 1.0
    }
}

impl Sequence for CoilConstantProcedure {
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error> {
        positive(
            path,
            [("step_nt", self.step_nt), ("from_nt", self.from_nt), ("repeats", self.repeats as f64)],
        )?;
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
                let action = format!("{} nT on coil {}", bare(field), self.coil);
                let step = bench.set(action, on(self.coil, field), self.repeats);
                rows.step(step, bench.timing, &[]);
            }
        }
        let conditions = Conditions { coil: Some(self.coil), ..Conditions::default() };
        let id = self.id.clone();
        Ok(vec![Planned::new(procedure::COIL_CONSTANT, id, path, conditions, rows, &[self.coil])])
    }
}

/// Field of one coil along its axis at the largest drive, by the scalar magnetometer: every 6 inches across
/// the 3 feet of the test volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    #[serde(default = "count::<3>")]
    pub steps: usize,
    /// Readings at each place.
    #[serde(default = "count::<10>")]
    pub repeats: usize,
}

fn six_inches() -> f64 {
    0.1524
}

impl CoilGradientProcedure {
    fn field(&self, bench: &Bench<'_>) -> f64 {
        self.field_nt.or(bench.max_nt(self.coil)).unwrap_or(0.0)
    }
}

impl Sequence for CoilGradientProcedure {
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error> {
        positive(path, [("step_m", self.step_m), ("repeats", self.repeats as f64)])?;
        if self.field_nt.is_none() && bench.max_nt(self.coil).is_none() {
            let expected = format!("the drive, or facility.coils.{}.max_nt, at which it is taken", self.coil);
            return Err(Error::document(format!("{path}.field_nt"), "no such key", expected));
        }
        positive(path, [("field_nt", self.field(bench))])?;
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
        Ok(vec![Planned::new(procedure::COIL_GRADIENT, id, path, conditions, rows, &[self.coil])])
    }
}
