use common::{Axis, Columns, Conditions, Error, Recording, procedure};
use serde::{Deserialize, Serialize};

use super::Sequence;
use crate::bench::Bench;
use crate::planned::{Begins, Planned, Reads, Step};

/// A recording with columns of its own; the readings are added.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FreeRun {
    /// The recording's id.
    pub id: String,
    /// What holds throughout.
    #[serde(default)]
    pub conditions: Conditions,
    /// Times, drive, temperatures.
    pub columns: Columns,
    /// Record the natural field outside beside.
    #[serde(default)]
    pub outside: bool,
}

impl Sequence for FreeRun {
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error> {
        let readings = |name: &&String| name.starts_with("sensor_") && !name.contains("temperature");
        let refused = |name: &str, found: &str, expected: &str| {
            Err(Error::document(format!("{path}.columns{name}"), found, expected))
        };
        if let Some(name) = self.columns.keys().find(readings) {
            let expected = "drive, times and temperatures only; the readings are simulated";
            return refused(&format!(".{name}"), "a column of readings", expected);
        }
        if self.columns.values().all(|column| column.is_empty()) {
            return refused("", "no rows", "at least one row of times or drive");
        }
        for axis in Axis::ALL {
            if self.columns.contains_key(&format!("coil_{axis}_v")) {
                let expected = format!("`coil_{axis}_a`, the current that flows");
                return refused(&format!(".coil_{axis}_v"), "a drive in V", &expected);
            }
            let Some(column) = self.columns.get(&format!("coil_{axis}_a")) else { continue };
            let largest = column.iter().map(|current| current.abs()).fold(0.0, f64::max);
            let constant = bench.stated.coils[axis.index()].constant_nt_per_a;
            let field = if constant == 0.0 { largest } else { largest * constant.abs() };
            bench.within(axis, field, &format!("{path}.columns.coil_{axis}_a"))?;
        }
        Ok(self.columns.values().map(|column| column.len()).max().unwrap_or(0) as f64)
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let recording = Recording {
            id: self.id.clone(),
            procedure: procedure::FREE_RUN.into(),
            conditions: self.conditions.clone(),
            columns: self.columns.clone(),
            ..Recording::default()
        };
        let rotation = physics::orientation(bench.document, &recording)
            .map_err(|error| error.at(&format!("{path}.conditions.orientation")))?
            .rotation;
        let times = recording.column("time_s").unwrap_or_default();
        let last = times.iter().copied().filter(|t| t.is_finite()).fold(0.0, f64::max);
        let step = Step::still("as the columns say".into(), 0.0, recording.rows(), last);
        Ok(vec![Planned {
            rotation,
            nominal: rotation,
            reads: Reads::Sensors(bench.sensors(&None, path)?),
            outside: self.outside,
            begins: Begins::AsItSays,
            ..Planned::of(recording, path, vec![step])
        }])
    }
}
