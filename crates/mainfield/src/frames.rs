//! Frames of the Earth: north, east and down at a place (geodetic), fixed to the Earth (ITRF), and celestial (ICRF).

use nalgebra::Matrix3;

/// Julian date of 1970-01-01T00:00:00Z.
const UNIX_EPOCH: f64 = 2_440_587.5;
const DAY_S: f64 = 86_400.0;
/// TT less TAI, s.
const TT_TAI_S: f64 = 32.184;
/// The matrix of precession and nutation is that of the nearest multiple of this: it moves by less than 0.01″ in it.
const KEPT_S: f64 = 3600.0;

/// Turns a vector from ITRF to north, east and down at a geodetic latitude and a longitude, rad.
pub fn itrf_to_geo(latitude: f64, longitude: f64) -> Matrix3<f64> {
    let ((sin_lat, cos_lat), (sin_lon, cos_lon)) = (latitude.sin_cos(), longitude.sin_cos());
    Matrix3::new(
        -sin_lat * cos_lon,
        -sin_lat * sin_lon,
        cos_lat,
        -sin_lon,
        cos_lon,
        0.0,
        -cos_lat * cos_lon,
        -cos_lat * sin_lon,
        -sin_lat,
    )
}

/// The Earth's rotation, by IAU 2006/2000A and the Earth rotation angle; the motion of the pole, 0.3″, is left out.
///
/// Source: SOFA, IAU 2006/2000A (`c2i06a`, `era00`, `dat`).
#[derive(Clone, Debug, Default)]
pub struct Celestial {
    /// UT1 less UTC, s: at most 0.9 s, of which each is 15″.
    pub ut1_utc_s: f64,
    hour: Option<(i64, Matrix3<f64>)>,
}

impl Celestial {
    /// With a stated difference of UT1 and UTC, s.
    pub fn new(ut1_utc_s: f64) -> Self {
        Self { ut1_utc_s, hour: None }
    }

    /// From ICRF to ITRF at a time, s of UTC since 1970. None before 1972: no leap seconds.
    pub fn to_earth(&mut self, unix_s: f64) -> Option<Matrix3<f64>> {
        let hour = (unix_s / KEPT_S).round() as i64;
        let intermediate = match self.hour {
            Some((kept, matrix)) if kept == hour => matrix,
            _ => {
                let matrix = intermediate(hour as f64 * KEPT_S)?;
                self.hour = Some((hour, matrix));
                matrix
            }
        };
        let days = (unix_s / DAY_S).floor();
        let since = (unix_s - days * DAY_S + self.ut1_utc_s) / DAY_S;
        let (sin, cos) = sofars::erst::era00(UNIX_EPOCH + days, since).sin_cos();
        Some(Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0) * intermediate)
    }
}

/// TAI less UTC, s, at a time in s of UTC since 1970. None before 1972, where there were no leap seconds.
pub fn leap_s(unix_s: f64) -> Option<f64> {
    let (year, month, day, share) = sofars::cal::jd2cal(UNIX_EPOCH + (unix_s / DAY_S).floor(), 0.0).ok()?;
    sofars::ts::dat(year, month, day, share).ok().filter(|_| unix_s >= 2.0 * 365.0 * DAY_S)
}

/// From ICRF to the celestial intermediate frame.
fn intermediate(unix_s: f64) -> Option<Matrix3<f64>> {
    let days = (unix_s / DAY_S).floor();
    let leap_s = leap_s(unix_s)?;
    let since = (unix_s - days * DAY_S + leap_s + TT_TAI_S) / DAY_S;
    let rows = sofars::pnp::c2i06a(UNIX_EPOCH + days, since);
    Some(Matrix3::from_fn(|i, j| rows[i][j]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn geo_is_north_east_down() {
        let (latitude, longitude) = (0.7, 2.1_f64);
        let turn = itrf_to_geo(latitude, longitude);
        let up = nalgebra::Vector3::new(
            latitude.cos() * longitude.cos(),
            latitude.cos() * longitude.sin(),
            latitude.sin(),
        );
        assert!((turn * up - nalgebra::Vector3::new(0.0, 0.0, -1.0)).norm() < 1e-15);
        assert!((turn * nalgebra::Vector3::z()).y.abs() < 1e-15 && (turn * nalgebra::Vector3::z()).x > 0.0);
        assert!((turn.determinant() - 1.0).abs() < 1e-14);
    }

    /// Rows of matrices from ICRF to ITRF made by fixtures/reference/earth_erfa.py.
    #[test]
    fn the_earth_turns_as_by_another_program() {
        let other = [
            (
                [1_175_774_400.0, -0.072_073_685],
                [
                    [0.973_104_317_577_440, 0.230_363_826_231_240, -0.000_703_332_245_535],
                    [-0.230_363_798_788_586, 0.973_104_570_739_422, 0.000_120_887_288_390],
                ],
            ),
            (
                [1_735_689_600.25, 0.04],
                [
                    [-0.183_615_297_486_795, 0.982_998_093_851_491, 0.000_412_326_533_665],
                    [-0.982_995_177_793_886, -0.183_615_757_229_511, 0.002_394_604_560_275],
                ],
            ),
            (
                [457_401_600.0, 0.7],
                [
                    [0.146_917_600_051_223, -0.989_148_705_586_267, 0.000_238_814_157_150],
                    [0.989_147_542_370_737, 0.146_917_793_540_903, 0.001_517_024_391_252],
                ],
            ),
        ];
        for ([unix_s, ut1_utc_s], rows) in other {
            let found = Celestial::new(ut1_utc_s).to_earth(unix_s).expect("after 1972");
            for (i, row) in rows.iter().enumerate() {
                for (j, expected) in row.iter().enumerate() {
                    // 0.01 arcsec: the matrix of precession and nutation is that of the hour.
                    assert!(
                        (found[(i, j)] - expected).abs() < 5e-8,
                        "{unix_s} {i} {j}: {} {expected}",
                        found[(i, j)]
                    );
                }
            }
        }
        assert!(Celestial::default().to_earth(0.0).is_none());
    }
}
