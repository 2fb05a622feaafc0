//! Offsets from date to date.

use common::{Axis, Document, OffsetDrift};

use super::effects::{self, findings};
use crate::plot::{Dimension, Mark, Plot, Series};
use crate::{Cell, Section, Table};

/// The section; None where the document has nothing of it.
pub fn section(document: &Document) -> Option<Section> {
    let sensors = document.calibration.as_ref()?.sensors.as_ref()?;
    let mut section = Section::new("drift", "Drift of the offsets");
    let mut table = Table::new(
        "Offsets over the dates",
        [
            ("sensor", ""),
            ("dates", ""),
            ("mean", "nT"),
            ("rms about it", "nT"),
            ("less the dates' own uncertainty", "nT"),
            ("trend", "nT/year"),
            ("trend, p", ""),
            ("yearly amplitude", "nT"),
            ("yearly, p", ""),
            ("with temperature", "nT/K"),
        ],
    );
    let mut trends = Table::new(
        "The trend under each noise alone, with the weight that the readings give to it",
        [("sensor", ""), ("noise", ""), ("trend", "nT/year"), ("weight", "")],
    );
    let mut plots = Vec::new();
    for (axis, sensor) in sensors.iter() {
        let Some(drift) = &sensor.drift else { continue };
        let name = format!("sensor {axis}");
        section.warnings.extend(findings(&name, &drift.findings, &effects::sensors::DRIFT, drift));
        let annual = drift.annual.as_ref();
        table.row([
            name.as_str().into(),
            drift.dates.time_d.len().into(),
            (&drift.mean_nt).into(),
            Cell::Figures(drift.rms_nt, 3),
            Cell::Figures(drift.own_rms_nt, 3),
            drift.trend_nt_per_year.as_ref().into(),
            drift.trend_p.map_or(Cell::Empty, Cell::Probability),
            annual.map(|annual| Cell::Figures(annual.amplitude_nt, 3)).into(),
            annual.map_or(Cell::Empty, |annual| Cell::Probability(annual.p_value)),
            drift.temperature_nt_per_k.as_ref().into(),
        ]);
        for (noise, trend) in &drift.trend_by_noise_nt_per_year {
            let weight = drift.noise.get(noise).map_or(Cell::Empty, |weight| Cell::Figures(*weight, 2));
            trends.row([name.as_str().into(), noise.replace('_', " ").into(), trend.into(), weight]);
        }
        plots.push(vec![plot(axis, drift), left(axis, drift)]);
    }
    section.table(table);
    section.plots_side_by_side(plots);
    section.table(trends);
    (!section.items.is_empty()).then_some(section)
}

/// What trend, yearly term and temperature leave, on a scale of its own.
fn left(axis: Axis, drift: &OffsetDrift) -> Plot {
    let dates = &drift.dates;
    let mut plot = Plot::new(
        format!("drift-{axis}-left"),
        format!("Residuals of the trend, sensor {axis}"),
        Dimension::linear("since the first date", "days"),
        Dimension::linear("offset less fitted", "nT"),
    );
    plot.push(
        Series::new("left", Mark::Points, axis.index(), &dates.time_d, &dates.residual_nt)
            .with_std(&dates.std_nt),
    );
    plot
}

fn plot(axis: Axis, drift: &OffsetDrift) -> Plot {
    let dates = &drift.dates;
    let mut plot = Plot::new(
        format!("drift-{axis}"),
        format!("Offset from date to date, sensor {axis}"),
        Dimension::linear("since the first date", "days"),
        Dimension::linear("offset", "nT"),
    );
    plot.push(
        Series::new("measured", Mark::Points, axis.index(), &dates.time_d, &dates.offset_nt)
            .with_std(&dates.std_nt),
    );
    let fitted: Vec<f64> =
        dates.offset_nt.iter().zip(&dates.residual_nt).map(|(offset, left)| offset - left).collect();
    plot.push(Series::new("trend, yearly term and temperature", Mark::Dashes, 5, &dates.time_d, &fitted));
    plot
}
