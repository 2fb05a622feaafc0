//! Moments as files write them, in nanoseconds since 1970-01-01T00:00:00Z (1677 to 2262), so that none is
//! rounded on its way.

use jiff::civil::Date;
use jiff::tz::TimeZone;
use jiff::{SignedDuration, Timestamp};

pub const SECOND_NS: i64 = 1_000_000_000;
pub const DAY_NS: i64 = 86_400 * SECOND_NS;

/// What a piece's times count from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// 1970-01-01T00:00:00Z.
    Utc,
    /// The campaign's beginning, or whatever the file's own clock began with.
    Campaign,
    /// There are no times; rows are in the order taken.
    None,
}

/// A moment as written: what the clock shows, and what it is ahead of UTC where that is said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamp {
    /// As if the clock were in UTC, ns since 1970.
    pub clock_ns: i64,
    /// What it is ahead, s.
    pub ahead_s: Option<i64>,
}

/// Whose clock a file's times are on.
#[derive(Clone, Debug)]
pub enum Zone {
    /// A clock so many seconds ahead of UTC.
    Fixed(i64),
    /// A clock that is put forward and back.
    Named(TimeZone),
}

impl Zone {
    /// `UTC`, `Z`, `+02:00`, or a name of the IANA data base such as `Europe/Vienna`.
    pub fn parse(text: &str) -> Option<Self> {
        if matches!(text, "UTC" | "utc" | "Z" | "GMT") {
            return Some(Zone::Fixed(0));
        }
        if let Some(ahead_s) = offset(text.as_bytes()) {
            return Some(Zone::Fixed(ahead_s));
        }
        TimeZone::get(text).ok().map(Zone::Named)
    }

    /// A moment in UTC, ns since 1970; what is expected where that clock did not show it, or showed it twice.
    #[inline]
    pub fn moment(&self, stamp: Stamp) -> Result<i64, String> {
        let too_far = || "a time of the years 1677 to 2262".to_string();
        let ahead_s = match (stamp.ahead_s, self) {
            (Some(ahead_s), _) => ahead_s,
            (None, Zone::Fixed(ahead_s)) => *ahead_s,
            (None, Zone::Named(zone)) => {
                let clock = Timestamp::from_duration(SignedDuration::from_nanos(stamp.clock_ns))
                    .map_err(|_| too_far())?;
                let clock = TimeZone::UTC.to_datetime(clock);
                let moment = zone.to_ambiguous_timestamp(clock).unambiguous().map_err(|_| {
                    "a time that the clock showed once; where summer time begins or ends, say what it was ahead of UTC, as in \
                     \"zone\": \"+02:00\""
                        .to_string()
                })?;
                return i64::try_from(moment.as_nanosecond()).map_err(|_| too_far());
            }
        };
        stamp.clock_ns.checked_sub(ahead_s * SECOND_NS).ok_or_else(too_far)
    }
}

/// `+02:00`, `-0530`, `+01`, in seconds.
fn offset(text: &[u8]) -> Option<i64> {
    let (sign, rest) = match text {
        [b'+', rest @ ..] => (1, rest),
        [b'-', rest @ ..] => (-1, rest),
        _ => return None,
    };
    let (hours, minutes) = match rest {
        [h, i] => (digits(&[*h, *i])?, 0),
        [h, i, m, n] | [h, i, b':', m, n] => (digits(&[*h, *i])?, digits(&[*m, *n])?),
        _ => return None,
    };
    (hours < 24 && minutes < 60).then_some(sign * (3600 * hours + 60 * minutes))
}

/// A whole number without sign.
#[inline(always)]
fn digits(text: &[u8]) -> Option<i64> {
    let (mut sum, mut good) = (0_i64, true);
    for byte in text {
        let digit = byte.wrapping_sub(b'0');
        good &= digit < 10;
        sum = 10 * sum + i64::from(digit);
    }
    good.then_some(sum)
}

