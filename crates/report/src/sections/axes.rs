//! Directions of sensors and coils.

use common::{AxesCalibration, AxesReadings, Axis, Calibration};

use super::{Plots, axes_map};
use crate::plot::{Plot, Series};

pub fn plots(plots: &mut Plots, calibration: &Calibration) {
    let axes = calibration.axes.as_ref();
    let subset = axes.and_then(|axes| axes.subset.as_deref());
    for (id, axes) in [("axes", axes), ("axes-alone", subset)] {
        let Some(axes) = axes else { continue };
        for (of, directions) in [("sensors", &axes.sensors), ("coils", &axes.coils)] {
            let id = format!("{id}-{of}");
            let maps = directions.iter().flat_map(|directions| axes_map::maps(&id, of, directions)).collect();
            plots.insert(id, maps);
        }
        let residuals = axes.readings.iter().flat_map(|readings| residuals(id, axes, readings));
        plots.insert(format!("{id}-residuals"), residuals.collect());
    }
}

/// Residuals of the readings, and the same without outliers where there are some.
fn residuals(id: &str, axes: &AxesCalibration, readings: &AxesReadings) -> Vec<Plot> {
    let is_doubtful = |row: usize| {
        axes.doubtful.iter().any(|one| {
            readings.sensor.get(row) == Some(&one.sensor)
                && readings.row.get(row) == Some(&one.row)
                && readings.recording.get(row) == Some(&one.recording)
        })
    };
    let draw = |(end, title, doubtful): (&str, &str, bool)| {
        let plot =
            Plot::new(format!("{id}-residuals{end}"), title).axes("reading", "reading less prediction [nT]");
        Axis::ALL.into_iter().fold(plot, |plot, axis| {
            let of =
                |row: &usize| readings.sensor.get(*row) == Some(&axis) && (doubtful || !is_doubtful(*row));
            let rows = (0..readings.residual_nt.len()).filter(of);
            let (x, y): (Vec<f64>, Vec<f64>) =
                rows.map(|row| ((row + 1) as f64, readings.residual_nt[row])).unzip();
            plot.with(Series::points(format!("sensor {axis}"), axis.index(), &x, &y))
        })
    };
    let both = [
        ("", "Residuals of the readings, orientation by orientation", true),
        ("-left", "The same without the outliers", false),
    ];
    both.into_iter().filter(|(.., doubtful)| *doubtful || !axes.doubtful.is_empty()).map(draw).collect()
}
