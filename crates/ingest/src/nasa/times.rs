//! Times of a CDF as nanoseconds since 1970-01-01T00:00:00 UTC, in which a leap second has no number of its
//! own: 23:59:60.5 is as 00:00:00.5.

const SECOND: i64 = 1_000_000_000;
/// J2000, 2000-01-01T12:00:00, as a clock would show it.
const J2000: i64 = 946_728_000 * SECOND;
/// TT − TAI.
const TT_TAI: i64 = 32_184_000_000;
/// The year 0 before 1970, s.
const YEAR_0_S: f64 = 62_167_219_200.0;

/// Days since 1970 from which TAI − UTC is one second more, 10 s from the first of them.
///
/// Source: Bulletin C of the IERS.
const LEAPS: [i64; 28] = [
    730, 912, 1096, 1461, 1826, 2191, 2557, 2922, 3287, 3652, 4199, 4564, 4929, 5660, 6574, 7305, 7670, 8217,
    8582, 8947, 9496, 10043, 10592, 13149, 14245, 15522, 16617, 17167,
];

/// When a difference of TAI and UTC begins, s since 1970, and how large it is, s.
fn leap(number: usize) -> (i64, i64) {
    (LEAPS[number] * 86_400, 10 + number as i64)
}

/// Of TT2000; None for its fill and pad values and before 1972.
pub fn of_tt2000(tt2000: i64) -> Option<i64> {
    if tt2000 <= i64::MIN + 1 {
        return None;
    }
    let tai = tt2000.checked_add(J2000 - TT_TAI)?;
    // The leap second itself lies before the day from which the new difference holds, by one second of TAI.
    let mut leaps = (0..LEAPS.len()).rev().map(leap);
    let (from, ahead) = leaps.find(|(from, ahead)| tai >= (from + ahead - 1) * SECOND)?;
    let utc = tai - ahead * SECOND;
    // Within the leap second: as the first second of the day.
    Some(if utc < from * SECOND && ahead > 10 { utc + SECOND } else { utc })
}

/// TT2000 of nanoseconds since 1970, UTC; None before 1972.
pub fn tt2000(ns: i64) -> Option<i64> {
    let mut leaps = (0..LEAPS.len()).rev().map(leap);
    let (_, ahead) = leaps.find(|(from, _)| ns >= from * SECOND)?;
    Some(ns - J2000 + TT_TAI + ahead * SECOND)
}

/// Since when the table of leap seconds is as it is, as a CDF writes the date.
pub const LAST_LEAP: u32 = 20_170_101;

/// Of EPOCH, ms since the year 0, to the microsecond; None for fill values.
pub fn of_epoch(epoch_ms: f64) -> Option<i64> {
    let micros = ((epoch_ms - YEAR_0_S * 1e3) * 1e3).round();
    (epoch_ms > 0.0 && micros.abs() < 9.2e15).then(|| micros as i64 * 1000)
}

/// Of EPOCH16, s since the year 0 and ps.
pub fn of_epoch16(seconds: f64, picos: f64) -> Option<i64> {
    let whole = seconds - YEAR_0_S;
    let good = seconds > 0.0 && whole.abs() < 9.2e9 && (0.0..1e12).contains(&picos);
    good.then(|| whole as i64 * SECOND + (picos / 1e3).round() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leap_seconds() {
        // 2016-12-31T23:59:59, 23:59:60 and 2017-01-01T00:00:00 as cdflib.cdfepoch.compute_tt2000 gives them.
        assert_eq!(of_tt2000(536_500_867_184_000_000), Some(1_483_228_799 * SECOND));
        assert_eq!(of_tt2000(536_500_868_684_000_000), Some(1_483_228_800 * SECOND + SECOND / 2));
        assert_eq!(of_tt2000(536_500_869_184_000_000), Some(1_483_228_800 * SECOND));
        // J2000 itself: 64.184 s before noon of a clock in UTC.
        assert_eq!(of_tt2000(0), Some(946_727_935_816_000_000));
        assert_eq!([i64::MIN, i64::MIN + 1, -900_000_000 * SECOND].map(of_tt2000), [None; 3]);
        assert_eq!(leap(27), (1_483_228_800, 37));
        for number in 0..LEAPS.len() {
            let ns = leap(number).0 * SECOND;
            assert_eq!(tt2000(ns).and_then(of_tt2000), Some(ns), "{number}");
        }
        assert_eq!(tt2000(1_483_228_799 * SECOND), Some(536_500_867_184_000_000));
        assert_eq!((tt2000(946_727_935_816_000_000), tt2000(63_072_000 * SECOND - 1)), (Some(0), None));
    }

    #[test]
    fn milliseconds_since_the_year_0() {
        assert_eq!(of_epoch(62_167_219_200_000.0), Some(0));
        assert_eq!(of_epoch(63_897_638_400_250.0), Some(1_730_419_200_250_000_000));
        assert_eq!((of_epoch(-1e31), of_epoch(0.0), of_epoch(f64::NAN)), (None, None, None));
        assert_eq!(of_epoch16(62_167_219_201.0, 5e11), Some(SECOND + SECOND / 2));
    }
}
