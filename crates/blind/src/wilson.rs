//! Shares with their intervals.

/// Successes of trials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Share {
    /// Successes.
    pub hits: usize,
    /// Trials.
    pub trials: usize,
}

impl Share {
    /// Of those that count, how many are so.
    pub fn of<T>(all: impl IntoIterator<Item = T>, so: impl Fn(&T) -> bool) -> Self {
        let (mut hits, mut trials) = (0, 0);
        for one in all {
            trials += 1;
            hits += usize::from(so(&one));
        }
        Self { hits, trials }
    }

    /// As a number; not a number where there are no trials.
    pub fn value(self) -> f64 {
        self.hits as f64 / self.trials as f64
    }

    /// The 95 % interval. Source: Wilson 1927, Probable inference, the law of succession, and statistical
    /// inference, JASA 22, 209.
    pub fn interval(self) -> [f64; 2] {
        let (n, p, z) = (self.trials as f64, self.value(), 1.959964_f64);
        let middle = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
        let half = z * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt() / (1.0 + z * z / n);
        [(middle - half).max(0.0), (middle + half).min(1.0)]
    }

    /// `12 of 14, 86 % (60 to 96)`.
    pub fn words(self) -> String {
        if self.trials == 0 {
            return "none".into();
        }
        let [low, high] = self.interval();
        let percent = |share: f64| {
            let percent = 100.0 * share;
            if (percent > 0.0 && percent < 10.0) || (percent > 99.0 && percent < 100.0) {
                format!("{percent:.1}")
            } else {
                format!("{percent:.0}")
            }
        };
        let (value, low, high) = (percent(self.value()), percent(low), percent(high));
        format!("{} of {}, {value} % ({low} to {high})", self.hits, self.trials)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hand-worked: 8 of 10 gives 0.490 to 0.943, 0 of 20 gives 0 to 0.161.
    #[test]
    fn known_intervals() {
        let [low, high] = Share { hits: 8, trials: 10 }.interval();
        assert!((low - 0.4902).abs() < 1e-4 && (high - 0.9433).abs() < 1e-4, "{low} {high}");
        let [low, high] = Share { hits: 0, trials: 20 }.interval();
        assert!(low == 0.0 && (high - 0.1611).abs() < 1e-4, "{low} {high}");
    }
}
