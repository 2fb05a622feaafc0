//! The paths by which sources name the parameters of a document.

use crate::{AdoptedEffect, Axis};

/// The path of the share by which the voltmeter reads high.
pub const VOLTMETER_RELATIVE: &str = "facility.voltmeter.relative";
/// The path of what the voltmeter adds.
pub const VOLTMETER_ABSOLUTE: &str = "facility.voltmeter.absolute_v";

/// The path of a coil's precision resistor.
pub fn resistor(coil: Axis) -> String {
    format!("facility.coils.{coil}.resistor_ohm")
}

/// The path of a coil's gradient.
pub fn gradient(coil: Axis) -> String {
    format!("facility.coils.{coil}.gradient_nt_per_m_a")
}

/// The path of a coordinate of a sensor's place.
pub fn place(sensor: Axis, k: usize) -> String {
    format!("instrument.positions_m.{sensor}[{k}]")
}

/// The path of a coil's constant.
pub fn coil_constant(coil: Axis) -> String {
    format!("calibration.coils.{coil}.constant_nt_per_a")
}

/// The path of a coil's offset.
pub fn coil_offset(coil: Axis) -> String {
    format!("calibration.coils.{coil}.offset_nt")
}

/// The path of a sensor's sensitivity, `unit` being `v` or `nt`.
pub fn sensitivity(sensor: Axis, unit: &str) -> String {
    format!("calibration.sensors.{sensor}.sensitivity_nt_per_{unit}")
}

/// The path of a sensor's offset.
pub fn sensor_offset(sensor: Axis) -> String {
    format!("calibration.sensors.{sensor}.offset_nt")
}

/// The path of what axescal adds to a sensor's offset; the sources move the sum.
pub fn added_offset(sensor: Axis) -> String {
    format!("calibration.axes.offsets_nt.{sensor}")
}

/// The path of a component of the residual field; the sources move its sum with the offset of the coil.
pub fn residual_field(axis: Axis) -> String {
    format!("calibration.axes.residual_field_nt.{axis}")
}

/// The paths of the nine cosines of the directions of `sensors` or `coils`, column by column.
pub fn directions(of: &str) -> Vec<String> {
    (0..9).map(|k| format!("calibration.axes.{of}.matrix[{}][{}]", k % 3, k / 3)).collect()
}

/// The path of a parameter of an effect of the model, by what the effect is and what it belongs to, not by
/// its place in the list. Of two that happen in one sensor the moments tell which is which.
pub fn effect(effect: &AdoptedEffect, parameter: &str) -> String {
    let axis = effect.sensor.or(effect.coil).map(|axis| format!(" {axis}")).unwrap_or_default();
    let of = |what: &Option<String>| what.as_ref().map(|name| format!(" {name}")).unwrap_or_default();
    let times =
        [effect.from_s, effect.to_s].map(|time| time.map(|t| format!(" {t}")).unwrap_or_default()).concat();
    let moment =
        effect.parameters.get("time_s").map(|time| format!(" at {}", time.value())).unwrap_or_default();
    format!(
        "model.effects[{}{axis}{}{}{times}{moment}].{parameter}",
        effect.effect,
        of(&effect.column),
        of(&effect.recording)
    )
}
