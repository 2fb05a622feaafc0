//! Rows of files, which become statistics of long series.

use common::{Axis, procedure};
use partial::{Series, Take};

use crate::read::{Source, columns, unit_of};
use crate::stream::{self, Batch, Partial, Statistics};

/// Sensors beside the magnitude of the field, in the columns of a table or a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Columns;

impl Series for Columns {
    type Partial = Partial;
    type Take = Statistics;
    const PROCEDURE: &'static str = procedure::FREE_RUN;

    fn begin(&self, there: &[String]) -> Result<(Vec<String>, Statistics), String> {
        let has = |name: &String| there.contains(name);
        let unit = unit_of(has).ok_or("`sensor_x_v`, `sensor_y_v`, `sensor_z_v` (or `_nt`)")?;
        let ambient = Axis::ALL.map(|axis| format!("ambient_{axis}_nt"));
        let reference = "reference_nt".to_string();
        let (source, magnitude) = if has(&reference) {
            (Source::Scalar, vec![reference])
        } else if ambient.iter().all(has) {
            (Source::Ambient, ambient.to_vec())
        } else {
            return Err("`reference_nt`, or `ambient_x_nt`, `ambient_y_nt`, `ambient_z_nt`".into());
        };
        let time = "time_s".to_string();
        if !has(&time) {
            return Err("`time_s`".into());
        }
        let names = std::iter::once(time).chain(columns(unit)).chain(magnitude).collect();
        Ok((names, Statistics::new(unit, source)))
    }
}

impl Take for Statistics {
    type Partial = Partial;

    fn push(&mut self, columns: &[&[f64]]) -> Result<(), stream::Error> {
        let [time_s, x, y, z, magnitude @ ..] = columns else {
            let (found, expected) = (columns.len(), 5);
            return Err(partial::Error::Lengths { found, expected }.into());
        };
        let length: Vec<f64>;
        let magnitude_nt = match magnitude {
            [bx, by, bz] => {
                length = (0..bx.len()).map(|row| bx[row].hypot(by[row]).hypot(bz[row])).collect();
                &length
            }
            _ => magnitude[0],
        };
        Statistics::push(self, &Batch { time_s, readings: [x, y, z], magnitude_nt })
    }

    fn finish(self) -> Result<Partial, stream::Error> {
        Ok(Statistics::finish(self))
    }
}
