//! Changes to recordings, to what they read, and to covariances.

use serde_json::{Map, Value, json};

use super::{pointers, values};
use crate::draw::Draw;

/// What a recording may follow, with bars between.
const PROCEDURES: &str = "coil_constant|coil_gradient|nulling_residual|sensor_sensitivity|\
    sensor_offset_reversal|sensor_noise|offset_drift|temperature_run|cross_field|axes_orientation|\
    differential|free_run|another";

/// When a recording may begin, with bars between.
const STARTS: &str = "1977-05-26T14:44:35Z|1977-05-26T14:44:35+23:59|2024-02-29T23:59:60Z|\
    -009999-01-02T01:59:59Z|9999-12-30T22:00:00.999999999Z|1677-01-01T00:00:00Z|2262-12-31T00:00:00Z|\
    1977-05-26|yesterday";

/// Rotations, and matrices that are none, with bars between.
const TURNS: &str = "[[1,0,0],[0,1,0],[0,0,1]]|[[0,1,0],[-1,0,0],[0,0,1]]|[[0,0,1],[1,0,0],[0,1,0]]|\
    [[0,0,0],[0,0,0],[0,0,0]]|[[0,1,0],[1,0,0],[0,0,1]]|[[1,1e-4,0],[-1e-4,1,0],[0,0,1]]";

/// Makes a change by its name; None where it cannot be made here.
pub fn change(value: &mut Value, name: &str, draw: &mut Draw) -> Option<()> {
    if name == "a covariance changed" {
        return covariance(value, draw);
    }
    let list = value.get_mut("recordings")?.as_array_mut().filter(|list| !list.is_empty())?;
    match name {
        "recordings in another order" => draw.shuffle(list),
        "recordings left out" => {
            let place = draw.below(list.len());
            match draw.below(3) {
                0 => drop(list.remove(place)),
                1 => *list = vec![list.swap_remove(place)],
                _ => list.truncate(place),
            }
        }
        "a recording twice" => {
            let mut again = draw.of(list).clone();
            let recording = again.as_object_mut()?;
            if draw.chance(80) {
                recording.insert("id".into(), json!(format!("again-{}", list.len())));
            }
            if draw.chance(30) {
                recording.insert("start".into(), json!(draw.part(STARTS)));
            }
            list.push(again);
        }
        _ => {
            let place = draw.below(list.len());
            let recording = &mut list[place];
            match name {
                "a recording's conditions changed" => conditions(recording.as_object_mut()?, draw)?,
                _ => {
                    let columns = recording.get_mut("columns")?.as_object_mut();
                    change_columns(columns.filter(|columns| !columns.is_empty())?, name, draw)?;
                }
            }
        }
    }
    Some(())
}

/// Another procedure, start, sensor, coil, orientation or condition.
fn conditions(recording: &mut Map<String, Value>, draw: &mut Draw) -> Option<()> {
    match draw.below(4) {
        0 => drop(recording.insert("procedure".into(), json!(draw.part(PROCEDURES)))),
        1 => drop(recording.insert("start".into(), json!(draw.part(STARTS)))),
        2 => drop(recording.shift_remove(draw.part("start|conditions|id|procedure|columns"))),
        _ => {
            let conditions = recording.entry("conditions").or_insert_with(|| json!({})).as_object_mut()?;
            let (key, to) = match draw.below(5) {
                0 => (draw.part("sensor|coil"), json!(draw.part("x|y|z|w"))),
                1 => ("orientation", serde_json::from_str(draw.part(TURNS)).ok()?),
                2 => {
                    let keys = "sensor_temperature_c|electronics_temperature_c|coil_temperature_c";
                    (draw.part(keys), values::number(draw))
                }
                3 => {
                    let keys = "drive_hz|integration_s|ambient_x_nt|ambient_y_nt|ambient_z_nt";
                    (draw.part(keys), values::number(draw))
                }
                _ => {
                    let angles = json!({"phi_x_rad": [1e-5, 2e-5], "theta_x_rad": 0, "phi_y_rad": 0.1, "theta_y_rad": 7});
                    ("theodolite", angles)
                }
            };
            conditions.insert(key.into(), to);
        }
    }
    Some(())
}

fn some_key(map: &Map<String, Value>, draw: &mut Draw) -> String {
    map.keys().nth(draw.below(map.len())).cloned().unwrap_or_default()
}

/// Changes the numbers of a column, at a place of it or all. None: it has none; a missing reading is none.
fn numbers(
    column: &mut Value,
    draw: &mut Draw,
    with: impl FnOnce(&mut Vec<f64>, usize, &mut Draw),
) -> Option<()> {
    let mut numbers: Vec<f64> = column.as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    if numbers.is_empty() {
        return None;
    }
    let place = draw.below(numbers.len());
    with(&mut numbers, place, draw);
    *column = json!(numbers);
    Some(())
}

fn scale(numbers: &mut [f64], draw: &mut Draw, factors: &[f64]) {
    let factor = draw.of(factors);
    numbers.iter_mut().for_each(|x| *x *= factor);
}

fn shift(numbers: &mut [f64], draw: &mut Draw, by: &[f64]) {
    let by = draw.of(by);
    numbers.iter_mut().for_each(|x| *x += by);
}

fn each(columns: &mut Map<String, Value>, change: impl Fn(&mut Vec<Value>)) {
    columns.values_mut().filter_map(Value::as_array_mut).for_each(change);
}

