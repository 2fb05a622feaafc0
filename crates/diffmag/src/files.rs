//! Rows of files, which become statistics of long series.

use common::procedure;
use partial::{Series, Take};

use crate::stream::{self, Batch, Grid, Partial, Statistics};

/// Two magnetometers side by side in the columns of a table or a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// From one sample to the next, s; None: found from the first rows.
    pub step_s: Option<f64>,
    /// The columns of the reference are this with `_x_nt`, `_y_nt`, `_z_nt`.
    pub reference: String,
    /// Those of the test instrument.
    pub test: String,
}

impl Default for Columns {
    fn default() -> Self {
        Columns { step_s: None, reference: "reference".into(), test: "test".into() }
    }
}

impl Series for Columns {
    type Partial = Partial;
    type Take = Pair;
    const PROCEDURE: &'static str = procedure::DIFFERENTIAL;

    fn begin(&self, there: &[String]) -> Result<(Vec<String>, Pair), String> {
        let axes = |instrument: &str| ["x", "y", "z"].map(|axis| format!("{instrument}_{axis}_nt"));
        let names: Vec<String> =
            std::iter::once("time_s".into()).chain(axes(&self.reference)).chain(axes(&self.test)).collect();
        let absent: Vec<String> =
            names.iter().filter(|name| !there.contains(name)).map(|name| format!("`{name}`")).collect();
        if !absent.is_empty() {
            return Err(absent.join(", "));
        }
        Ok((names, Pair { step_s: self.step_s, statistics: None }))
    }
}

/// Takes rows; the first ones start the statistics.
pub struct Pair {
    step_s: Option<f64>,
    statistics: Option<Statistics>,
}

impl Take for Pair {
    type Partial = Partial;

    fn push(&mut self, columns: &[&[f64]]) -> Result<(), stream::Error> {
        let [time_s, rx, ry, rz, tx, ty, tz] = std::array::from_fn(|k| columns[k]);
        if self.statistics.is_none() {
            self.statistics = Some(match (self.step_s, time_s.first()) {
                (Some(step_s), Some(first)) => Statistics::on(Grid::of(step_s, *first)?),
                _ => Statistics::new(),
            });
        }
        let rows = Batch { time_s, reference_nt: [rx, ry, rz], test_nt: [tx, ty, tz] };
        self.statistics.get_or_insert_default().push(&rows)
    }

    fn finish(self) -> Result<Partial, stream::Error> {
        Ok(self.statistics.unwrap_or_default().finish())
    }
}
