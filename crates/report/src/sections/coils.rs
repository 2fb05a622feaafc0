//! The coils: constants, deviations from the line.

use common::Document;
use page::words::counted;

use super::departures;
use super::effects::{self, findings};
use crate::plot::{Dimension, Mark, Plot, Series};
use crate::{Cell, Section, Table};

/// The section; None where the document has nothing of it.
pub fn section(document: &Document) -> Option<Section> {
    let coils = document.calibration.as_ref()?.coils.as_ref()?;
    let mut section = Section::new("coils", "Coils");
    section.words.push("B = k I + B₀ along each coil's own axis.".into());
    let mut constants = Table::new(
        "Constants",
        [
            ("coil", ""),
            ("k", "nT/A"),
            ("B₀", "nT"),
            ("model", ""),
            ("rms of residuals", "nT"),
            ("lack of fit, p", ""),
        ],
    );
    let mut budget = Table::new(
        "Standard uncertainties from scatter (type A) and from resistor and voltmeter (type B)",
        [
            ("coil", ""),
            ("k, type A", "nT/A"),
            ("k, type B", "nT/A"),
            ("B₀, type A", "nT"),
            ("B₀, type B", "nT"),
            ("readings", ""),
            ("95 % factor", ""),
        ],
    );
    let mut looked_for = departures::table("coil");
    let mut plots = Vec::new();
    for (axis, coil) in coils.iter() {
        let name = format!("coil {axis}");
        let fit = coil.constant.as_deref();
        constants.row([
            name.as_str().into(),
            coil.constant_nt_per_a.as_ref().into(),
            coil.offset_nt.as_ref().into(),
            fit.map(|fit| fit.model.clone()).into(),
            fit.map(|fit| Cell::Figures(fit.rms_nt, 3)).into(),
            fit.and_then(|fit| fit.lack_of_fit).map_or(Cell::Empty, |test| Cell::Probability(test.p_value)),
        ]);
        let Some(fit) = fit else { continue };
        section.warnings.extend(findings(&name, &fit.findings, &effects::coils::RULES, coil));
        let part = |key: &str| fit.uncertainty.get(key);
        let [k, b0] = ["constant_nt_per_a", "offset_nt"].map(part);
        budget.row([
            name.as_str().into(),
            k.map(|k| Cell::Figures(k.type_a, 2)).into(),
            k.map(|k| Cell::Figures(k.type_b, 2)).into(),
            b0.map(|b0| Cell::Figures(b0.type_a, 2)).into(),
            b0.map(|b0| Cell::Figures(b0.type_b, 2)).into(),
            fit.readings.into(),
            Cell::Figures(fit.coverage_factor_95, 3),
        ]);
        departures::add(&mut looked_for, &name, &fit.departures);
        let residuals = &fit.residuals;
        let mut plot = Plot::new(
            format!("coil-{axis}-deviations"),
            format!("Coil {axis}: deviation from the {}", fit.model.replace('_', " ")),
            Dimension::linear("field", "nT"),
            Dimension::linear("measured less fitted", "nT"),
        )
        .note(format!(
            "Means of {} at {}.",
            counted(fit.readings, "reading"),
            counted(fit.levels, "level")
        ));
        plot.push(
            Series::new(&name, Mark::Points, axis.index(), &residuals.field_nt, &residuals.residual_nt)
                .with_std(&residuals.std_nt),
        );
        plots.push(plot);
    }
    section.table(constants);
    section.table(budget);
    plots.into_iter().for_each(|plot| section.plot(plot));
    section.table(looked_for);
    (!section.items.is_empty()).then_some(section)
}