/// Days since 1970-01-01 of a date of the Gregorian calendar; None for one that is not.
#[inline]
pub fn day(year: i64, month: i64, day: i64) -> Option<i64> {
    let date = Date::new(year.try_into().ok()?, month.try_into().ok()?, day.try_into().ok()?).ok()?;
    let since = date.duration_since(Date::constant(1970, 1, 1));
    (1678..=2261).contains(&year).then_some(since.as_hours() / 24)
}

/// `2014-11-01` (or with `/`): the day since 1970 and the year.
#[inline]
pub fn date(text: &[u8]) -> Option<(i64, i64)> {
    let [y, e, a, r, mark, m, n, again, d, f] = *text.first_chunk::<10>()?;
    if mark != again || !matches!(mark, b'-' | b'/') {
        return None;
    }
    let year = digits(&[y, e, a, r])?;
    Some((day(year, digits(&[m, n])?, digits(&[d, f])?)?, year))
}

/// `23:59`, `23:59:47` or `23:59:47.000`: nanoseconds of the day, and the length of the text.
#[inline]
pub fn time_of_day(text: &[u8]) -> Option<(i64, usize)> {
    let [h, i, b':', m, n] = *text.first_chunk::<5>()? else { return None };
    let (hour, minute) = (digits(&[h, i])?, digits(&[m, n])?);
    let (mut second, mut fraction, mut at) = (0, 0, 5);
    if let [b':', s, t, ..] = text[5..] {
        second = digits(&[s, t])?;
        at = 8;
        if matches!(text.get(8), Some(b'.' | b',')) {
            let end =
                text[9..].iter().position(|byte| !byte.is_ascii_digit()).map_or(text.len(), |end| 9 + end);
            let shown = &text[9..end.min(18)];
            fraction = digits(shown)? * 10_i64.pow(9 - shown.len() as u32);
            at = end;
        }
    }
    (hour < 24 && minute < 60 && second < 60)
        .then_some(((3600 * hour + 60 * minute + second) * SECOND_NS + fraction, at))
}

/// ISO 8601 with the date in full: `2014-11-01`, `2014-11-01T00:00:00Z`, `2014-11-01 00:00:00.25+01:00`.
#[inline]
pub fn iso(text: &[u8]) -> Option<Stamp> {
    let (day, _) = date(text)?;
    let rest = &text[10..];
    let (clock_ns, rest) = match rest {
        [] => (0, rest),
        [b'T' | b't' | b' ', rest @ ..] => {
            let (ns, end) = time_of_day(rest)?;
            (ns, rest[end..].trim_ascii())
        }
        _ => return None,
    };
    let ahead_s = match rest {
        [] => None,
        [b'Z' | b'z'] | b"UTC" => Some(0),
        _ => Some(offset(rest)?),
    };
    Some(Stamp { clock_ns: day * DAY_NS + clock_ns, ahead_s })
}

/// A decimal number of units of `unit_ns` (a power of ten), in ns and exact; digits below a nanosecond are
/// dropped.
#[inline]
pub fn decimal(text: &[u8], unit_ns: i64, point: u8) -> Option<i64> {
    let (negative, rest) = match text {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        rest => (false, rest),
    };
    if rest.is_empty() || rest.len() > 40 {
        return None;
    }
    let (mut sum, mut scale, mut after) = (0_i64, unit_ns, false);
    for byte in rest {
        let digit = byte.wrapping_sub(b'0');
        match (digit < 10, after) {
            (true, false) => sum = sum.checked_mul(10)?.checked_add(i64::from(digit))?,
            (true, true) if scale >= 10 => {
                sum = sum.checked_mul(10)?.checked_add(i64::from(digit))?;
                scale /= 10;
            }
            (true, true) => {}
            (false, false) if *byte == point => after = true,
            // 1.47819E+18 and the like: as a number of double precision.
            _ => {
                let ns = float(text, point)? * unit_ns as f64;
                return (ns.abs() < i64::MAX as f64).then_some(ns.round() as i64);
            }
        }
    }
    let ns = sum.checked_mul(scale)?;
    Some(if negative { -ns } else { ns })
}

