//! Each sensor: sensitivity, offset, temperature coefficients, trend, fields across, noise, and what else the
//! model has.

use common::{AdoptedEffect, Axis, Document, Quantity, SensorCalibration, uncertainty};
use conformity::{Joint, offset_path};
use page::Table;
use page::words::key;

use crate::expanded::Expanded;
use crate::sheet::Sheet;

/// The tables of the sensors.
pub fn tables(sheet: &mut Sheet, document: &Document, joint: &Joint) {
    let sensors = document.calibration.as_ref().and_then(|calibration| calibration.sensors.as_ref());
    let sensors: Vec<(Axis, &SensorCalibration)> =
        sensors.into_iter().flat_map(|sensors| sensors.iter()).collect();
    let all = |caption: &str, one: &dyn Fn(&mut Table, Axis, &SensorCalibration)| {
        let mut table = Expanded::table(caption);
        sensors.iter().for_each(|(axis, sensor)| one(&mut table, *axis, sensor));
        table
    };
    sheet.table(all(
        "Sensitivity k and offset O of B = k · reading + O, along each sensor's axis",
        &|table, axis, sensor| constants(table, document, joint, (axis, sensor)),
    ));
    sheet.table(all("Temperature coefficients at the reference temperatures", &temperature));
    sheet.table(all("Offset in time", &drift));
    sheet.table(all("Fields transverse to the sensor, at 50 000 nT", &across));
    sheet.table(all("Noise of a sensor", &noise));
    sheet.table(model(document));
}

/// k and O; where axescal found more of the offset, O is the sum, with its uncertainty.
fn constants(
    table: &mut Table,
    document: &Document,
    joint: &Joint,
    (axis, sensor): (Axis, &SensorCalibration),
) {
    let known = |path: &str| Some(joint.factor(path)).filter(|factor| *factor > 0.0);
    for (k, unit) in [(&sensor.sensitivity_nt_per_v, "v"), (&sensor.sensitivity_nt_per_nt, "nt")] {
        let Some(k) = k else { continue };
        let shown = if unit == "v" { "nT/V" } else { "nT/nT" };
        let factor = known(&uncertainty::sensitivity(axis, unit));
        Expanded::of(k, factor).row(table, &format!("sensor {axis}, sensitivity"), shown);
    }
    let Some(stated) = &sensor.offset_nt else { return };
    let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    let added = axes.and_then(|axes| axes.offsets_nt.as_ref()?.get(axis));
    let factor = known(&offset_path(document, axis));
    let offset = match added {
        Some(added) => {
            let factor = added.coverage_factor_95().or(factor);
            Expanded::new(stated.value() + added.value(), added.std().or(stated.std()), factor)
        }
        None => Expanded::of(stated, factor),
    };
    offset.row(table, &format!("sensor {axis}, offset"), "nT");
}

fn temperature(table: &mut Table, axis: Axis, sensor: &SensorCalibration) {
    let Some(fit) = &sensor.temperature else { return };
    let factor = Some(fit.noise.coverage_factor_95);
    for (of, part) in [("sensor", &fit.sensor), ("electronics", &fit.electronics)] {
        let Some(part) = part else { continue };
        let mut add = |what: &str, quantity: Option<&Quantity>, unit: &str| {
            if let Some(quantity) = quantity {
                let name = format!("sensor {axis}, {what} by the temperature of the {of}");
                Expanded::of(quantity, factor).row(table, &name, unit);
            }
        };
        add("sensitivity", Some(&part.sensitivity_ppm_per_k), "ppm/K");
        add("sensitivity, curvature", part.sensitivity_ppm_per_k2.as_ref(), "ppm/K²");
        add("offset", Some(&part.offset_nt_per_k), "nT/K");
        add("offset, curvature", part.offset_nt_per_k2.as_ref(), "nT/K²");
        add("lag", part.lag_s.as_ref(), "s");
    }
}

fn drift(table: &mut Table, axis: Axis, sensor: &SensorCalibration) {
    let Some(drift) = &sensor.drift else { return };
    if let Some(trend) = &drift.trend_nt_per_year {
        let trend = Expanded::of(trend, Some(drift.coverage_factor_95));
        trend.row(table, &format!("sensor {axis}, trend"), "nT/year");
    }
    let Some(annual) = &drift.annual else { return };
    for (name, part) in [("cosine", &annual.cosine_nt), ("sine", &annual.sine_nt)] {
        Expanded::of(part, None).row(table, &format!("sensor {axis}, yearly term, {name}"), "nT");
    }
}

fn across(table: &mut Table, axis: Axis, sensor: &SensorCalibration) {
    let Some(fit) = &sensor.cross_field else { return };
    for (what, group) in [("offset", &fit.offset), ("sensitivity", &fit.sensitivity)] {
        for (name, quantity) in group {
            let (name, unit) = key(name);
            let factor = Some(fit.noise.coverage_factor_95);
            Expanded::of(quantity, factor).row(table, &format!("sensor {axis}, {what}, {name}"), &unit);
        }
    }
}

fn noise(table: &mut Table, axis: Axis, sensor: &SensorCalibration) {
    let Some(noise) = &sensor.noise else { return };
    let mut add = |what: &str, quantity: &Quantity, unit: &str| {
        if quantity.std().is_some() {
            Expanded::of(quantity, None).row(table, &format!("sensor {axis}, {what}"), unit);
        }
    };
    add("density at 1 Hz", &noise.density_at_1hz_nt_per_sqrt_hz, "nT/√Hz");
    add("exponent α of 1/f^α", &noise.flicker_exponent, "1");
    add("white noise of a reading", &noise.white_rms_nt, "nT rms");
}

/// Effects of the model that no table above has.
fn model(document: &Document) -> Table {
    let mut table = Expanded::table("Further effects that belong to the calibration");
    let by_sensorcal =
        |effect: &AdoptedEffect| effect.extra.get("found_by").and_then(|by| by.as_str()) == Some("sensorcal");
    let effects = document.model.iter().flat_map(|model| &model.effects);
    for effect in effects.filter(|effect| !by_sensorcal(effect)) {
        let sensor = effect.sensor.map(|axis| format!(" of sensor {axis}"));
        let coil = effect.coil.map(|axis| format!(" of coil {axis}"));
        let recording = effect.recording.as_ref().map(|id| format!(" in \"{id}\""));
        let of = [sensor, coil, recording].into_iter().flatten().collect::<String>();
        for (name, quantity) in &effect.parameters {
            let (name, unit) = key(name);
            let what = format!("{}{of}: {name}", effect.effect.replace('_', " "));
            Expanded::of(quantity, None).row(&mut table, &what, if unit.is_empty() { "1" } else { &unit });
        }
    }
    table
}
