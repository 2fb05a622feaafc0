//! The field of a coil along its axis (NASA, "Minimize Calibration Coil Gradients").

use common::number::counted;
use common::{
    Axis, CoilSurvey, Document, GradientCoil, OffCentre, Quantity, Recording, SurveyPlaces, procedure,
};
use estimate::linear::{self, LinearFit};
use faer::Mat;

use crate::readings::{check, drive};
use crate::{Error, Result};

/// Places closer than this are one, m.
const SAME_PLACE_M: f64 = 1e-6;
/// Powers of the position beside the constant.
const POWERS: [i32; 3] = [1, 2, 4];

pub fn surveys(document: &Document, coil: Axis, off_centre_m: f64) -> Result<Vec<CoilSurvey>> {
    let mut found = Vec::new();
    for (index, recording) in document.recordings.iter().enumerate() {
        if recording.procedure == procedure::COIL_GRADIENT && recording.conditions.coil == Some(coil) {
            found.push(survey(document, recording, coil, off_centre_m, &format!("recordings[{index}]"))?);
        }
    }
    Ok(found)
}

fn survey(
    document: &Document,
    recording: &Recording,
    coil: Axis,
    off_centre_m: f64,
    path: &str,
) -> Result<CoilSurvey> {
    let need = |name: &str, what: &str| {
        recording.column(name).ok_or_else(|| {
            Error::document(format!("{path}.columns"), format!("no `{name}`"), what.to_string())
        })
    };
    let position = need("position_m", "`position_m`, the position along the coil's axis from its centre")?;
    let reference = need("reference_nt", "`reference_nt`, the readings of the scalar magnetometer")?;
    check(document, reference, path)?;
    let (current, _) = drive(document, recording, coil, path)?;
    let rows: Vec<usize> = (0..position.len())
        .filter(|row| [position[*row], reference[*row], current[*row]].iter().all(|value| value.is_finite()))
        .filter(|row| current[*row] != 0.0)
        .collect();
    if rows.is_empty() && current.contains(&0.0) {
        return Err(Error::Unanswerable(format!(
            "recording \"{}\": coil {coil} is never driven ({path}.columns: its current is 0 from row 0 on); a gradient can only be measured in the coil's own field: drive the coil, or remove the recording",
            recording.id
        )));
    }
    let current_a = rows.iter().map(|row| current[*row]).sum::<f64>() / rows.len().max(1) as f64;
    // Every field at the mean current: what is left of the drive's steps is no gradient.
    let field: Vec<f64> = rows.iter().map(|row| reference[*row] * current_a / current[*row]).collect();
    let at: Vec<f64> = rows.iter().map(|row| position[*row]).collect();
    let places = places(&at);
    let powers = &POWERS[..POWERS.len().min(places.len().saturating_sub(1))];
    if places.len() < 3 {
        return Err(Error::Unanswerable(format!(
            "recording \"{}\": {} along coil {coil}; a gradient needs at least three, on both sides of the coil's centre",
            recording.id,
            counted(places.len(), "position")
        )));
    }
    let design = Mat::from_fn(at.len(), 1 + powers.len(), |row, column| match column {
        0 => 1.0,
        _ => at[row].powi(powers[column - 1]),
    });
    let fit = linear::fit(design.as_ref(), &field, None)?;
    let noise_nt = (fit.sum_of_squares / fit.freedom.max(1.0)).sqrt();
    let quantity = |i: usize| {
        (i < fit.coefficients.len())
            .then(|| Quantity::new(fit.coefficients[i], fit.covariance[(i, i)].sqrt() * noise_nt))
    };
    let columns = columns(&places, &at, &field, &fit, noise_nt);
    let worst = (0..columns.departure_nt.len())
        .max_by(|a, b| columns.departure_nt[*a].abs().total_cmp(&columns.departure_nt[*b].abs()))
        .unwrap_or(0);
    Ok(CoilSurvey {
        recording: recording.id.clone(),
        current_a,
        gradient_coil_a: recording.conditions.extra.get("gradient_coil_a").and_then(|value| value.as_f64()),
        centre_nt: quantity(0),
        first_nt_per_m: quantity(1),
        second_nt_per_m2: quantity(2),
        fourth_nt_per_m4: quantity(3),
        worst_position_m: columns.position_m[worst],
        worst_departure_nt: Quantity::new(columns.departure_nt[worst], columns.std_nt[worst]),
        off_centre: Some(off_centre(&fit, powers, off_centre_m, noise_nt)),
        places: columns,
        noise_nt,
        ..CoilSurvey::default()
    })
}

