//! Documents as instruments write them: times printed to a thousandth or to a millionth of a second, gaps and
//! lost rows, noise declared wrongly or not at all, columns that have nothing to do with it.

use serde_json::{Map, Value, json};

use crate::case::Case;
use crate::draw::Draw;
use crate::signal::wandering;

/// Shortest step whose times may be printed to a thousandth of a second where they are not on it: below it,
/// and in coils whose field goes by hundreds of nT in a second, the rounding would be an error of its own.
const COARSE_S: f64 = 0.5;
/// What cannot lose rows: what happens at one reading must stay, and turns that are not read cannot be
/// counted.
const WHOLE: [&str; 3] = ["spike", "reaction_wheel", "reaction_wheel_harmonic"];
/// Stretches that are missing from a recording, at most, and the share of its rows that each may have.
const GAPS: usize = 3;
const GAP: f64 = 0.05;
/// Share of rows that are lost one by one.
const LOST: f64 = 0.02;
/// By how much declared noise is off, as a factor.
const OFF: f64 = 1.1;
/// Columns that say nothing, with their mean and how far they wander.
const DECOYS: [(&str, f64, f64); 3] =
    [("humidity_percent", 45.0, 8.0), ("pressure_hpa", 1013.0, 6.0), ("supply_v", 12.0, 0.2)];

/// The case with its document as an instrument would have written it; what was done is added to the truth.
pub fn as_recorded(case: &mut Case, draw: &mut Draw) {
    let mut done = Vec::new();
    let may_lose = case.truth.effects.iter().all(|effect| !WHOLE.contains(&effect.name.as_str()));
    let (mut rounded, mut fine) = (false, false);
    let [printed, gaps, lost] = [0.5, 0.5, 0.3].map(|chance| draw.between(0.0, 1.0) < chance);
    let decoys = draw.below(DECOYS.len() + 1);
    for recording in case.document["recordings"].as_array_mut().into_iter().flatten() {
        let Some(columns) = recording["columns"].as_object_mut() else { continue };
        if may_lose && gaps {
            remove(columns, &stretches(rows(columns), draw));
        }
        if may_lose && lost {
            let gone: Vec<bool> = (0..rows(columns)).map(|_| draw.between(0.0, 1.0) < LOST).collect();
            remove(columns, &gone);
        }
        let time = values(columns, "time_s");
        let on_it = time.iter().zip(thousandths(&time)).all(|(time, printed)| (time - printed).abs() < 1e-7);
        let slow = time.windows(2).all(|pair| pair[1] - pair[0] >= COARSE_S);
        if printed && (on_it || (slow && !columns.contains_key("coil_x_a"))) {
            columns.insert("time_s".into(), json!(thousandths(&time)));
            rounded = true;
        } else {
            fine |= !on_it;
        }
        for (name, mean, wide) in &DECOYS[..decoys] {
            let span = time.last().copied().unwrap_or(1.0) - time.first().copied().unwrap_or(0.0);
            let wander = wandering(draw, *wide, [span / 3.0, 3.0 * span], 4);
            let course: Vec<f64> = time.iter().map(|t| mean + wander(*t)).collect();
            columns.insert((*name).into(), json!(thousandths(&course)));
        }
    }
    for (was, word) in [
        (gaps && may_lose, "gaps"),
        (lost && may_lose, "lost rows"),
        (rounded, "times to 1 ms"),
        (fine, "times to 1 us"),
    ] {
        done.extend(was.then(|| word.to_string()));
    }
    done.extend((decoys > 0).then(|| format!("{decoys} decoys")));
    match draw.below(3) {
        0 => {}
        1 => {
            let factor = if draw.sign() > 0.0 { OFF } else { 1.0 / OFF };
            for (key, factor) in [("white_rms_nt", factor), ("flicker_nt2_per_hz_at_1hz", factor * factor)] {
                let declared = &mut case.document["instrument"]["noise"];
                if let Some(value) = declared[key].as_f64() {
                    declared[key] = json!(value * factor);
                }
            }
            done.push(format!("noise declared {factor:.2} times"));
        }
        _ => {
            if let Some(instrument) = case.document["instrument"].as_object_mut() {
                instrument.remove("noise");
            }
            done.push("noise not declared".into());
        }
    }
    case.truth.recorded.extend(done);
}

fn rows(columns: &Map<String, Value>) -> usize {
    columns["time_s"].as_array().map_or(0, Vec::len)
}

fn values(columns: &Map<String, Value>, name: &str) -> Vec<f64> {
    columns[name].as_array().into_iter().flatten().filter_map(Value::as_f64).collect()
}

fn thousandths(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| (value * 1000.0).round() / 1000.0).collect()
}

/// Rows of some stretches, away from the ends.
fn stretches(rows: usize, draw: &mut Draw) -> Vec<bool> {
    let mut gone = vec![false; rows];
    for _ in 0..=draw.below(GAPS) {
        let long = (rows as f64 * draw.between(0.2 * GAP, GAP)) as usize;
        let from = rows / 10 + draw.below((8 * rows / 10).saturating_sub(long).max(1));
        gone[from..(from + long).min(rows)].fill(true);
    }
    gone
}

fn remove(columns: &mut Map<String, Value>, gone: &[bool]) {
    for values in columns.values_mut().filter_map(Value::as_array_mut) {
        let mut of = gone.iter();
        values.retain(|_| of.next() != Some(&true));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sets::Set;

    #[test]
    fn columns_stay_of_one_length_and_times_go_forward() {
        let mut seen = [false; 4];
        for number in 0..12 {
            let mut case = Set::Single.case(3, number);
            let before = case.document.clone();
            as_recorded(&mut case, &mut Draw::new("as recorded", number as u64));
            for recording in case.document["recordings"].as_array().expect("recordings") {
                let columns = recording["columns"].as_object().expect("columns");
                let rows = rows(columns);
                assert!(columns.values().all(|column| column.as_array().map(Vec::len) == Some(rows)));
                let time = values(columns, "time_s");
                assert!(time.windows(2).all(|pair| pair[1] > pair[0]));
            }
            let said = case.truth.recorded.join(", ");
            for (seen, word) in seen.iter_mut().zip(["gaps", "lost", "decoys", "not declared"]) {
                *seen |= said.contains(word);
            }
            assert_eq!(said.is_empty(), case.document == before, "{said}");
        }
        assert_eq!(seen, [true; 4]);
    }
}
