//! Temperatures, voltages, currents and whatever else was recorded beside readings of fields.

use common::{Document, Recording};
use explain::Covariate;

/// What some recordings hold besides times, fields and the outputs of sensors, as far as it changes: by name,
/// with the recording's id where another one has that name at the same time, and by times from the earliest
/// start on.
pub fn beside(document: &Document, recordings: &[String]) -> Vec<Covariate> {
    let recordings: Vec<&Recording> =
        document.recordings.iter().filter(|recording| recordings.contains(&recording.id)).collect();
    let starts = recordings.iter().filter_map(|recording| recording.start()).map(|start| start.unix_s);
    let earliest = starts.fold(f64::INFINITY, f64::min);
    let mut all: Vec<Covariate> = Vec::new();
    for recording in recordings {
        let origin_s = recording.start().map_or(0.0, |start| start.unix_s - earliest);
        let Some(own) = recording.column("time_s") else { continue };
        for name in recording.columns.keys().filter(|name| is_beside(name)) {
            let Some(values) = recording.column(name) else { continue };
            let known = own.iter().zip(values).filter(|(t, value)| t.is_finite() && value.is_finite());
            let (time_s, values): (Vec<f64>, Vec<f64>) =
                known.map(|(t, value)| (t + origin_s, *value)).unzip();
            let Some(first) = time_s.first() else { continue };
            let before = |have: &&mut Covariate| have.name == *name && have.time_s.last() < Some(first);
            match all.iter_mut().find(before) {
                // Another piece of the same.
                Some(have) => {
                    have.time_s.extend(time_s);
                    have.values.extend(values);
                }
                None => {
                    let taken = all.iter().any(|have| have.name == *name);
                    let name = if taken { format!("{name} of \"{}\"", recording.id) } else { name.clone() };
                    all.push(Covariate { name, time_s, values });
                }
            }
        }
    }
    all.retain(|one| one.values.iter().any(|value| *value != one.values[0]));
    all
}

fn is_beside(name: &str) -> bool {
    let output = name.starts_with("sensor_") && name.ends_with("_v");
    !name.starts_with("time_") && !name.ends_with("_nt") && !output
}
