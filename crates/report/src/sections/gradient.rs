//! The field of each coil along its axis.

use common::{CoilSurvey, Document, Quantity};
use page::words::slug;

use crate::number;
use crate::plot::{Dimension, Mark, Plot, Series};
use crate::{Section, Table};

/// The section; None where the document has nothing of it.
pub fn section(document: &Document) -> Option<Section> {
    let coils = document.calibration.as_ref()?.coils.as_ref()?;
    let mut section = Section::new("gradients", "Gradients of the coils");
    section.words.push("B(x) = B₀ + a x + b x² + c x⁴ along the coil's axis, x from its centre.".into());
    let mut table = Table::new(
        "Surveys",
        [
            ("coil, recording", ""),
            ("current", "A"),
            ("B₀", "nT"),
            ("a", "nT/m"),
            ("b", "nT/m²"),
            ("c", "nT/m⁴"),
            ("largest departure", "nT"),
            ("at", "m"),
            ("error off the centre", "nT"),
            ("within", "m"),
        ],
    );
    let mut plots = Vec::new();
    for (axis, coil) in coils.iter() {
        for survey in &coil.surveys {
            let off_centre = survey.off_centre.as_ref();
            table.row([
                format!("{axis}, {}", survey.recording).into(),
                survey.current_a.into(),
                survey.centre_nt.as_ref().into(),
                survey.first_nt_per_m.as_ref().into(),
                survey.second_nt_per_m2.as_ref().into(),
                survey.fourth_nt_per_m4.as_ref().into(),
                (&survey.worst_departure_nt).into(),
                survey.worst_position_m.into(),
                off_centre.map(|off| &off.error_nt).into(),
                off_centre.map(|off| off.distance_m).into(),
            ]);
            plots.push(plot(axis, survey));
        }
        if let Some(gradient_coil) = &coil.gradient_coil {
            section.words.push(format!(
                "Gradient coil of {axis}: {} A nulls the departure at {} m.",
                number::cell(&(&gradient_coil.current_a).into()),
                number::bare(gradient_coil.position_m)
            ));
        }
    }
    section.table(table);
    plots.into_iter().for_each(|plot| section.plot(plot));
    (!section.items.is_empty()).then_some(section)
}

fn plot(axis: common::Axis, survey: &CoilSurvey) -> Plot {
    let places = &survey.places;
    let mut plot = Plot::new(
        format!("gradient-{axis}-{}", slug(&survey.recording)),
        format!("Coil {axis}: field along its axis, {}", survey.recording),
        Dimension::linear("place along the axis", "m"),
        Dimension::linear("field less the centre's", "nT"),
    );
    plot.push(
        Series::new("measured", Mark::Points, axis.index(), &places.position_m, &places.departure_nt)
            .with_std(&places.std_nt),
    );
    let [x, y] = fitted(survey);
    plot.push(Series::new("fitted", Mark::Dashes, 5, &x, &y));
    plot
}

/// The fitted curve between the outermost places, on the level of the measured departures.
fn fitted(survey: &CoilSurvey) -> [Vec<f64>; 2] {
    const STEPS: usize = 60;
    let value = |coefficient: &Option<Quantity>| coefficient.as_ref().map_or(0.0, Quantity::value);
    let [a, b, c] = [&survey.first_nt_per_m, &survey.second_nt_per_m2, &survey.fourth_nt_per_m4].map(value);
    let curve = |x: f64| a * x + b * x.powi(2) + c * x.powi(4);
    let places = &survey.places;
    let rows = places.position_m.iter().zip(&places.departure_nt).zip(&places.residual_nt);
    let level =
        rows.clone().map(|((x, departure), residual)| departure - residual - curve(*x)).next().unwrap_or(0.0);
    let low = places.position_m.iter().copied().fold(f64::INFINITY, f64::min);
    let high = places.position_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let x: Vec<f64> = if low < high {
        (0..=STEPS).map(|n| low + (high - low) * n as f64 / STEPS as f64).collect()
    } else {
        Vec::new()
    };
    let y = x.iter().map(|x| level + curve(*x)).collect();
    [x, y]
}
