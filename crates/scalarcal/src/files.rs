//! Rows of files, which become statistics of long series.

use common::{Axis, procedure};
use partial::{Series, Take};
use physics::Unit;

use crate::read::Source;
use crate::stream::{self, Batch, Partial, Statistics};

/// Sensors beside the magnitude of the field, in the columns of a table or a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Columns;

impl Series for Columns {
    type Partial = Partial;
    type Take = Rows;
    const PROCEDURE: &'static str = procedure::FREE_RUN;

    fn begin(&self, there: &[String]) -> Result<(Vec<String>, Rows), String> {
        let has = |name: &String| there.contains(name);
        let sensors = |unit: &Unit| Axis::ALL.map(|axis| format!("sensor_{axis}_{}", unit.suffix()));
        let unit = [Unit::Volt, Unit::Nanotesla].into_iter().find(|unit| sensors(unit).iter().all(has));
        let unit = unit.ok_or("`sensor_x_v`, `sensor_y_v`, `sensor_z_v` (or `_nt`)")?;
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
        let names = std::iter::once(time).chain(sensors(&unit)).chain(magnitude).collect();
        Ok((names, Rows(Statistics::new(unit, source))))
    }
}

/// Takes rows.
pub struct Rows(Statistics);

impl Take for Rows {
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
        self.0.push(&Batch { time_s, readings: [x, y, z], magnitude_nt })
    }

    fn finish(self) -> Result<Partial, stream::Error> {
        Ok(self.0.finish())
    }
}
