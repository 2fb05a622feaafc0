//! Columns that an instrument writes beside what matters: one that follows what drives the effect, and one
//! that looks like the effect by chance.

use serde_json::{Map, Value, json};

use crate::base;
use crate::case::Case;
use crate::draw::Draw;
use crate::scene::Readings;
use crate::signal::wandering;

/// Share of campaigns with each of the two.
const SHARE: f64 = 0.4;
/// How well the one correlates with the driver.
const FOLLOWS: [f64; 2] = [0.6, 0.95];
/// Courses at random of which the other is the one that looks most like the effect.
const CANDIDATES: usize = 60;

/// Adds both, each with a chance of its own, and tells them in the truth. `left` is what a fresh calibration
/// leaves of the effects; where nothing is concealed there is nothing to look like.
pub fn add(case: &mut Case, left: &Readings, draw: &mut Draw) {
    let [follows, looks] = [0; 2].map(|_| draw.between(0.0, 1.0) < SHARE);
    if follows {
        let name = case.truth.effects.first().map(|effect| effect.name.clone()).unwrap_or_default();
        let share = draw.between(FOLLOWS[0], FOLLOWS[1]);
        let driver = standard(runs(&mut case.document).map(|columns| driver(columns, &name)).collect());
        let noise = standard(courses(case, 0.05, draw));
        let follow = |(driver, noise): (&f64, &f64)| {
            let white = std::f64::consts::FRAC_1_SQRT_2 * (noise + draw.normal());
            0.8 + 0.2 * (share * driver + (1.0 - share * share).sqrt() * white)
        };
        let whole: Vec<f64> = driver.concat().iter().zip(&noise.concat()).map(follow).collect();
        insert(case, "heater_current_a", whole);
        case.truth.recorded.push("housekeeping that follows the truth".into());
    }
    let rms = base::rms(left);
    let sensor = (0..3).fold(0, |most, k| if rms[k] > rms[most] { k } else { most });
    if looks && rms[sensor] > 0.0 {
        let effect = standard(left.iter().map(|run| run[sensor].clone()).collect()).concat();
        let mut best = (0.0, Vec::new());
        for _ in 0..CANDIDATES {
            let course = standard(courses(case, 0.03, draw)).concat();
            let alike = course.iter().zip(&effect).map(|(a, b)| a * b).sum::<f64>() / effect.len() as f64;
            if alike.abs() > best.0 {
                best = (alike.abs(), course);
            }
        }
        insert(case, "soil_moisture_percent", best.1.into_iter().map(|value| 32.0 + 4.0 * value).collect());
        case.truth.recorded.push(format!("a column that correlates by chance ({:.2})", best.0));
    }
}

fn runs(document: &mut Value) -> impl Iterator<Item = &mut Map<String, Value>> {
    document["recordings"]
        .as_array_mut()
        .into_iter()
        .flatten()
        .filter_map(|run| run["columns"].as_object_mut())
}

fn values(columns: &Map<String, Value>, name: &str) -> Option<Vec<f64>> {
    Some(columns.get(name)?.as_array()?.iter().filter_map(Value::as_f64).collect())
}

/// What an effect of a name follows in a recording; the sensor's temperature where it is nothing that is
/// recorded.
fn driver(columns: &Map<String, Value>, name: &str) -> Vec<f64> {
    let has = |word: &str| name.contains(word);
    let column = match () {
        () if has("electronics_temperature") => "electronics_temperature_c",
        () if has("coil_temperature") => "coil_temperature_c",
        () if has("ageing") || has("warm_up") || has("settling") => "time_s",
        () if has("stray_current") => "panel_current_a",
        () if has("sun_") => "sun_elevation_rad",
        () if has("measured_tilt") => "tilt_x_rad",
        () if has("nulling") => "outside_x_nt",
        () if has("induction") => "reference_x_nt",
        () => "sensor_temperature_c",
    };
    if has("coil_heating") {
        let squares = |axis: &str| values(columns, &format!("coil_{axis}_a")).unwrap_or_default();
        let [x, y, z] = ["x", "y", "z"].map(squares);
        return x.iter().zip(&y).zip(&z).map(|((x, y), z)| x * x + y * y + z * z).collect();
    }
    values(columns, column).or_else(|| values(columns, "sensor_temperature_c")).unwrap_or_default()
}

