//! What the document comes to, in one sentence.

use common::{Axis, Calibration, Document, OneOrEach, Quantity, SensorCalibration};
use page::words::counted;

use crate::number::{figures, significant};

/// Below this probability the residuals do not go with the noise that was declared.
const UNLIKELY: f64 = 0.01;

/// The answer; None where a stage has written its own, or there is nothing.
pub fn answer(document: &Document) -> Option<String> {
    let calibrated = document.calibration.as_ref().and_then(calibrated);
    let corrected = corrected(document);
    if calibrated.is_some() || corrected.is_some() {
        let all: Vec<String> = [calibrated, corrected].into_iter().flatten().collect();
        return Some(all.join(" "));
    }
    let own = document.diagnosis.as_ref().is_some_and(|all| !all.is_empty())
        || document.calibration.as_ref().is_some_and(|calibration| calibration.differential.is_some());
    let recorded = !own && !document.recordings.is_empty();
    recorded.then(|| "Recorded, and not calibrated yet.".into())
}

/// What was calibrated, how well it is known, and whether the readings agree.
fn calibrated(calibration: &Calibration) -> Option<String> {
    let (mut parts, mut left) = (Vec::new(), Vec::new());
    if let Some(coils) = &calibration.coils {
        let found = coils.iter().filter_map(|(_, coil)| Some((coil, coil.constant.as_ref()?)));
        let found: Vec<_> = found.collect();
        if !found.is_empty() {
            let known = ppm(found.iter().filter_map(|(coil, _)| coil.constant_nt_per_a.as_ref()));
            let known = known_to([known.map(|known| format!("constants {known}"))]);
            parts.push(format!("{}{known}", counted(found.len(), "coil")));
            left.extend(found.iter().map(|(_, fit)| fit.rms_nt));
        }
    }
    let scalar = calibration.scalar.as_ref();
    if let Some(sensors) = &calibration.sensors {
        let is_mine = |sensor: &&SensorCalibration| {
            let own = sensor.sensitivity.is_some() || sensor.reversal.is_some();
            scalar.is_some() || own || sensor.temperature.is_some()
        };
        let mine: Vec<_> = sensors.iter().map(|(_, sensor)| sensor).filter(is_mine).collect();
        if !mine.is_empty() {
            let of_each = mine.iter().map(|one| [&one.sensitivity_nt_per_v, &one.sensitivity_nt_per_nt]);
            let k = ppm(of_each.filter_map(|[volt, field]| volt.as_ref().or(field.as_ref())));
            let offset = mine.iter().filter_map(|one| one.offset_nt.as_ref()?.std()).reduce(f64::max);
            let offset = offset.map(|std| format!("offsets to {} nT", significant(std, 2)));
            let known = known_to([k.map(|known| format!("sensitivities {known}")), offset]);
            parts.push(format!("{}{known}", counted(mine.len(), "sensor")));
            left.extend(mine.iter().filter_map(|one| Some(one.sensitivity.as_ref()?.noise.rms_nt)));
        }
    }
    let axes = calibration.axes.as_ref().filter(|axes| axes.fit.is_some() || scalar.is_some());
    if let Some(axes) = axes {
        let stds = axes.sensors.iter().chain(&axes.coils).filter_map(|all| all.std_arcsec.as_ref());
        let each = |std: &OneOrEach| Axis::ALL.map(|axis| std.get(axis));
        let worst = stds.flat_map(each).flatten().reduce(f64::max);
        parts.extend(worst.map(|std| format!("directions to {} arcsec", significant(std, 2))));
        left.extend(axes.fit.as_ref().map(|fit| fit.rms_nt));
    }
    left.extend(scalar.map(|scalar| scalar.rms_nt));
    if parts.is_empty() {
        return None;
    }
    let ends = crate::number::ends(left.into_iter()).map(|[low, high]| {
        let [low, high] = [low, high].map(|rms| figures(rms, 2));
        let to = if low == high { String::new() } else { format!(" to {high}") };
        format!("; residuals {low}{to} nT rms")
    });
    Some(format!("Calibrated: {}{}{}.", parts.join(", "), ends.unwrap_or_default(), agreement(calibration)))
}

/// Whether the readings of the directions agree with what was declared, and how many do not belong to the
/// rest.
fn agreement(calibration: &Calibration) -> String {
    let axes = calibration.axes.as_ref();
    let doubtful = axes.map_or(0, |axes| axes.doubtful.len());
    let p = axes.and_then(|axes| axes.fit.as_ref()?.chi_squared_p);
    let noise = match p {
        Some(p) if p < UNLIKELY => "; the directions' readings scatter more than the declared noise",
        Some(_) => "; agrees with the model to the declared noise",
        None => "",
    };
    match doubtful {
        0 => noise.into(),
        count => format!("{noise}; {} among the readings of the directions", counted(count, "outlier")),
    }
}

/// The largest relative standard uncertainty.
fn ppm<'a>(all: impl Iterator<Item = &'a Quantity>) -> Option<String> {
    let largest = all.filter_map(Quantity::relative_std).reduce(f64::max);
    largest.map(|relative| format!("to {} ppm", significant(1e6 * relative, 2)))
}

fn known_to<const N: usize>(parts: [Option<String>; N]) -> String {
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    if parts.is_empty() { String::new() } else { format!(" ({})", parts.join(", ")) }
}

/// How many rows have a field, and how well it is known.
fn corrected(document: &Document) -> Option<String> {
    let (mut rows, mut all, mut largest) = (0, 0, 0.0_f64);
    for recording in &document.recordings {
        for quantity in ["field", "field_geo"] {
            let column = |name: &str, axis: Axis| recording.axis_column(name, axis, "nt");
            let Some(x) = column(quantity, Axis::X) else { continue };
            rows += x.iter().filter(|value| value.is_finite()).count();
            all += x.len();
            for axis in Axis::ALL {
                let std = column(&format!("{quantity}_std"), axis).unwrap_or_default();
                largest = std.iter().copied().filter(|std| std.is_finite()).fold(largest, f64::max);
            }
        }
    }
    let known = match largest > 0.0 {
        true => format!(", each component to {} nT or better", significant(largest, 2)),
        false => String::new(),
    };
    (all > 0).then(|| format!("Corrected: {rows} of {} have a field{known}.", counted(all, "row")))
}
