//! Times of a CDF: nanoseconds of terrestrial time since J2000, in which leap seconds count.

use super::SECOND_NS;

/// J2000, 2000-01-01T12:00:00, as a clock would show it, since 1970.
const J2000: i64 = 946_728_000 * SECOND_NS;
/// TT − TAI.
const TT_TAI: i64 = 32_184_000_000;
/// TAI − UTC before the first leap second, s, from 1972-01-01 on.
const FIRST_S: i64 = 10;
/// Since when the table of leap seconds is as it is, as a CDF writes it.
pub const LAST_LEAP: u32 = 20_170_101;
/// What stands for no time.
pub const NONE: i64 = i64::MIN;

/// Days since 1970 on which TAI − UTC became one second more, after 1972-01-01, which is the first of them.
///
/// Source: Bulletin C of the IERS.
const LEAPS: [i64; 28] = [
    730, 912, 1096, 1461, 1826, 2191, 2557, 2922, 3287, 3652, 4199, 4564, 4929, 5660, 6574, 7305, 7670, 8217,
    8582, 8947, 9496, 10_043, 10_592, 13_149, 14_245, 15_522, 16_617, 17_167,
];

/// Of nanoseconds since 1970, UTC; None before 1972.
pub fn of_utc(ns: i64) -> Option<i64> {
    let day = ns.div_euclid(86_400 * SECOND_NS);
    let begun = LEAPS.iter().filter(|from| **from <= day).count() as i64;
    (begun > 0).then(|| ns - J2000 + TT_TAI + (FIRST_S + begun - 1) * SECOND_NS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_cdflib_computes_them() {
        // cdflib.cdfepoch.compute_tt2000 of 2016-12-31T23:59:59, 2017-01-01, J2000 less 64.184 s, and 1972-01-01.
        let due = [
            (1_483_228_799, Some(536_500_867_184_000_000)),
            (1_483_228_800, Some(536_500_869_184_000_000)),
            (63_072_000, Some(-883_655_957_816_000_000)),
            (63_071_999, None),
        ];
        for (unix_s, tt2000) in due {
            assert_eq!(of_utc(unix_s * SECOND_NS), tt2000, "{unix_s}");
        }
        assert_eq!(of_utc(946_727_935_816_000_000), Some(0));
    }
}
