//! The coils: constants, deviations from the line, and the field of each along its axis.

use common::{Axis, CoilSurvey, Document, Quantity};
use page::words::{counted, slug};

use super::effects::{self, findings};
use super::shared::{add_departures, departures};
use crate::plot::{Mark, Plot, Series};
use crate::{Cell, Section, Table, number};

pub fn section(document: &Document) -> Option<Section> {
    let coils = document.calibration.as_ref()?.coils.as_ref()?;
    let mut section = Section::new("coils", "Coils");
    section.words.push("B = k I + B₀ along each coil's own axis.".into());
    let mut constants =
        Table::new("Constants", "coil | k [nT/A] | B₀ [nT] | model | rms of residuals [nT] | lack of fit, p");
    let mut budget = Table::new(
        "Standard uncertainties from scatter (type A) and from resistor and voltmeter (type B)",
        "coil | k, type A [nT/A] | k, type B [nT/A] | B₀, type A [nT] | B₀, type B [nT] | readings | 95 % factor",
    );
    let mut looked_for = departures("coil");
    let mut plots = Vec::new();
    for (axis, coil) in coils.iter() {
        let name = format!("coil {axis}");
        let fit = coil.constant.as_deref();
        constants.row((
            &name,
            &coil.constant_nt_per_a,
            &coil.offset_nt,
            fit.map(|fit| &fit.model),
            Cell::figures(fit.map(|fit| fit.rms_nt), 3),
            Cell::probability(fit.and_then(|fit| fit.lack_of_fit).map(|test| test.p_value)),
        ));
        let Some(fit) = fit else { continue };
        section.warnings.extend(findings(&name, &fit.findings, &effects::sensors::COIL, coil));
        let [k, b0] = ["constant_nt_per_a", "offset_nt"].map(|key| fit.uncertainty.get(key));
        budget.row((
            &name,
            Cell::figures(k.map(|k| k.type_a), 2),
            Cell::figures(k.map(|k| k.type_b), 2),
            Cell::figures(b0.map(|b0| b0.type_a), 2),
            Cell::figures(b0.map(|b0| b0.type_b), 2),
            fit.readings,
            Cell::Figures(fit.coverage_factor_95, 3),
        ));
        add_departures(&mut looked_for, &name, &fit.departures);
        let residuals = &fit.residuals;
        let title = format!("Coil {axis}: deviation from the {}", fit.model.replace('_', " "));
        let (readings, levels) = (counted(fit.readings, "reading"), counted(fit.levels, "level"));
        let points = Series::points(&name, axis.index(), &residuals.field_nt, &residuals.residual_nt);
        plots.push(
            Plot::new(format!("coil-{axis}-deviations"), title)
                .axes("field [nT]", "measured less fitted [nT]")
                .note(format!("Means of {readings} at {levels}."))
                .with(points.with_std(&residuals.std_nt)),
        );
    }
    section.table(constants);
    section.table(budget);
    plots.into_iter().for_each(|plot| section.plot(plot));
    section.table(looked_for);
    (!section.items.is_empty()).then_some(section)
}

/// The field of each coil along its axis.
pub fn gradients(document: &Document) -> Option<Section> {
    let coils = document.calibration.as_ref()?.coils.as_ref()?;
    let mut section = Section::new("gradients", "Gradients of the coils");
    section.words.push("B(x) = B₀ + a x + b x² + c x⁴ along the coil's axis, x from its centre.".into());
    let mut table = Table::new(
        "Surveys",
        "coil, recording | current [A] | B₀ [nT] | a [nT/m] | b [nT/m²] | c [nT/m⁴] | largest departure [nT] | at [m] | \
         error off the centre [nT] | within [m]",
    );
    let mut plots = Vec::new();
    for (axis, coil) in coils.iter() {
        for survey in &coil.surveys {
            let off_centre = survey.off_centre.as_ref();
            table.row((
                format!("{axis}, {}", survey.recording),
                survey.current_a,
                &survey.centre_nt,
                &survey.first_nt_per_m,
                &survey.second_nt_per_m2,
                &survey.fourth_nt_per_m4,
                &survey.worst_departure_nt,
                survey.worst_position_m,
                off_centre.map(|off| &off.error_nt),
                off_centre.map(|off| off.distance_m),
            ));
            plots.push(survey_plot(axis, survey));
        }
        if let Some(gradient_coil) = &coil.gradient_coil {
            section.words.push(format!(
                "Gradient coil of {axis}: {} A nulls the departure at {} m.",
                Cell::from(&gradient_coil.current_a),
                number::bare(gradient_coil.position_m)
            ));
        }
    }
    section.table(table);
    plots.into_iter().for_each(|plot| section.plot(plot));
    (!section.items.is_empty()).then_some(section)
}

fn survey_plot(axis: Axis, survey: &CoilSurvey) -> Plot {
    let places = &survey.places;
    let measured = Series::points("measured", axis.index(), &places.position_m, &places.departure_nt);
    let [x, y] = fitted(survey);
    let title = format!("Coil {axis}: field along its axis, {}", survey.recording);
    Plot::new(format!("gradient-{axis}-{}", slug(&survey.recording)), title)
        .axes("place along the axis [m]", "field less the centre's [nT]")
        .with(measured.with_std(&places.std_nt))
        .with(Series::new("fitted", Mark::Dashes, 5, &x, &y))
}

/// The fitted curve between the outermost places, on the level of the measured departures.
fn fitted(survey: &CoilSurvey) -> [Vec<f64>; 2] {
    const STEPS: usize = 60;
    let value = |coefficient: &Option<Quantity>| coefficient.as_ref().map_or(0.0, Quantity::value);
    let [a, b, c] = [&survey.first_nt_per_m, &survey.second_nt_per_m2, &survey.fourth_nt_per_m4].map(value);
    let curve = |x: f64| a * x + b * x.powi(2) + c * x.powi(4);
    let places = &survey.places;
    let mut rows = places.position_m.iter().zip(&places.departure_nt).zip(&places.residual_nt);
    let level = rows.next().map_or(0.0, |((x, departure), residual)| departure - residual - curve(*x));
    let x: Vec<f64> = match number::ends(places.position_m.iter().copied()) {
        Some([low, high]) if low < high => {
            (0..=STEPS).map(|n| low + (high - low) * n as f64 / STEPS as f64).collect()
        }
        _ => Vec::new(),
    };
    let y = x.iter().map(|x| level + curve(*x)).collect();
    [x, y]
}
