//! What the document states: instrument, facility and reference conditions beforehand, the physics that was
//! adopted, the programs that it went through.

use common::{AdoptedEffect, Axis, Document, Noise, NoiseOfSensors, Quantity};
use page::words::key;
use serde_json::Value;

use crate::{Cell, Section, Table};

pub fn section(document: &Document) -> Option<Section> {
    let mut section = Section::new("stated", "Instrument and facility");
    let mut table = Table::new("As stated beforehand", "what | value | unit");
    let mut state = |what: &str, value: Option<f64>, unit: &str| {
        if value.is_some() {
            table.row((what, value, unit));
        }
    };
    if let Some(instrument) = &document.instrument {
        section.words.extend(instrument.name.clone());
        state("range of the instrument, ±", instrument.range_nt, "nT");
        state("nominal sensitivity", instrument.nominal_sensitivity_nt_per_v, "nT/V");
        state("quantisation step", instrument.quantisation_v, "V");
        state("quantisation step", instrument.quantisation_nt, "nT");
        let mut noise_of = |of: &str, noise: &Noise| {
            state(&format!("white noise of a reading, {of}"), noise.white_rms_nt, "nT rms");
            state(&format!("flicker noise at 1 Hz, {of}"), noise.flicker_nt2_per_hz_at_1hz, "nT²/Hz");
            state(&format!("exponent of the flicker noise, {of}"), noise.flicker_exponent, "");
            state(&format!("random walk, {of}"), noise.random_walk_nt_per_sqrt_s, "nT/√s");
            state(&format!("relative standard uncertainty of this noise, {of}"), noise.relative_std, "");
        };
        match &instrument.noise {
            Some(NoiseOfSensors::Same(noise)) => noise_of("each sensor", noise),
            Some(NoiseOfSensors::Each(each)) => {
                each.iter().for_each(|(axis, noise)| noise_of(&format!("sensor {axis}"), noise));
            }
            None => {}
        }
    }
    if let Some(facility) = &document.facility {
        for axis in Axis::ALL {
            let Some(coil) = facility.coils.as_ref().and_then(|coils| coils.get(axis)) else { continue };
            let gradient = coil.gradient_nt_per_m_a.as_ref().map(Quantity::value);
            let relative = coil.resistor_relative_uncertainty;
            state(&format!("resistor of coil {axis}"), coil.resistor_ohm, "Ω");
            state(&format!("its relative standard uncertainty, coil {axis}"), relative, "");
            state(&format!("largest field of coil {axis}"), coil.max_nt, "nT");
            state(&format!("gradient of coil {axis}"), gradient, "nT/(m A)");
        }
        let voltmeter = facility.voltmeter.as_ref();
        let shared = "theodolite, standard uncertainty that the readings of a setting share";
        let left = "field left by nulling, standard uncertainty of a component";
        state("voltmeter, standard uncertainty", voltmeter.and_then(|v| v.absolute_v), "V");
        state("voltmeter, relative standard uncertainty", voltmeter.and_then(|v| v.relative), "");
        state("theodolite, standard uncertainty of a reading", facility.theodolite_arcsec, "arcsec");
        state(shared, facility.theodolite_shared_arcsec, "arcsec");
        state("scalar reference, standard uncertainty", facility.reference_std_nt, "nT");
        state(left, facility.residual_field_std_nt, "nT");
    }
    let calibration = document.calibration.as_ref();
    if let Some(reference) = calibration.and_then(|calibration| calibration.reference_conditions.as_ref()) {
        state("constants hold at: sensor", reference.sensor_temperature_c, "°C");
        state("constants hold at: electronics", reference.electronics_temperature_c, "°C");
        state("constants hold at: coils", reference.coil_temperature_c, "°C");
        state("variations outside count from: x", reference.outside_x_nt, "nT");
        state("variations outside count from: y", reference.outside_y_nt, "nT");
        state("variations outside count from: z", reference.outside_z_nt, "nT");
    }
    section.table(table);
    (!section.is_empty()).then_some(section)
}

/// Physics adopted beyond the basic model.
pub fn model(document: &Document) -> Option<Section> {
    let effects = &document.model.as_ref()?.effects;
    let mut section = Section::new("model", "Model beyond the line");
    section.words.push("`simulate` and `correct` apply these effects.".into());
    let mut table = Table::new("Effects", "effect | acts on | found by | parameter | value | unit");
    for effect in effects {
        let name = effect.effect.replace('_', " ");
        let on = on(effect);
        let found_by = effect.extra.get("found_by").and_then(Value::as_str);
        for (parameter, value) in &effect.parameters {
            let (parameter, unit) = key(parameter);
            table.row((&name, &on, found_by, parameter, value, unit));
        }
        if effect.parameters.is_empty() {
            table.row((name, on, found_by, Cell::Empty, Cell::Empty, Cell::Empty));
        }
    }
    section.table(table);
    (!section.items.is_empty()).then_some(section)
}

fn on(effect: &AdoptedEffect) -> String {
    let targets = [
        effect.sensor.map(|axis| format!("sensor {axis}")),
        effect.coil.map(|axis| format!("coil {axis}")),
        effect.column.clone(),
        effect.recording.as_ref().map(|id| format!("in {id}")),
    ];
    let targets: Vec<String> = targets.into_iter().flatten().collect();
    if targets.is_empty() { "all".into() } else { targets.join(", ") }
}

/// The programs that the document went through.
pub fn history(document: &Document) -> Option<Section> {
    let mut section = Section::new("history", "History");
    section.words.push(
        "No clock is in it: the same input gives the same bytes. The hash is that of the document that the program read.".into(),
    );
    let programs = document.history.iter();
    let programs =
        programs.map(|entry| (&entry.stage, &entry.version, entry.arguments.join(" "), &entry.input_sha256));
    section.rows("Programs", "program | version | arguments | SHA-256 of its input", programs);
    (!section.items.is_empty()).then_some(section)
}
