//! Each sensor: sensitivity, offset, deviation from the line, reversals, error budget.

use common::{Axis, Document, SensitivityFit, SensorCalibration};
use page::words::counted;

use super::departures;
use super::effects::{self, findings};
use crate::plot::{Dimension, Mark, Plot, Series};
use crate::{Cell, Section, Table};

/// The section; None where the document has nothing of it.
pub fn section(document: &Document) -> Option<Section> {
    let sensors = document.calibration.as_ref()?.sensors.as_ref()?;
    let mut section = Section::new("sensors", "Sensors");
    let volts = sensors.iter().any(|(_, sensor)| sensor.sensitivity_nt_per_v.is_some());
    let fields = sensors.iter().any(|(_, sensor)| sensor.sensitivity_nt_per_nt.is_some());
    section.words.push(match (volts, fields) {
        (false, true) => "B = k · reading + O along each sensor's own axis; the readings are fields, and k is a scale factor.".into(),
        _ => "B = k V + O along each sensor's own axis.".into(),
    });
    let mut constants = Table::new(
        "Constants",
        [
            ("sensor", ""),
            ("k", "nT/V"),
            ("k", "nT/nT"),
            ("O", "nT"),
            ("model", ""),
            ("readings", ""),
            ("rms of residuals", "nT"),
            ("normal, p", ""),
            ("runs, p", ""),
        ],
    );
    let mut budgets = Table::new(
        "Standard uncertainties of the fit in the coils, from scatter (type A) and from coil and temperatures (type B)",
        [("sensor", ""), ("parameter", ""), ("type A", ""), ("type B", ""), ("unit", "")],
    );
    let mut looked_for = departures::table("sensor");
    let mut plots = Vec::new();
    for (axis, sensor) in sensors.iter() {
        let name = format!("sensor {axis}");
        let fit = sensor.sensitivity.as_deref();
        let p = |test: Option<common::TestResult>| {
            test.map_or(Cell::Empty, |test| Cell::Probability(test.p_value))
        };
        constants.row([
            name.as_str().into(),
            sensor.sensitivity_nt_per_v.as_ref().into(),
            sensor.sensitivity_nt_per_nt.as_ref().into(),
            sensor.offset_nt.as_ref().into(),
            fit.map(|fit| fit.model.clone()).into(),
            fit.map(|fit| fit.readings).into(),
            fit.map(|fit| Cell::Figures(fit.noise.rms_nt, 3)).into(),
            p(fit.and_then(|fit| fit.normality)),
            p(fit.and_then(|fit| fit.runs)),
        ]);
        let Some(fit) = fit else { continue };
        section.warnings.extend(findings(&name, &fit.findings, &effects::sensors::SENSITIVITY, sensor));
        for (key, budget) in &fit.uncertainty {
            let (words, unit) = page::words::key(key);
            budgets.row([
                name.as_str().into(),
                words.into(),
                Cell::Figures(budget.type_a, 2),
                Cell::Figures(budget.type_b, 2),
                unit.into(),
            ]);
        }
        departures::add(&mut looked_for, &name, &fit.departures);
        plots.push(deviations(axis, fit));
        plots.extend(left(axis, fit));
    }
    section.table(constants);
    plots.into_iter().for_each(|plot| section.plot(plot));
    section.table(budgets);
    section.table(looked_for);
    reversals(&mut section, sensors.iter());
    error_budget(&mut section, sensors.iter());
    (!section.items.is_empty()).then_some(section)
}

fn deviations(axis: Axis, fit: &SensitivityFit) -> Plot {
    let residuals = &fit.residuals;
    let mut plot = Plot::new(
        format!("sensor-{axis}-deviations"),
        format!("Sensor {axis}: deviation from the line"),
        Dimension::linear("field along the sensor", "nT"),
        Dimension::linear("read less applied", "nT"),
    )
    .note(format!("{}; {}.", counted(fit.readings, "reading"), fit.order));
    plot.push(Series::new(
        "by the line",
        Mark::Points,
        axis.index(),
        &residuals.field_nt,
        &residuals.deviation_nt,
    ));
    plot
}

