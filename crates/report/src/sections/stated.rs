//! What the document states beforehand: instrument, facility, reference conditions.

use common::{Axis, Document, Noise, NoiseOfSensors, Quantity};

use crate::{Section, Table};

/// The section; None where the document has nothing of it.
pub fn section(document: &Document) -> Option<Section> {
    let mut section = Section::new("stated", "Instrument and facility");
    let mut table = Table::new("As stated beforehand", [("what", ""), ("value", ""), ("unit", "")]);
    let mut state = |what: &str, value: Option<f64>, unit: &str| {
        if let Some(value) = value {
            table.row([what.into(), value.into(), unit.into()]);
        }
    };
    if let Some(instrument) = &document.instrument {
        section.words.extend(instrument.name.clone());
        state("range of the instrument, ±", instrument.range_nt, "nT");
        state("nominal sensitivity", instrument.nominal_sensitivity_nt_per_v, "nT/V");
        state("quantisation step", instrument.quantisation_v, "V");
        state("quantisation step", instrument.quantisation_nt, "nT");
        match &instrument.noise {
            Some(NoiseOfSensors::Same(noise)) => noise_of(&mut state, "each sensor", noise),
            Some(NoiseOfSensors::Each(each)) => {
                each.iter().for_each(|(axis, noise)| noise_of(&mut state, &format!("sensor {axis}"), noise));
            }
            None => {}
        }
    }
    if let Some(facility) = &document.facility {
        for axis in Axis::ALL {
            let Some(coil) = facility.coils.as_ref().and_then(|coils| coils.get(axis)) else { continue };
            state(&format!("resistor of coil {axis}"), coil.resistor_ohm, "Ω");
            state(
                &format!("its relative standard uncertainty, coil {axis}"),
                coil.resistor_relative_uncertainty,
                "",
            );
            state(&format!("largest field of coil {axis}"), coil.max_nt, "nT");
            state(
                &format!("gradient of coil {axis}"),
                coil.gradient_nt_per_m_a.as_ref().map(Quantity::value),
                "nT/(m A)",
            );
        }
        let voltmeter = facility.voltmeter.as_ref();
        state("voltmeter, standard uncertainty", voltmeter.and_then(|v| v.absolute_v), "V");
        state("voltmeter, relative standard uncertainty", voltmeter.and_then(|v| v.relative), "");
        state("theodolite, standard uncertainty of a reading", facility.theodolite_arcsec, "arcsec");
        state(
            "theodolite, standard uncertainty that the readings of a setting share",
            facility.theodolite_shared_arcsec,
            "arcsec",
        );
        state("scalar reference, standard uncertainty", facility.reference_std_nt, "nT");
        state(
            "field left by nulling, standard uncertainty of a component",
            facility.residual_field_std_nt,
            "nT",
        );
    }
    let reference =
        document.calibration.as_ref().and_then(|calibration| calibration.reference_conditions.as_ref());
    if let Some(reference) = reference {
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

fn noise_of(state: &mut impl FnMut(&str, Option<f64>, &str), of: &str, noise: &Noise) {
    state(&format!("white noise of a reading, {of}"), noise.white_rms_nt, "nT rms");
    state(&format!("flicker noise at 1 Hz, {of}"), noise.flicker_nt2_per_hz_at_1hz, "nT²/Hz");
    state(&format!("exponent of the flicker noise, {of}"), noise.flicker_exponent, "");
    state(&format!("random walk, {of}"), noise.random_walk_nt_per_sqrt_s, "nT/√s");
    state(&format!("relative standard uncertainty of this noise, {of}"), noise.relative_std, "");
}
