//! Rows of files, which become statistics of long series.

use common::procedure;
use partial::Series;

use crate::stream::{Partial, Statistics};

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
    type Take = Statistics;
    const PROCEDURE: &'static str = procedure::DIFFERENTIAL;

    fn begin(&self, there: &[String]) -> Result<(Vec<String>, Statistics), String> {
        let axes = |instrument: &str| ["x", "y", "z"].map(|axis| format!("{instrument}_{axis}_nt"));
        let names: Vec<String> =
            std::iter::once("time_s".into()).chain(axes(&self.reference)).chain(axes(&self.test)).collect();
        let absent: Vec<String> =
            names.iter().filter(|name| !there.contains(name)).map(|name| format!("`{name}`")).collect();
        if !absent.is_empty() {
            return Err(absent.join(", "));
        }
        Ok((names, Statistics::every(self.step_s)))
    }
}