/// The residuals of what is fitted beside the line, on a scale of their own.
fn left(axis: Axis, fit: &SensitivityFit) -> Option<Plot> {
    let residuals = &fit.residuals;
    let model = fit.model.replace('_', " ");
    let mut plot = Plot::new(
        format!("sensor-{axis}-residuals"),
        format!("Sensor {axis}: residuals of the fit"),
        Dimension::linear("field along the sensor", "nT"),
        Dimension::linear("read less fitted", "nT"),
    )
    .note(format!("With {model} beside the line."));
    plot.push(Series::new(
        format!("by {model}"),
        Mark::Points,
        axis.index(),
        &residuals.field_nt,
        &residuals.residual_nt,
    ));
    (fit.model != "line").then_some(plot)
}

fn reversals<'a>(section: &mut Section, sensors: impl Iterator<Item = (Axis, &'a SensorCalibration)>) {
    let mut table = Table::new(
        "Offsets by turning the sensor through 180° in a shield: O = −k (V₁ + V₂)/2",
        [
            ("sensor", ""),
            ("recording", ""),
            ("O", "nT"),
            ("field of the shield", "nT"),
            ("its drift", "nT/s"),
            ("pairs used", ""),
            ("pairs", ""),
            ("bound for a turn not quite 180°", "nT"),
        ],
    );
    let mut plot = Plot::new(
        "reversals",
        "Offset from each pair of a reversal",
        Dimension::linear("pair", ""),
        Dimension::linear("offset", "nT"),
    );
    for (axis, sensor) in sensors {
        let Some(reversal) = &sensor.reversal else { continue };
        let name = format!("sensor {axis}, reversals");
        section.warnings.extend(findings(&name, &reversal.findings, &effects::sensors::REVERSAL, reversal));
        let mut offsets = Vec::new();
        for one in &reversal.recordings {
            table.row([
                format!("sensor {axis}").into(),
                one.recording.as_str().into(),
                (&one.offset_nt).into(),
                (&one.shield_field_nt).into(),
                one.shield_drift_nt_per_s.as_ref().into(),
                one.pairs.used.iter().filter(|used| **used).count().into(),
                one.pairs.used.len().into(),
                Cell::Figures(reversal.imperfect_turn.bound_nt, 2),
            ]);
            offsets.extend(&one.pairs.offset_nt);
        }
        let numbers: Vec<f64> = (1..=offsets.len()).map(|number| number as f64).collect();
        plot.push(Series::new(format!("sensor {axis}"), Mark::Points, axis.index(), &numbers, &offsets));
    }
    section.table(table);
    section.plot(plot);
}

fn error_budget<'a>(section: &mut Section, sensors: impl Iterator<Item = (Axis, &'a SensorCalibration)>) {
    let mut table = Table::new(
        "Uncertainty of a measured field (standard uncertainty; worst case: sum of all terms, each doubled)",
        [
            ("sensor", ""),
            ("field along it", "nT"),
            ("warmer than the reference", "K"),
            ("standard", "nT"),
            ("worst case", "nT"),
            ("largest terms", ""),
        ],
    );
    for (axis, sensor) in sensors {
        for one in &sensor.budget {
            let largest = one.terms.iter().take(3);
            let terms: Vec<String> = largest
                .map(|term| format!("{} {} nT", term.term, crate::number::significant(term.std_nt, 2)))
                .collect();
            table.row([
                format!("sensor {axis}").into(),
                one.field_nt.into(),
                one.warmer_k.into(),
                Cell::Figures(one.standard_nt, 2),
                Cell::Figures(one.worst_case_nt, 2),
                terms.join("; ").into(),
            ]);
        }
    }
    section.table(table);
}
