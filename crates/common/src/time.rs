//! The clock of recordings: RFC 3339 in documents, seconds since 1970 in memory.

use jiff::civil::date;
use jiff::fmt::temporal::Pieces;
use jiff::tz::{Offset, TimeZone};
use jiff::{SignedDuration, Timestamp};

use crate::number::{signed, significant, uncertain};

/// A moment with the clock by which people there live.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Seconds since 1970-01-01T00:00:00Z.
    pub unix_s: f64,
    /// What the local clock is ahead of UTC, s.
    pub offset_s: f64,
}

impl Start {
    /// Reads RFC 3339, `2026-05-26T14:44:35Z` or with an offset, `2026-05-26T16:44:35+02:00`.
    pub fn parse(text: &str) -> Option<Self> {
        let timestamp: Timestamp = text.parse().ok()?;
        let offset = Pieces::parse(text).ok()?.to_numeric_offset()?;
        Some(Self { unix_s: timestamp.as_duration().as_secs_f64(), offset_s: f64::from(offset.seconds()) })
    }

    /// The same clock some seconds later.
    pub fn after(self, seconds: f64) -> Self {
        Self { unix_s: self.unix_s + seconds, ..self }
    }

    /// The year with its part that is over, UTC.
    pub fn year(self) -> Option<f64> {
        let moment = Timestamp::from_second(self.unix_s.floor() as i64).ok()?;
        let year = moment.to_zoned(TimeZone::UTC).year();
        let begins = |year: i16| Some(date(year, 1, 1).to_zoned(TimeZone::UTC).ok()?.timestamp().as_second());
        let (first, next) = (begins(year)? as f64, begins(year.checked_add(1)?)? as f64);
        Some(f64::from(year) + (self.unix_s - first) / (next - first))
    }

    /// Seconds since 1970 on the local clock.
    pub fn local_s(self) -> f64 {
        self.unix_s + self.offset_s
    }

    /// As RFC 3339, to the microsecond.
    pub fn text(self) -> Option<String> {
        let micros = SignedDuration::from_micros((self.unix_s * 1e6).round() as i64);
        let timestamp = Timestamp::from_duration(micros).ok()?;
        if self.offset_s == 0.0 {
            return Some(timestamp.to_string());
        }
        let offset = Offset::from_seconds(self.offset_s as i32).ok()?;
        let zoned = timestamp.to_zoned(TimeZone::fixed(offset));
        Some(timestamp.display_with_offset(zoned.offset()).to_string())
    }
}

/// Uncertainties below this share of a step are not told.
const LEAST: f64 = 1e-6;

/// What is said of times that jump: how much later they are from a moment on, beyond whole steps.
pub fn jumped(by_s: f64, std_s: f64, step_s: f64, at: &str) -> String {
    let size = if std_s > LEAST * step_s { uncertain(by_s, std_s) } else { significant(by_s, 3) };
    let share = significant(100.0 * (by_s / step_s).abs(), 2);
    format!(
        "the times jump by {} s at {at}, {share} % of a step; the clock was set, or the recording began anew",
        signed(&size)
    )
}

const DAY_S: f64 = 86_400.0;

/// The hour of the day, 0 to 24, of a local time.
pub fn hour_of_day(local_s: f64) -> f64 {
    local_s.rem_euclid(DAY_S) / 3600.0
}

/// Whether a local time is on Monday to Friday. 1970-01-01 was a Thursday.
pub fn is_weekday(local_s: f64) -> bool {
    day_of_week(local_s) < 5
}

/// Day of the week of a local time, 0 = Monday.
pub fn day_of_week(local_s: f64) -> u8 {
    ((local_s / DAY_S).floor() + 3.0).rem_euclid(7.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_come_and_go() {
        let start = Start::parse("1977-05-26T14:44:35Z").expect("a moment");
        assert_eq!((start.unix_s, start.offset_s), (233_505_875.0, 0.0));
        assert_eq!(start.text().as_deref(), Some("1977-05-26T14:44:35Z"));
        let local = Start::parse("2026-05-26T01:30:00+02:00").expect("a moment");
        assert_eq!(local.text().as_deref(), Some("2026-05-26T01:30:00+02:00"));
        assert_eq!(local.after(0.5).text().as_deref(), Some("2026-05-26T01:30:00.5+02:00"));
        // A Tuesday on the local clock, and still Monday in Greenwich.
        assert_eq!((day_of_week(local.local_s()), day_of_week(local.unix_s)), (1, 0));
        assert_eq!(hour_of_day(local.local_s()), 1.5);
        for wrong in ["yesterday", "1977-05-26", "1977-05-26T14:44:35"] {
            assert_eq!(Start::parse(wrong), None, "{wrong}");
        }
    }
}