/// Rows of each place, by rising position.
fn places(at: &[f64]) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..at.len()).collect();
    order.sort_by(|a, b| at[*a].total_cmp(&at[*b]));
    let mut places: Vec<Vec<usize>> = Vec::new();
    for row in order {
        match places.last_mut() {
            Some(place) if at[row] - at[place[0]] <= SAME_PLACE_M => place.push(row),
            _ => places.push(vec![row]),
        }
    }
    places
}

fn columns(places: &[Vec<usize>], at: &[f64], field: &[f64], fit: &LinearFit, noise_nt: f64) -> SurveyPlaces {
    let mean =
        |place: &[usize], of: &[f64]| place.iter().map(|row| of[*row]).sum::<f64>() / place.len() as f64;
    let centre = places.iter().min_by(|a, b| at[a[0]].abs().total_cmp(&at[b[0]].abs()));
    let (centre_field, centre_count) = centre.map_or((0.0, 1), |place| (mean(place, field), place.len()));
    let mut columns = SurveyPlaces::default();
    for place in places {
        let is_centre = centre.is_some_and(|centre| centre == place);
        let variance = if is_centre { 0.0 } else { 1.0 / place.len() as f64 + 1.0 / centre_count as f64 };
        columns.position_m.push(at[place[0]]);
        columns.departure_nt.push(mean(place, field) - centre_field);
        columns.std_nt.push(noise_nt * variance.sqrt());
        columns.residual_nt.push(mean(place, &fit.residuals));
    }
    columns
}

/// The largest departure of the fitted field within a distance of the centre, at its end or between.
fn off_centre(fit: &LinearFit, powers: &[i32], distance_m: f64, noise_nt: f64) -> OffCentre {
    let departure = |x: f64| -> f64 {
        let terms = powers.iter().zip(&fit.coefficients[1..]);
        terms.map(|(power, coefficient)| coefficient * x.powi(*power)).sum()
    };
    let worst = (-100..=100)
        .map(|step| distance_m * f64::from(step) / 100.0)
        .max_by(|a, b| departure(*a).abs().total_cmp(&departure(*b).abs()))
        .unwrap_or(0.0);
    let column = |i: usize| worst.powi(powers[i]);
    let variance: f64 = (0..powers.len())
        .flat_map(|i| (0..powers.len()).map(move |j| (i, j)))
        .map(|(i, j)| column(i) * column(j) * fit.covariance[(i + 1, j + 1)])
        .sum();
    OffCentre { distance_m, error_nt: Quantity::new(departure(worst).abs(), variance.sqrt() * noise_nt) }
}

/// The gradient coil's current at which the worst place of the first survey departs by nothing, from two
/// surveys with different currents: linear in the current.
pub fn gradient_coil(surveys: &[CoilSurvey]) -> Option<GradientCoil> {
    let [first, rest @ ..] = surveys else { return None };
    let from = first.gradient_coil_a?;
    let second = rest.iter().find(|survey| survey.gradient_coil_a.is_some_and(|current| current != from))?;
    let to = second.gradient_coil_a?;
    let place = |survey: &CoilSurvey| {
        let places = &survey.places;
        let there = |x: &f64| (x - first.worst_position_m).abs() <= SAME_PLACE_M;
        let index = places.position_m.iter().position(there)?;
        Some((places.departure_nt[index], places.std_nt[index]))
    };
    let ((d1, u1), (d2, u2)) = (place(first)?, place(second)?);
    let change = d1 * (to - from) / (d1 - d2);
    // ∂ΔI/∂d₁ = −ΔI d₂/(d₁ (d₁ − d₂)), ∂ΔI/∂d₂ = ΔI/(d₁ − d₂).
    let (by_first, by_second) = (-change * d2 / (d1 * (d1 - d2)), change / (d1 - d2));
    let std = (by_first * u1).hypot(by_second * u2);
    (change.is_finite() && std.is_finite()).then(|| GradientCoil {
        position_m: first.worst_position_m,
        current_a: Quantity::new(from + change, std),
        change_a: change,
    })
}
