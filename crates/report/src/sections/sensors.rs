//! Each sensor: sensitivity, offset, deviation from the line, reversals, error budget; its drift.

use common::{Document, PerAxis, SensorCalibration};
use page::words::{counted, key};

use super::effects::{self, findings};
use super::shared::{add_departures, departures};
use crate::plot::{Mark, Plot, Series};
use crate::{Cell, Section, Table, number};

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
        "sensor | k [nT/V] | k [nT/nT] | O [nT] | model | readings | rms of residuals [nT] | normal, p | runs, p",
    );
    let mut budgets = Table::new(
        "Standard uncertainties of the fit in the coils, from scatter (type A) and from coil and temperatures (type B)",
        "sensor | parameter | type A | type B | unit",
    );
    let mut looked_for = departures("sensor");
    let mut plots = Vec::new();
    for (axis, sensor) in sensors.iter() {
        let name = format!("sensor {axis}");
        let fit = sensor.sensitivity.as_deref();
        constants.row((
            &name,
            &sensor.sensitivity_nt_per_v,
            &sensor.sensitivity_nt_per_nt,
            &sensor.offset_nt,
            fit.map(|fit| &fit.model),
            fit.map(|fit| fit.readings),
            Cell::figures(fit.map(|fit| fit.noise.rms_nt), 3),
            Cell::probability(fit.and_then(|fit| fit.normality).map(|test| test.p_value)),
            Cell::probability(fit.and_then(|fit| fit.runs).map(|test| test.p_value)),
        ));
        let Some(fit) = fit else { continue };
        section.warnings.extend(findings(&name, &fit.findings, &effects::sensors::SENSITIVITY, sensor));
        for (parameter, budget) in &fit.uncertainty {
            let (words, unit) = key(parameter);
            let [a, b] = [budget.type_a, budget.type_b].map(|std| Cell::Figures(std, 2));
            budgets.row((&name, words, a, b, unit));
        }
        add_departures(&mut looked_for, &name, &fit.departures);
        let residuals = &fit.residuals;
        let plot = |id: &str, title: &str, label: &str| {
            Plot::new(format!("sensor-{axis}-{id}"), format!("Sensor {axis}: {title}"))
                .axes("field along the sensor [nT]", label)
        };
        let points = |name: &str, y: &[f64]| Series::points(name, axis.index(), &residuals.field_nt, y);
        plots.push(
            plot("deviations", "deviation from the line", "read less applied [nT]")
                .note(format!("{}; {}.", counted(fit.readings, "reading"), fit.order))
                .with(points("by the line", &residuals.deviation_nt)),
        );
        // The residuals of what is fitted beside the line have a scale of their own.
        if fit.model != "line" {
            let model = fit.model.replace('_', " ");
            plots.push(
                plot("residuals", "residuals of the fit", "read less fitted [nT]")
                    .note(format!("With {model} beside the line."))
                    .with(points(&format!("by {model}"), &residuals.residual_nt)),
            );
        }
    }
    section.table(constants);
    plots.into_iter().for_each(|plot| section.plot(plot));
    section.table(budgets);
    section.table(looked_for);
    reversals(&mut section, sensors);
    error_budget(&mut section, sensors);
    (!section.items.is_empty()).then_some(section)
}

fn reversals(section: &mut Section, sensors: &PerAxis<SensorCalibration>) {
    let mut table = Table::new(
        "Offsets by turning the sensor through 180° in a shield: O = −k (V₁ + V₂)/2",
        "sensor | recording | O [nT] | field of the shield [nT] | its drift [nT/s] | pairs used | pairs | \
         bound for a turn not quite 180° [nT]",
    );
    let mut plot = Plot::new("reversals", "Offset from each pair of a reversal").axes("pair", "offset [nT]");
    for (axis, sensor) in sensors.iter() {
        let Some(reversal) = &sensor.reversal else { continue };
        let name = format!("sensor {axis}");
        let whose = format!("{name}, reversals");
        section.warnings.extend(findings(&whose, &reversal.findings, &effects::sensors::REVERSAL, reversal));
        let mut offsets = Vec::new();
        for one in &reversal.recordings {
            table.row((
                &name,
                &one.recording,
                &one.offset_nt,
                &one.shield_field_nt,
                &one.shield_drift_nt_per_s,
                one.pairs.used.iter().filter(|used| **used).count(),
                one.pairs.used.len(),
                Cell::Figures(reversal.imperfect_turn.bound_nt, 2),
            ));
            offsets.extend(&one.pairs.offset_nt);
        }
        let numbers: Vec<f64> = (1..=offsets.len()).map(|number| number as f64).collect();
        plot.push(Series::points(name, axis.index(), &numbers, &offsets));
    }
    section.table(table);
    section.plot(plot);
}

