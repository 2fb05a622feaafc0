//! A main field that was compensated, as offsets of the sensors.

use common::{Axis, Document, Quantity};

/// Writes what makes readings of variations the whole field: each stated sensitivity times a common scale factor, and
/// offsets (nT) to be added. `volts`: whether the readings are in volts.
pub fn state_main_field(document: &mut Document, volts: bool, scale: f64, added_nt: &[Quantity; 3]) {
    let nominal = document.instrument.as_ref().and_then(|instrument| instrument.nominal_sensitivity_nt_per_v);
    let sensors = document.calibration.get_or_insert_default().sensors.get_or_insert_default();
    for (axis, added) in Axis::ALL.into_iter().zip(added_nt) {
        let sensor = sensors.entry(axis).get_or_insert_default();
        let (place, usual) = match volts {
            true => (&mut sensor.sensitivity_nt_per_v, nominal.unwrap_or(1.0)),
            false => (&mut sensor.sensitivity_nt_per_nt, 1.0),
        };
        let known = place.take().unwrap_or(Quantity::Bare(usual));
        *place = Some(match known.std() {
            Some(std) => Quantity::new(known.value() * scale, std * scale),
            None => Quantity::Bare(known.value() * scale),
        });
        let before = sensor.offset_nt.take().unwrap_or_default();
        let std = added.std().unwrap_or(0.0).hypot(before.std().unwrap_or(0.0) * scale);
        sensor.offset_nt = Some(Quantity::new(before.value() * scale + added.value(), std));
    }
}
