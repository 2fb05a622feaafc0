//! Temperatures, voltages, currents and whatever else was recorded beside a pair.

use common::Document;

use joined::Pair;

/// A column at the pair's rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Housekeeping {
    /// Its name; with the recording's id where another recording has one of the same name at the same time.
    pub name: String,
    /// On lines between neighbours; NaN beyond its ends.
    pub values: Vec<f64>,
}

impl Housekeeping {
    /// The values with the nearest known one beyond the ends; None where it never changes.
    pub fn whole(&self) -> Option<Vec<f64>> {
        let known = |value: &&f64| value.is_finite();
        let first = *self.values.iter().find(known)?;
        self.values.iter().filter(known).find(|value| **value != first)?;
        let mut last = first;
        let hold = |value: &f64| {
            if value.is_finite() {
                last = *value;
            }
            last
        };
        Some(self.values.iter().map(hold).collect())
    }
}

/// What the recordings of a pair hold besides times and fields.
pub fn columns(document: &Document, pair: &Pair) -> Vec<Housekeeping> {
    let recordings =
        || document.recordings.iter().filter(|recording| pair.recordings.contains(&recording.id));
    let starts = || recordings().filter_map(|recording| recording.start()).map(|start| start.unix_s);
    let earliest = starts().fold(f64::INFINITY, f64::min);
    let mut all: Vec<Housekeeping> = Vec::new();
    for recording in recordings() {
        let origin_s = recording.start().map_or(0.0, |start| start.unix_s - earliest);
        let Some(own) = recording.column("time_s") else { continue };
        for name in
            recording.columns.keys().filter(|name| !name.starts_with("time_") && !name.ends_with("_nt"))
        {
            let Some(values) = recording.column(name) else { continue };
            let known: Vec<(f64, f64)> = own
                .iter()
                .zip(values)
                .filter(|(t, value)| t.is_finite() && value.is_finite())
                .map(|(t, value)| (t + origin_s, *value))
                .collect();
            let at: Vec<f64> = (0..pair.whole.len()).map(|row| between(&known, pair.time_s(row))).collect();
            let another = |have: &Housekeeping| have.name == *name;
            match all.iter_mut().find(|have| another(have)) {
                // Another piece of the same.
                Some(have) if have.values.iter().zip(&at).all(|(a, b)| a.is_nan() || b.is_nan()) => {
                    let missing = have.values.iter_mut().zip(at).filter(|(have, _)| have.is_nan());
                    missing.for_each(|(have, at)| *have = at);
                }
                Some(_) => {
                    all.push(Housekeeping { name: format!("{name} of \"{}\"", recording.id), values: at });
                }
                None => all.push(Housekeeping { name: name.clone(), values: at }),
            }
        }
    }
    all
}

/// A value between two neighbours in time; NaN beyond the ends.
fn between(known: &[(f64, f64)], t: f64) -> f64 {
    let after = known.partition_point(|(time, _)| *time < t);
    let Some((to, high)) = known.get(after).copied() else { return f64::NAN };
    if to == t {
        return high;
    }
    let Some((from, low)) = after.checked_sub(1).map(|before| known[before]) else { return f64::NAN };
    low + (high - low) * (t - from) / (to - from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_between_neighbours_and_nothing_beyond() {
        let known = [(0.0, 1.0), (2.0, 5.0)];
        assert_eq!([0.0, 1.0, 2.0].map(|t| between(&known, t)), [1.0, 3.0, 5.0]);
        assert!(between(&known, -1.0).is_nan() && between(&known, 2.1).is_nan());
    }

    #[test]
    fn the_ends_are_held_and_what_never_changes_is_none() {
        let of = |values: &[f64]| Housekeeping { name: "sensor_temperature_c".into(), values: values.into() };
        assert_eq!(of(&[f64::NAN, 2.0, 3.0, f64::NAN]).whole(), Some(vec![2.0, 2.0, 3.0, 3.0]));
        assert_eq!(of(&[f64::NAN, 2.0, 2.0]).whole(), None);
    }
}