fn change_columns(columns: &mut Map<String, Value>, name: &str, draw: &mut Draw) -> Option<()> {
    let rows = columns.values().filter_map(Value::as_array).map(Vec::len).max().unwrap_or(0);
    match name {
        "a column changed" => {
            let name = some_key(columns, draw);
            numbers(&mut columns[&name], draw, |column, place, draw| match draw.below(9) {
                0 => scale(column, draw, &[-1.0, 0.0, 1e-3, 1e3, 1e-9, 1e9, 1e-30, 1e30, 1e-160, 1e160, 1.1]),
                1 => {
                    let all = if draw.chance(50) { column[place] } else { *draw.of(&values::NUMBERS) };
                    column.fill(all);
                }
                2 => draw.shuffle(column),
                3 => column.reverse(),
                4 => shift(&mut column[place..], draw, &[1.0, -1.0, 1e3, 1e5, 1e-6]),
                5 | 6 => column[place] = *draw.of(&values::NUMBERS),
                7 => {
                    let code = *draw.of(&[1e-3, 1.0, 100.0, 1e5]);
                    column.iter_mut().for_each(|x| *x = (*x / code).round() * code);
                }
                _ => column.sort_by(f64::total_cmp),
            })?;
        }
        "times changed" => {
            numbers(columns.get_mut("time_s")?, draw, |times, place, draw| match draw.below(7) {
                0 => times[place] = times[place.saturating_sub(1)],
                1 => {
                    let jumps = [-1.0, 1.0, -3600.0, 3600.0, 86400.0, 1e9, 1e15, -1e9, 0.001];
                    shift(&mut times[place..], draw, &jumps);
                }
                2 => times.reverse(),
                3 => scale(times, draw, &[0.0, 1e-9, 1e-3, 1e3, 1e9, -1.0]),
                4 => shift(times, draw, &[1e6, 1.7e9, 1.7e12, 1e18, -1e10]),
                5 => times.iter_mut().enumerate().for_each(|(row, t)| *t = row as f64),
                _ => {
                    let other = draw.below(times.len());
                    times.swap(place, other);
                }
            })?
        }
        "columns exchanged or copied" => {
            let (one, other) = (some_key(columns, draw), some_key(columns, draw));
            let (a, b) = (columns[&one].clone(), columns[&other].clone());
            if draw.chance(50) {
                columns[&one] = b;
            } else if draw.chance(30) {
                columns.shift_remove(&one);
                return Some(());
            }
            if draw.chance(50) {
                columns[&other] = a;
            }
            return (one != other).then_some(());
        }
        "a column's unit changed" => {
            let name = some_key(columns, draw);
            let stem = name.rsplit_once('_').map_or(name.as_str(), |(stem, _)| stem);
            let to = draw.part("v|nt|a|s|c|ut|hz|rad|furlong|counts|");
            pointers::rename(columns, &name, format!("{stem}_{to}"));
        }
        "rows cut" => {
            let left = if draw.chance(70) { draw.below(8) } else { draw.below(rows + 1) };
            if draw.chance(10) {
                let name = some_key(columns, draw);
                columns[&name].as_array_mut().into_iter().for_each(|list| list.truncate(left));
            } else {
                let from = draw.below(rows.saturating_sub(left) + 1);
                each(columns, |list| {
                    list.drain(..from.min(list.len()));
                    list.truncate(left);
                });
            }
        }
        "rows repeated" if (1..=2000).contains(&rows) => {
            let (row, times) = (draw.below(rows), draw.between(1, 4));
            let whole = draw.chance(50);
            each(columns, |list| {
                if whole {
                    *list = list.iter().cycle().take(list.len() * (times + 1)).cloned().collect();
                } else if let Some(item) = list.get(row).cloned() {
                    (0..times).for_each(|_| list.insert(row, item.clone()));
                }
            });
        }
        "readings missing" => {
            let name = some_key(columns, draw);
            let (all, share) = (draw.chance(20), *draw.of(&[5, 50, 95, 100]));
            for (_, column) in columns.iter_mut().filter(|(key, _)| all || **key == name) {
                let items = column.as_array_mut().into_iter().flatten();
                items.for_each(|item| {
                    if draw.chance(share) {
                        *item = Value::Null;
                    }
                });
            }
        }
        _ => return None,
    }
    Some(())
}

/// Negative, not symmetric, not positive, of another size, tiny or huge.
fn covariance(value: &mut Value, draw: &mut Draw) -> Option<()> {
    let all = pointers::keys(value);
    let place = draw.of(all.get("covariance")?).as_str();
    let matrix = value.pointer_mut(place)?.as_array_mut().filter(|matrix| !matrix.is_empty())?;
    let (i, j) = (draw.below(matrix.len()), draw.below(matrix.len()));
    let at = |matrix: &[Value], i: usize, j: usize| matrix[i].get(j).and_then(Value::as_f64).unwrap_or(0.0);
    let set = |matrix: &mut [Value], i: usize, j: usize, x: f64| {
        matrix[i].get_mut(j).into_iter().for_each(|place| *place = json!(x));
    };
    match draw.below(7) {
        0 => set(matrix, i, i, -1e-12),
        1 => set(matrix, i, j, 1.5),
        2 => {
            let both = 2.0 * (at(matrix, i, i) * at(matrix, j, j)).sqrt();
            set(matrix, i, j, both);
            set(matrix, j, i, both);
        }
        3 | 4 => {
            let factor = *draw.of(&[0.0, -1.0, 1e-30, 1e30, 1e200, 1e-300]);
            for item in matrix.iter_mut().filter_map(Value::as_array_mut).flatten() {
                *item = json!(item.as_f64().unwrap_or_default() * factor);
            }
        }
        5 => drop(matrix.remove(i)),
        _ => set(matrix, i, i, *draw.of(&[0.0, 1e-300, 1e300, 1e10])),
    }
    Some(())
}