/// A number of double precision with that decimal mark, or a point.
pub fn float(text: &[u8], point: u8) -> Option<f64> {
    let text: Vec<u8> = text.iter().map(|byte| if *byte == point { b'.' } else { *byte }).collect();
    fast_float2::parse::<f64, _>(&text).ok()
}

/// Days and their parts since a day that is `epoch` days from 1970, ns, to the microsecond: a day's part has
/// no finer digits.
pub fn days(value: f64, epoch: f64) -> Option<i64> {
    let micros = (value - epoch) * 86_400e6;
    (micros.abs() < 9e15).then(|| micros.round() as i64 * 1000)
}

/// As RFC 3339 in UTC, with the digits that it needs.
pub fn text(ns: i64) -> String {
    let moment = Timestamp::from_duration(SignedDuration::from_nanos(ns));
    moment.map_or_else(|_| format!("{ns} ns"), |moment| moment.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_as_files_write_them() {
        let of = |text: &str| iso(text.as_bytes()).map(|stamp| Zone::Fixed(0).moment(stamp).map(super::text));
        for (written, moment) in [
            ("2014-11-01T00:00:00Z", "2014-11-01T00:00:00Z"),
            ("2014/11/01 00:01:02.500", "2014-11-01T00:01:02.5Z"),
            ("2014-11-01 01:30+02:00", "2014-10-31T23:30:00Z"),
            ("2014-11-01", "2014-11-01T00:00:00Z"),
        ] {
            assert_eq!(of(written), Some(Ok(moment.into())));
        }
        for wrong in [
            "2014-02-29",
            "2014-11-31T00:00:00",
            "2014-11-01T24:00:00",
            "2014-11-01T00:00:00x",
            "",
            "01.11.2014",
        ] {
            assert_eq!(of(wrong), None, "{wrong}");
        }
        for (written, unit_ns, point, ns) in [
            ("1565373905.343299", SECOND_NS, b'.', Some(1_565_373_905_343_299_000)),
            ("-0,5", SECOND_NS, b',', Some(-500_000_000)),
            ("1776444516214968300", 1, b'.', Some(1_776_444_516_214_968_300)),
            ("1.5E+3", SECOND_NS, b'.', Some(1_500_000_000_000)),
            ("12x", SECOND_NS, b'.', None),
        ] {
            assert_eq!(decimal(written.as_bytes(), unit_ns, point), ns);
        }
        // As Excel and as MATLAB count.
        for (value, epoch) in [(45_422.5, 25_569.0), (739_382.5, 719_529.0)] {
            assert_eq!(days(value, epoch).map(super::text).as_deref(), Some("2024-05-10T12:00:00Z"));
        }
    }

    #[test]
    fn a_clock_that_is_put_forward_and_back() {
        let vienna = Zone::parse("Europe/Vienna").expect("a zone");
        let at = |text: &str| vienna.moment(iso(text.as_bytes()).expect("a stamp")).map(super::text);
        assert_eq!(at("2011-09-01T02:00:00").as_deref(), Ok("2011-09-01T00:00:00Z"));
        assert_eq!(at("2011-12-01T01:00:00").as_deref(), Ok("2011-12-01T00:00:00Z"));
        assert!(at("2011-10-30T02:30:00").expect_err("twice").contains("showed once"));
        assert!(at("2011-03-27T02:30:00").is_err());
        // An offset that is written counts.
        assert_eq!(at("2011-10-30T02:30:00+01:00").as_deref(), Ok("2011-10-30T01:30:00Z"));
        assert!(Zone::parse("Europe/Atlantis").is_none());
    }
}