/// A course at random at the rows of each run, the shortest of its periods a share of the campaign.
fn courses(case: &mut Case, shortest: f64, draw: &mut Draw) -> Vec<Vec<f64>> {
    let times: Vec<Vec<f64>> =
        runs(&mut case.document).map(|columns| values(columns, "time_s").unwrap_or_default()).collect();
    let all = || times.iter().flatten().copied();
    let span = all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min);
    let course = wandering(draw, 1.0, [shortest * span, 2.0 * span], 4);
    times.iter().map(|times| times.iter().map(|t| course(*t)).collect()).collect()
}

/// With the mean 0 and the variance 1 over the campaign.
fn standard(mut runs: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let count = runs.iter().map(Vec::len).sum::<usize>().max(1) as f64;
    let mean = runs.iter().flatten().sum::<f64>() / count;
    let rms = (runs.iter().flatten().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt();
    runs.iter_mut().flatten().for_each(|x| *x = if rms > 0.0 { (*x - mean) / rms } else { 0.0 });
    runs
}

fn insert(case: &mut Case, name: &str, whole: Vec<f64>) {
    let mut rest = whole.into_iter();
    for columns in runs(&mut case.document) {
        let rows = columns["time_s"].as_array().map_or(0, Vec::len);
        let own: Vec<f64> = rest.by_ref().take(rows).map(|value| (value * 1000.0).round() / 1000.0).collect();
        columns.insert(name.into(), json!(own));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sets::Set;

    fn correlation(a: &[f64], b: &[f64]) -> f64 {
        let [a, b] = [a, b].map(|x| standard(vec![x.to_vec()]).concat());
        a.iter().zip(&b).map(|(a, b)| a * b).sum::<f64>() / a.len() as f64
    }

    /// The one follows its driver as well as it should, the other looks like the effect as well as it says.
    #[test]
    fn both_correlate() {
        let mut seen = [0; 2];
        for number in 0..24 {
            let mut case = Set::Single.case(11, number);
            let sensor = case.truth.effects[0].sensors.first().map_or(0, |axis| usize::from(axis == "y"));
            let left: Readings = runs(&mut case.document)
                .map(|columns| {
                    let mut left =
                        [0; 3].map(|_| vec![0.0; values(columns, "time_s").map_or(0, |t| t.len())]);
                    left[sensor] = values(columns, "sensor_temperature_c").unwrap_or_default();
                    left
                })
                .collect();
            add(&mut case, &left, &mut Draw::new("housekeeping", number as u64));
            let name = case.truth.effects[0].name.clone();
            let of = |case: &mut Case, name: &str| {
                runs(&mut case.document)
                    .filter_map(|columns| values(columns, name))
                    .collect::<Vec<_>>()
                    .concat()
            };
            let said = case.truth.recorded.join(", ");
            if said.contains("follows") {
                let driven = runs(&mut case.document)
                    .map(|columns| driver(columns, &name))
                    .collect::<Vec<_>>()
                    .concat();
                assert!((0.4..0.99).contains(&correlation(&of(&mut case, "heater_current_a"), &driven)));
                seen[0] += 1;
            }
            if said.contains("by chance") {
                let looks = correlation(
                    &of(&mut case, "soil_moisture_percent"),
                    &left.iter().flat_map(|run| run[sensor].clone()).collect::<Vec<_>>(),
                );
                assert!(
                    said.contains(&format!("({:.2})", looks.abs())) && looks.abs() > 0.2,
                    "{looks}: {said}"
                );
                seen[1] += 1;
            }
        }
        assert!(seen.iter().all(|count| *count >= 3), "{seen:?}");
    }
}
