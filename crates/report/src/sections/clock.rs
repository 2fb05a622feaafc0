//! Times in a unit that suits them.

/// A unit of time.
pub struct Clock {
    /// Its name.
    pub unit: &'static str,
    seconds: f64,
}

impl Clock {
    /// Seconds, hours beyond four of them, days beyond four of those.
    pub fn of(times_s: &[f64]) -> Self {
        let ends = times_s.iter().filter(|time| time.is_finite()).map(|time| [*time, *time]);
        let span = ends.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]).map_or(0.0, |[low, high]| high - low);
        let (unit, seconds) = match span / 3600.0 {
            hours if hours > 96.0 => ("days", 86_400.0),
            hours if hours > 4.0 => ("h", 3600.0),
            _ => ("s", 1.0),
        };
        Self { unit, seconds }
    }

    /// Times in this unit.
    pub fn times(&self, times_s: &[f64]) -> Vec<f64> {
        times_s.iter().map(|time| time / self.seconds).collect()
    }
}
