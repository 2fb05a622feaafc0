//! The field of each coil along its axis.

use crate::page::words::slug;
use common::{Axis, Calibration, CoilSurvey, PerAxis, Quantity};

use super::Plots;
use crate::number;
use crate::plot::{Mark, Plot, Series};

pub fn plots(plots: &mut Plots, calibration: &Calibration) {
    let coils = calibration.coils.iter().flat_map(PerAxis::iter);
    let surveys = coils.flat_map(|(axis, coil)| coil.surveys.iter().map(move |survey| along(axis, survey)));
    plots.insert("gradients".into(), surveys.collect());
}

/// The measured departures, and the fitted curve between the outermost places on their level.
fn along(axis: Axis, survey: &CoilSurvey) -> Plot {
    const STEPS: usize = 60;
    let places = &survey.places;
    let value = |coefficient: &Option<Quantity>| coefficient.as_ref().map_or(0.0, Quantity::value);
    let [a, b, c] = [&survey.first_nt_per_m, &survey.second_nt_per_m2, &survey.fourth_nt_per_m4].map(value);
    let curve = |x: f64| a * x + b * x.powi(2) + c * x.powi(4);
    let mut rows = places.position_m.iter().zip(&places.departure_nt).zip(&places.residual_nt);
    let level = rows.next().map_or(0.0, |((x, departure), residual)| departure - residual - curve(*x));
    let ends = number::ends(places.position_m.iter().copied()).filter(|[low, high]| low < high);
    let x: Vec<f64> = ends.map_or(Vec::new(), |[low, high]| {
        (0..=STEPS).map(|n| low + (high - low) * n as f64 / STEPS as f64).collect()
    });
    let y: Vec<f64> = x.iter().map(|x| level + curve(*x)).collect();
    let measured = Series::points("measured", axis.index(), &places.position_m, &places.departure_nt);
    let title = format!("Coil {axis}: field along its axis, {}", survey.recording);
    Plot::new(format!("gradient-{axis}-{}", slug(&survey.recording)), title)
        .axes("place along the axis [m]", "field less the centre's [nT]")
        .with(measured.with_std(&places.std_nt))
        .with(Series::new("fitted", Mark::Dashes, 5, &x, &y))
}
