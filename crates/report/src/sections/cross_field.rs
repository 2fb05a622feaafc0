//! Sensitivity and offset with fields across the sensor.

use common::{Axis, CrossFieldFit, Document};

use super::departures;
use super::effects::{self, findings};
use crate::plot::{Dimension, Mark, Plot, Series};
use crate::{Cell, Section, Table};

/// The section; None where the document has nothing of it.
pub fn section(document: &Document) -> Option<Section> {
    let sensors = document.calibration.as_ref()?.sensors.as_ref()?;
    let mut section = Section::new("cross-field", "Fields transverse to the sensor");
    let mut table = Table::new(
        "Coefficients, at 50000 nT across (and along, for the sensitivity)",
        [("sensor", ""), ("of", ""), ("coefficient", ""), ("value", "nT")],
    );
    let mut tests = Table::new(
        "Significance, and the effect of the correction on held-out readings",
        [
            ("sensor", ""),
            ("difference, p", ""),
            ("effect, p", ""),
            ("rms before", "nT"),
            ("corrected as applied", "nT"),
            ("first pass", "nT"),
            ("second pass", "nT"),
            ("readings", ""),
        ],
    );
    let mut leaning = Table::new(
        "Directions of the sensors towards the coil across",
        [("sensor", ""), ("recording", ""), ("coil", ""), ("angle", "arcsec")],
    );
    let mut looked_for = departures::table("sensor");
    let mut plots = Vec::new();
    for (axis, sensor) in sensors.iter() {
        let Some(fit) = &sensor.cross_field else { continue };
        let name = format!("sensor {axis}");
        section.warnings.extend(findings(&name, &fit.findings, &effects::conditions::CROSS_FIELD, fit));
        for (of, parameters) in [("offset", &fit.offset), ("sensitivity", &fit.sensitivity)] {
            for (key, value) in parameters {
                let (words, _) = page::words::key(key);
                table.row([name.as_str().into(), of.into(), words.into(), value.into()]);
            }
        }
        let held_out = fit.held_out.as_ref();
        tests.row([
            name.as_str().into(),
            fit.difference.map_or(Cell::Empty, |test| Cell::Probability(test.p_value)),
            fit.significance.map_or(Cell::Empty, |test| Cell::Probability(test.p_value)),
            held_out.map(|held_out| Cell::Figures(held_out.before_nt, 3)).into(),
            held_out.map(|held_out| Cell::Figures(held_out.after_nt, 3)).into(),
            held_out.and_then(|held_out| held_out.first_pass_nt).map(|nt| Cell::Figures(nt, 3)).into(),
            held_out.and_then(|held_out| held_out.second_pass_nt).map(|nt| Cell::Figures(nt, 3)).into(),
            held_out.map(|held_out| held_out.readings).into(),
        ]);
        for one in &fit.misalignments {
            leaning.row([
                name.as_str().into(),
                one.recording.as_str().into(),
                one.coil.as_str().into(),
                (&one.angle_arcsec).into(),
            ]);
        }
        departures::add(&mut looked_for, &name, &fit.departures);
        plots.push(levels(axis, fit).into());
    }
    section.table(table);
    section.table(tests);
    section.plots_side_by_side(plots);
    section.table(leaning);
    section.table(looked_for);
    (!section.items.is_empty()).then_some(section)
}

/// k and O against the field across, a series for each recording.
fn levels(axis: Axis, fit: &CrossFieldFit) -> [Plot; 2] {
    let levels = &fit.levels;
    let x = || Dimension::linear("field across", "nT");
    let mut sensitivity = Plot::new(
        format!("cross-field-{axis}-sensitivity"),
        format!("Sensor {axis}: sensitivity"),
        x(),
        Dimension::linear("k from that of the first", "ppm"),
    );
    let mut offset = Plot::new(
        format!("cross-field-{axis}-offset"),
        format!("Sensor {axis}: offset"),
        x(),
        Dimension::linear("offset", "nT"),
    )
    .note(
        "A straight line is the sensor's direction, which belongs to the axes; the effect is what bends it.",
    );
    let k0 = levels.sensitivity.first().copied().unwrap_or(f64::NAN);
    for (number, recording) in fit.recordings.iter().enumerate() {
        let of = |column: &[f64]| -> Vec<f64> {
            let rows = levels.recording.iter().zip(column).filter(|(of, _)| **of == number);
            rows.map(|(_, value)| *value).collect()
        };
        let across = of(&levels.across_nt);
        let k: Vec<f64> = of(&levels.sensitivity).into_iter().map(|k| 1e6 * (k / k0 - 1.0)).collect();
        let k_std: Vec<f64> = of(&levels.sensitivity_std).into_iter().map(|std| 1e6 * std / k0).collect();
        sensitivity.push(Series::new(recording, Mark::Points, number, &across, &k).with_std(&k_std));
        offset.push(
            Series::new(recording, Mark::Points, number, &across, &of(&levels.offset_nt))
                .with_std(&of(&levels.offset_std_nt)),
        );
    }
    [sensitivity, offset]
}