fn error_budget(section: &mut Section, sensors: &PerAxis<SensorCalibration>) {
    let mut table = Table::new(
        "Uncertainty of a measured field (standard uncertainty; worst case: sum of all terms, each doubled)",
        "sensor | field along it [nT] | warmer than the reference [K] | standard [nT] | worst case [nT] | largest terms",
    );
    for (axis, sensor) in sensors.iter() {
        for one in &sensor.budget {
            let largest = one.terms.iter().take(3);
            let terms =
                largest.map(|term| format!("{} {} nT", term.term, number::significant(term.std_nt, 2)));
            let terms = terms.collect::<Vec<_>>().join("; ");
            let [standard, worst] = [one.standard_nt, one.worst_case_nt].map(|nt| Cell::Figures(nt, 2));
            table.row((format!("sensor {axis}"), one.field_nt, one.warmer_k, standard, worst, terms));
        }
    }
    section.table(table);
}

/// Offsets from date to date.
pub fn drift(document: &Document) -> Option<Section> {
    let sensors = document.calibration.as_ref()?.sensors.as_ref()?;
    let mut section = Section::new("drift", "Drift of the offsets");
    let mut table = Table::new(
        "Offsets over the dates",
        "sensor | dates | mean [nT] | rms about it [nT] | less the dates' own uncertainty [nT] | trend [nT/year] | \
         trend, p | yearly amplitude [nT] | yearly, p | with temperature [nT/K]",
    );
    let mut trends = Table::new(
        "The trend under each noise alone, with the weight that the readings give to it",
        "sensor | noise | trend [nT/year] | weight",
    );
    let mut plots = Vec::new();
    for (axis, sensor) in sensors.iter() {
        let Some(drift) = &sensor.drift else { continue };
        let name = format!("sensor {axis}");
        section.warnings.extend(findings(&name, &drift.findings, &effects::sensors::DRIFT, drift));
        let (dates, annual) = (&drift.dates, drift.annual.as_ref());
        table.row((
            &name,
            dates.time_d.len(),
            &drift.mean_nt,
            Cell::Figures(drift.rms_nt, 3),
            Cell::Figures(drift.own_rms_nt, 3),
            &drift.trend_nt_per_year,
            Cell::probability(drift.trend_p),
            Cell::figures(annual.map(|annual| annual.amplitude_nt), 3),
            Cell::probability(annual.map(|annual| annual.p_value)),
            &drift.temperature_nt_per_k,
        ));
        for (noise, trend) in &drift.trend_by_noise_nt_per_year {
            let weight = Cell::figures(drift.noise.get(noise).copied(), 2);
            trends.row((&name, noise.replace('_', " "), trend, weight));
        }
        let plot = |end: &str, title: &str, y: &str| {
            Plot::new(format!("drift-{axis}{end}"), format!("{title}, sensor {axis}"))
                .axes("since the first date [days]", y)
        };
        let points = |name: &str, y: &[f64]| {
            Series::points(name, axis.index(), &dates.time_d, y).with_std(&dates.std_nt)
        };
        let each = dates.offset_nt.iter().zip(&dates.residual_nt);
        let fitted: Vec<f64> = each.map(|(offset, left)| offset - left).collect();
        let fitted =
            Series::new("trend, yearly term and temperature", Mark::Dashes, 5, &dates.time_d, &fitted);
        // What trend, yearly term and temperature leave has a scale of its own.
        plots.push(vec![
            plot("", "Offset from date to date", "offset [nT]")
                .with(points("measured", &dates.offset_nt))
                .with(fitted),
            plot("-left", "Residuals of the trend", "offset less fitted [nT]")
                .with(points("left", &dates.residual_nt)),
        ]);
    }
    section.table(table);
    section.plots_side_by_side(plots);
    section.table(trends);
    (!section.items.is_empty()).then_some(section)
}
