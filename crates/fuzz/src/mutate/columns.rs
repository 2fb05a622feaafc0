//! Changes to what recordings read, and to covariances.

use serde_json::{Map, Value, json};

use super::{pointers, values};
use crate::corpus::Context;
use crate::draw::Draw;

/// The columns of some recording.
fn columns<'a>(value: &'a mut Value, draw: &mut Draw) -> Option<&'a mut Map<String, Value>> {
    let recordings = value.get_mut("recordings")?.as_array_mut()?;
    let index = draw.below(recordings.len());
    recordings.get_mut(index)?.get_mut("columns")?.as_object_mut().filter(|columns| !columns.is_empty())
}

fn some_key(map: &Map<String, Value>, draw: &mut Draw) -> String {
    map.keys().nth(draw.below(map.len())).cloned().unwrap_or_default()
}

/// Changes the numbers of a column, at a place of it or all. None: it has none; a missing reading is none.
fn change(
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

/// Scaled, constant, in another order, with a jump, a spike or rounded.
pub fn column(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let columns = columns(value, draw)?;
    let name = some_key(columns, draw);
    change(&mut columns[&name], draw, |column, place, draw| match draw.below(9) {
        0 => scale(column, draw, &[-1.0, 0.0, 1e-3, 1e3, 1e-9, 1e9, 1e-30, 1e30, 1e-160, 1e160, 1.1]),
        1 => {
            let all = if draw.chance(50) { column[place] } else { values::reading(draw) };
            column.fill(all);
        }
        2 => draw.shuffle(column),
        3 => column.reverse(),
        4 => shift(&mut column[place..], draw, &[1.0, -1.0, 1e3, 1e5, 1e-6]),
        5 | 6 => column[place] = values::reading(draw),
        7 => {
            let code = *draw.of(&[1e-3, 1.0, 100.0, 1e5]);
            column.iter_mut().for_each(|x| *x = (*x / code).round() * code);
        }
        _ => column.sort_by(f64::total_cmp),
    })
}

/// Repeated, backwards, with a clock that jumps, far away, or at one step.
pub fn times(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let column = columns(value, draw)?.get_mut("time_s")?;
    change(column, draw, |times, place, draw| match draw.below(7) {
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
    })
}

/// One column's readings in another's place.
pub fn exchanged(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let columns = columns(value, draw)?;
    let (one, other) = (some_key(columns, draw), some_key(columns, draw));
    let (a, b) = (columns[&one].clone(), columns[&other].clone());
    if draw.chance(50) {
        columns[&one] = b.clone();
    } else if draw.chance(30) {
        columns.shift_remove(&one);
        return Some(());
    }
    if draw.chance(50) {
        columns[&other] = a;
    }
    (one != other).then_some(())
}

/// Another unit at the end of a column's name.
pub fn unit(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let columns = columns(value, draw)?;
    let name = some_key(columns, draw);
    let stem = name.rsplit_once('_').map_or(name.as_str(), |(stem, _)| stem);
    let to = *draw.of(&["v", "nt", "a", "s", "c", "ut", "hz", "rad", "furlong", "counts", ""]);
    pointers::rename(columns, &name, format!("{stem}_{to}"));
    Some(())
}

/// All columns, changed alike.
fn each(columns: &mut Map<String, Value>, change: impl Fn(&mut Vec<Value>)) {
    columns.values_mut().filter_map(Value::as_array_mut).for_each(change);
}

fn rows(columns: &Map<String, Value>) -> usize {
    columns.values().filter_map(Value::as_array).map(Vec::len).max().unwrap_or(0)
}

/// Few rows, of all columns or one.
pub fn rows_cut(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let columns = columns(value, draw)?;
    let left = if draw.chance(70) { draw.below(8) } else { draw.below(rows(columns) + 1) };
    if draw.chance(10) {
        let name = some_key(columns, draw);
        if let Some(list) = columns[&name].as_array_mut() {
            list.truncate(left);
        }
    } else {
        let from = draw.below(rows(columns).saturating_sub(left) + 1);
        each(columns, |list| {
            list.drain(..from.min(list.len()));
            list.truncate(left);
        });
    }
    Some(())
}

/// Rows again, at the end or in their place.
pub fn rows_repeated(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let columns = columns(value, draw)?;
    let rows = rows(columns);
    if rows == 0 || rows > 2000 {
        return None;
    }
    let (row, times) = (draw.below(rows), draw.between(1, 4));
    let whole = draw.chance(50);
    each(columns, |list| {
        if whole {
            *list = list.iter().cycle().take(list.len() * (times + 1)).cloned().collect();
        } else if let Some(item) = list.get(row).cloned() {
            (0..times).for_each(|_| list.insert(row, item.clone()));
        }
    });
    Some(())
}

/// Nulls in one column or in all.
pub fn missing(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let columns = columns(value, draw)?;
    let name = some_key(columns, draw);
    let (all, share) = (draw.chance(20), *draw.of(&[5, 50, 95, 100]));
    for (key, column) in columns.iter_mut() {
        if all || *key == name {
            for item in column.as_array_mut().into_iter().flatten() {
                if draw.chance(share) {
                    *item = Value::Null;
                }
            }
        }
    }
    Some(())
}

/// Negative, not symmetric, not positive, of another size, tiny or huge.
pub fn covariance(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let all = pointers::keys(value);
    let places = all.get("covariance")?;
    let Some(Value::Array(matrix)) = value.pointer_mut(draw.of(places).as_str()) else { return None };
    let size = Some(matrix.len()).filter(|size| *size > 0)?;
    let (i, j) = (draw.below(size), draw.below(size));
    let at = |matrix: &[Value], i: usize, j: usize| matrix[i].get(j).and_then(Value::as_f64).unwrap_or(0.0);
    let set = |matrix: &mut [Value], i: usize, j: usize, x: f64| {
        if let Some(place) = matrix[i].get_mut(j) {
            *place = json!(x);
        }
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
        5 => {
            matrix.remove(i);
        }
        _ => set(matrix, i, i, *draw.of(&[0.0, 1e-300, 1e300, 1e10])),
    }
    Some(())
}
