//! Where the times of a series jump.

use common::time::jumped;
use estimate::cadence::Cadence;
use serde::Serialize;

use crate::clock::{self, Clock, SECOND_NS};
use crate::series::{Series, even_step_ns};

const LISTED: usize = 20;

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Jump {
    pub after_s: f64,
    /// The first row after it, from 0.
    pub row: usize,
    /// How much later the times are from there on, beyond whole steps, s.
    pub by_s: f64,
}

/// The jumps of a series, with what is said of each.
pub fn jumps(series: &Series, begin_ns: i64) -> Vec<(Jump, String)> {
    let times: Vec<f64> = match series.times_ns.first() {
        Some(first) if series.clock != Clock::None && even_step_ns(&series.times_ns).is_none() => {
            series.times_ns.iter().map(|time| (time - first) as f64 / SECOND_NS as f64).collect()
        }
        _ => Vec::new(),
    };
    let Some(cadence) = Cadence::of(&times) else { return Vec::new() };
    let of = |jump: &estimate::cadence::Jump| {
        let after_s = (series.times_ns[jump.row - 1] - begin_ns) as f64 / SECOND_NS as f64;
        let at = match series.clock {
            Clock::Utc => clock::text(series.times_ns[jump.row]),
            _ => format!("{} s", common::number::bare(after_s + jump.interval_s)),
        };
        let words = jumped(jump.by_s, jump.std_s, cadence.step_s, &at);
        (Jump { after_s, row: jump.row, by_s: jump.by_s }, words)
    };
    cadence.jumps.iter().take(LISTED).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use indexmap::IndexMap;

    #[test]
    fn a_jump_is_said_with_place_and_size() {
        let times_ns = (0..300).map(|row| row * SECOND_NS + if row < 120 { 0 } else { SECOND_NS * 3 / 10 });
        let (times_ns, columns) = (times_ns.collect(), IndexMap::new());
        let series = Series { clock: Clock::Utc, times_ns, columns, merged: 0, disagreeing: 0, sorted: 0 };
        let found = jumps(&series, 0);
        assert_eq!(found.len(), 1);
        let (jump, words) = &found[0];
        assert_eq!((jump.row, jump.after_s), (120, 119.0));
        assert!((jump.by_s - 0.3).abs() < 1e-9);
        assert_eq!(
            words,
            "the times jump by +0.3 s at 1970-01-01T00:02:00.3Z, 30 % of a step; the clock was set, or the recording began anew"
        );
    }
}
