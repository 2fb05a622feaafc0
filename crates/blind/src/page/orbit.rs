//! What diagnose made of the orbit, in words and figures.

use concealed::swarm::{Flight, rms};
use serde_json::Value;

/// The section of the page: figures of the recording itself, then the answer's.
pub fn section(flight: &Flight, answer: Option<&Value>) -> String {
    let of = |eclipse: bool| {
        let rows = flight.moments.iter().zip(&flight.residual).filter(|(m, _)| m.eclipse == eclipse);
        rms(rows.map(|(_, residual)| *residual))
    };
    let along = |row: usize| flight.disturbance[row].dot(&flight.moments[row].field.normalize());
    let count = flight.disturbance.len();
    let seen = rms((0..count).map(along));
    let whole = rms(flight.disturbance.iter().map(|d| d.norm()));
    let mut text = format!(
        "## An orbit\n\n\
        A vector magnetometer beside a scalar one, {count} rows in thirty days, near-polar, the body looking down. Concealed: a vector fixed in the body, \
        spherical harmonics to degree 3 of the Sun's direction in the body, zero in the Earth's shadow. The document has the calibration before flight, the scalar \
        readings, the Sun's two angles and the eclipse.\n\n\
        Of the recording itself: scalar residual {:.3} nT rms in the Sun, {:.3} nT in eclipse, noise {:.3} nT. Of the disturbance of {whole:.2} nT rms the scalar \
        residual sees the part along the field, {seen:.2} nT.\n\n",
        of(false),
        of(true),
        flight.case.truth.noise_nt
    );
    match answer.filter(|answer| taken(flight, answer)) {
        Some(answer) => text += &found(flight, answer),
        None => text += "`diagnose` as it is does not take a scalar magnetometer without coils: not run.\n",
    }
    text + "\n**What is not observable from the scalar residual.** |B + d| − |B| is d · B/|B|: the two components across the field are not \
    observable directly. They are determined only where the same direction of the Sun occurs with different directions of the field. A \
    near-polar orbit of a body that looks down offers little of that, because the field is nearly always in the plane of the orbit. Single \
    coefficients are therefore poorly determined, however well their sum along the field is. Nor can a constant part in sunlight be \
    separated from an offset except by eclipses, or the metal be identified.\n"
}

/// Whether the answer is about the scalar residual: a program that does not know it predicts no field at all.
fn taken(flight: &Flight, answer: &Value) -> bool {
    let before = answer["diagnosis"][0]["fit"]["rms_before_nt"].as_f64();
    before.is_some_and(|before| before < 10.0 * rms(flight.residual.iter().copied()))
}

fn found(flight: &Flight, answer: &Value) -> String {
    let entry = &answer["diagnosis"][0];
    let fit = |key: &str| entry["fit"][key].as_f64().unwrap_or(f64::NAN);
    let names: Vec<&str> = entry["effects"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|effect| effect["effect"].as_str())
        .collect();
    let places: Vec<&str> = entry["where"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|place| place["description"].as_str())
        .take(6)
        .collect();
    let none = |list: Vec<&str>| if list.is_empty() { "nothing".to_string() } else { list.join("; ") };
    let mut text = format!(
        "| | |\n| --- | --- |\n| verdict | {} |\n| named | {} |\n| where | {} |\n| scalar residual as it came | {:.3} nT |\n| with the calibration fitted again | {:.3} nT |\n\
         | with what was found | {:.3} nT |\n| readings left out | {:.3} nT |\n| noise drawn | {:.3} nT |\n",
        entry["verdict"].as_str().unwrap_or("none").replace('_', " "),
        none(names),
        none(places),
        fit("rms_before_nt"),
        fit("rms_refitted_nt"),
        fit("rms_after_nt"),
        fit("held_out_after_nt"),
        flight.case.truth.noise_nt
    );
    let mut shares = entry["energy"].as_array().into_iter().flatten();
    let in_eclipse = shares.find(|part| part["by"] == "eclipse" && part["range"][0] == 1.0);
    if let Some(share) = in_eclipse.and_then(|part| part["share"].as_f64()) {
        text += &format!("| share of the difference that lies in eclipse | {:.0} % |\n", 100.0 * share.abs());
    }
    let effects = entry["effects"].as_array().into_iter().flatten();
    let mut stds: Vec<f64> = effects
        .filter_map(|effect| effect["parameters"].as_object())
        .flat_map(|parameters| parameters.values().filter_map(|found| found["std"].as_f64()))
        .collect();
    stds.sort_by(f64::total_cmp);
    if let (Some(least), Some(most)) = (stds.first(), stds.last()) {
        text += &format!(
            "| standard uncertainties of its {} coefficients | {least:.2} to {most:.1} nT |\n",
            stds.len()
        );
    }
    text
}
