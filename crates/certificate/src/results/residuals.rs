//! What the calibration leaves of its own readings.

use common::Document;
use page::{Cell, Table};

use crate::sheet::Sheet;

/// The rms and the largest residual of each fit.
pub fn table(sheet: &mut Sheet, document: &Document) {
    let Some(calibration) = &document.calibration else { return };
    let mut table = Table::new(
        "Residuals after calibration",
        [("fit", ""), ("readings", ""), ("rms", "nT"), ("largest", "nT")],
    );
    let mut add = |of: String, readings: Option<usize>, rms: f64, all: &[f64]| {
        let largest = all.iter().map(|one| one.abs()).fold(0.0, f64::max);
        let largest = if all.is_empty() { Cell::Empty } else { Cell::Figures(largest, 3) };
        table.row([of.into(), readings.into(), Cell::Figures(rms, 3), largest]);
    };
    for (axis, coil) in calibration.coils.iter().flat_map(|coils| coils.iter()) {
        let Some(fit) = &coil.constant else { continue };
        // Its residuals are means of levels, the rms is that of single readings.
        add(format!("coil {axis}, constant"), Some(fit.readings), fit.rms_nt, &[]);
    }
    for (axis, sensor) in calibration.sensors.iter().flat_map(|sensors| sensors.iter()) {
        if let Some(fit) = &sensor.sensitivity {
            let all = &fit.residuals.residual_nt;
            add(format!("sensor {axis}, sensitivity"), Some(fit.readings), fit.noise.rms_nt, all);
        }
        if let Some(fit) = &sensor.temperature {
            add(format!("sensor {axis}, temperature"), None, fit.noise.rms_nt, &[]);
        }
        if let Some(fit) = &sensor.cross_field {
            add(format!("sensor {axis}, transverse fields"), None, fit.noise.rms_nt, &[]);
        }
        if let Some(drift) = &sensor.drift {
            let all = &drift.dates.residual_nt;
            let rms = (all.iter().map(|one| one * one).sum::<f64>() / all.len().max(1) as f64).sqrt();
            add(format!("sensor {axis}, offset from date to date"), Some(all.len()), rms, all);
        }
    }
    if let Some(axes) = &calibration.axes
        && let Some(fit) = &axes.fit
    {
        let all = axes.readings.as_ref().map(|readings| readings.residual_nt.as_slice()).unwrap_or_default();
        add("directions".into(), Some(fit.readings), fit.rms_nt, all);
    }
    if let Some(scalar) = &calibration.scalar {
        add("magnitude of the field, |B| − F".into(), Some(scalar.rows as usize), scalar.rms_nt, &[]);
    }
    if let Some(fit) = calibration.differential.as_ref().and_then(|found| found.fit.as_ref()) {
        for (axis, one) in fit.axes.iter() {
            add(format!("test axis {axis} against the reference"), Some(fit.samples), one.left_nt(), &[]);
        }
    }
    sheet.table(table);
}
