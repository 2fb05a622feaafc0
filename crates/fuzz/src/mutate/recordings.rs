//! Changes to the list of recordings.

use serde_json::{Value, json};

use super::values;
use crate::corpus::Context;
use crate::draw::Draw;

/// What a recording may follow, with bars between.
const PROCEDURES: &str = "coil_constant|coil_gradient|nulling_residual|sensor_sensitivity|\
    sensor_offset_reversal|sensor_noise|offset_drift|temperature_run|cross_field|axes_orientation|\
    differential|free_run|another";

/// When a recording may begin, with bars between.
const STARTS: &str = "1977-05-26T14:44:35Z|1977-05-26T14:44:35+23:59|2024-02-29T23:59:60Z|\
    -009999-01-02T01:59:59Z|9999-12-30T22:00:00.999999999Z|1677-01-01T00:00:00Z|2262-12-31T00:00:00Z|\
    1977-05-26|yesterday";

fn recordings(value: &mut Value) -> Option<&mut Vec<Value>> {
    value.get_mut("recordings")?.as_array_mut().filter(|list| !list.is_empty())
}

/// All but one, half of them, or one.
pub fn left_out(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let list = recordings(value)?;
    let place = draw.below(list.len());
    match draw.below(3) {
        0 => {
            list.remove(place);
        }
        1 => *list = vec![list.swap_remove(place)],
        _ => list.truncate(place),
    }
    Some(())
}

/// One again, by its own name or another.
pub fn twice(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let list = recordings(value)?;
    let mut again = draw.of(list).clone();
    if !again.is_object() {
        return None;
    }
    if draw.chance(80) {
        again["id"] = json!(format!("again-{}", list.len()));
    }
    if draw.chance(30) {
        again["start"] = json!(draw.part(STARTS));
    }
    list.push(again);
    Some(())
}

/// In another order, which means nothing.
pub fn permuted(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let list = recordings(value)?;
    draw.shuffle(list);
    Some(())
}

/// Another procedure, start, sensor, coil, orientation or condition.
pub fn conditions(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let list = recordings(value)?;
    let place = draw.below(list.len());
    let recording = list[place].as_object_mut()?;
    match draw.below(4) {
        0 => {
            recording.insert("procedure".into(), json!(draw.part(PROCEDURES)));
        }
        1 => {
            recording.insert("start".into(), json!(draw.part(STARTS)));
        }
        2 => {
            recording.shift_remove(*draw.of(&["start", "conditions", "id", "procedure", "columns"]));
        }
        _ => {
            let Value::Object(conditions) = recording.entry("conditions").or_insert_with(|| json!({})) else {
                return None;
            };
            let (key, to) = match draw.below(5) {
                0 => (*draw.of(&["sensor", "coil"]), json!(*draw.of(&["x", "y", "z", "w"]))),
                1 => ("orientation", draw.of(&turns()).clone()),
                2 => {
                    let keys = ["sensor_temperature_c", "electronics_temperature_c", "coil_temperature_c"];
                    (*draw.of(&keys), values::number(draw))
                }
                3 => {
                    let keys = ["drive_hz", "integration_s", "ambient_x_nt", "ambient_y_nt", "ambient_z_nt"];
                    (*draw.of(&keys), values::number(draw))
                }
                _ => (
                    "theodolite",
                    json!({"phi_x_rad": [1e-5, 2e-5], "theta_x_rad": 0, "phi_y_rad": 0.1, "theta_y_rad": 7}),
                ),
            };
            conditions.insert(key.into(), to);
        }
    }
    Some(())
}

/// Rotations, and matrices that are none.
fn turns() -> [Value; 6] {
    [
        json!([[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        json!([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
        json!([[0, 0, 1], [1, 0, 0], [0, 1, 0]]),
        json!([[0, 0, 0], [0, 0, 0], [0, 0, 0]]),
        json!([[0, 1, 0], [1, 0, 0], [0, 0, 1]]),
        json!([[1, 1e-4, 0], [-1e-4, 1, 0], [0, 0, 1]]),
    ]
}
