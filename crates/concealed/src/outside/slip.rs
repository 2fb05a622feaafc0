//! Something that is held until it has been moved too far, and then lets go.

/// How far a course has gone from where it was last let go. It is let go at the first value, and wherever it
/// would be further away than `most`: there the departure is zero again.
///
/// Source: Bowden and Tabor 1950, The Friction and Lubrication of Solids (stick and slip).
pub fn departures(course: impl IntoIterator<Item = f64>, most: f64) -> Vec<f64> {
    let mut from = None;
    let next = |value: f64| {
        let away = value - *from.get_or_insert(value);
        if away.abs() > most {
            from = Some(value);
            return 0.0;
        }
        away
    };
    course.into_iter().map(next).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A steady motion is a sawtooth: of ten steps up to 1, then back to zero, with a mean of 1/2.
    #[test]
    fn a_steady_motion_is_a_sawtooth() {
        let teeth = departures((0..1100).map(|k| f64::from(k) / 10.0), 1.0 + 1e-9);
        for (k, tooth) in teeth.iter().enumerate() {
            assert!((tooth - (k % 11) as f64 / 10.0).abs() < 1e-9, "{k}: {tooth}");
        }
        assert!((teeth.iter().sum::<f64>() / 1100.0 - 0.5).abs() < 1e-9);
    }

    /// What moves by less is never let go.
    #[test]
    fn a_small_motion_is_followed() {
        let course: Vec<f64> = (0..50).map(|k| (f64::from(k) * 0.3).sin()).collect();
        assert_eq!(departures(course.clone(), 2.0), course);
    }
}
