//! The conditions under which the calibration was made.

use common::{Certificate, Document, Recording};
use page::number::{self, bare};

use crate::sheet::Sheet;

/// Temperatures and fields of the document, and what the laboratory states besides.
pub fn part(sheet: &mut Sheet, document: &Document, data: &Certificate) {
    sheet.begin("Conditions", "7.8.4.1 b");
    let found = found(document);
    if !found.is_empty() {
        sheet.listed("In the document", "7.8.4.1 b", Some(&found));
    }
    sheet.listed("Environment", "7.8.4.1 b", data.conditions.as_deref());
}

fn found(document: &Document) -> Vec<String> {
    let mut found = Vec::new();
    let calibration = document.calibration.as_ref();
    let reference = calibration.and_then(|calibration| calibration.reference_conditions.as_ref());
    for (of, key, holds) in [
        ("sensors", "sensor_temperature_c", reference.and_then(|one| one.sensor_temperature_c)),
        ("electronics", "electronics_temperature_c", reference.and_then(|one| one.electronics_temperature_c)),
        ("coils", "coil_temperature_c", reference.and_then(|one| one.coil_temperature_c)),
    ] {
        let mut words = Vec::new();
        words.extend(holds.map(|at| format!("results hold at {}\u{a0}°C", bare(at))));
        let recorded = document.recordings.iter().flat_map(|recording| temperatures(recording, key));
        let part = |which: &str| {
            let sensors = calibration.and_then(|calibration| calibration.sensors.as_ref());
            let fits = sensors.into_iter().flat_map(|sensors| sensors.iter());
            let fits = fits.filter_map(|(_, sensor)| sensor.temperature.as_ref());
            let parts = fits.filter_map(|fit| match which {
                "sensors" => fit.sensor.as_ref(),
                "electronics" => fit.electronics.as_ref(),
                _ => None,
            });
            parts.flat_map(|part| part.range_c).collect::<Vec<f64>>()
        };
        let all = recorded.chain(part(of));
        if let Some([low, high]) = number::ends(all) {
            let [low, high] = [low, high].map(|end| number::significant(end, 4));
            words.push(if low == high {
                format!("recorded at {low}\u{a0}°C")
            } else {
                format!("recorded from {low} to {high}\u{a0}°C")
            });
        }
        if !words.is_empty() {
            found.push(format!("Temperature of the {of}: {}", words.join("; ")));
        }
    }
    let facility = document.facility.as_ref();
    if let Some(std) = facility.and_then(|facility| facility.residual_field_std_nt) {
        let of = "Field left by the nulling: standard uncertainty of a component";
        found.push(format!("{of} {} nT", bare(std)));
    }
    found
}

/// The temperatures of a recording, as a column or as a condition.
fn temperatures(recording: &Recording, key: &str) -> Vec<f64> {
    let column = recording.column(key).unwrap_or_default();
    let condition = recording.conditions.extra.get(key).and_then(serde_json::Value::as_f64);
    column.iter().copied().chain(condition).collect()
}
