//! A converter whose parts are not what they should be.

/// A converter that weighs a reading bit by bit. A bit of a wrong weight moves all codes that have it:
///
/// ```text
/// error = Σ_b e_b bit_b(code),   code = round(M / lsb) + half of the range
/// ```
///
/// in nT. Source: Kester (ed.) 2005, Data Conversion Handbook, section 3.2 (successive approximation).
#[derive(Clone, Debug)]
pub struct Weighing {
    /// Width of a code, nT.
    pub lsb_nt: f64,
    /// Number of the bit, from the least, and the error of its weight, nT.
    pub errors: Vec<(u32, f64)>,
}

/// Half of the range, codes.
const HALF: f64 = 8_388_608.0;

impl Weighing {
    /// What the converter adds to a reading, nT.
    pub fn error(&self, reading_nt: f64) -> f64 {
        let code = ((reading_nt / self.lsb_nt).round() + HALF).max(0.0) as u64;
        self.errors.iter().map(|(bit, error)| error * ((code >> bit) & 1) as f64).sum()
    }

    /// The field from one change of a bit to the next but one, nT.
    pub fn period(&self, bit: u32) -> f64 {
        self.lsb_nt * f64::from(2_u32 << bit)
    }
}

/// A converter with too few codes, each edge off by up to a share of the width: what it adds to a reading,
/// nT.
///
/// An edge's place follows from the number of its code, the same whenever the reading comes by.
pub fn coarse(reading_nt: f64, width_nt: f64, uneven: f64) -> f64 {
    let edge = |code: f64| {
        let phase = (code * 12.9898 + 0.5).sin() * 43_758.545;
        (code - 0.5 + uneven * (phase - phase.floor() - 0.5)) * width_nt
    };
    let mut code = (reading_nt / width_nt).round();
    if reading_nt < edge(code) {
        code -= 1.0;
    } else if reading_nt >= edge(code + 1.0) {
        code += 1.0;
    }
    code * width_nt - reading_nt
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_bit_is_a_square_wave_of_its_period() {
        let converter = Weighing { lsb_nt: 0.5, errors: vec![(12, 0.8)] };
        let period = converter.period(12);
        assert_eq!(period, 4096.0);
        for reading in [-9_000.25, 10.75, 1_999.0, 25_000.0] {
            assert_eq!(converter.error(reading), converter.error(reading + period));
            assert_ne!(converter.error(reading), converter.error(reading + period / 2.0));
        }
    }

    /// Even codes leave width/√12 rms, and never more than half a width.
    #[test]
    fn coarse_codes_leave_their_known_rms() {
        let readings = (0..40_000).map(|k| 0.0137 * f64::from(k));
        let errors: Vec<f64> = readings.map(|m| coarse(m, 1.5, 0.0)).collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        assert!((rms / (1.5 / 12.0_f64.sqrt()) - 1.0).abs() < 0.01, "{rms}");
        assert!(errors.iter().all(|e| e.abs() <= 0.75 + 1e-9));
        let uneven = (0..40_000).map(|k| coarse(0.0137 * f64::from(k), 1.5, 0.2));
        assert!(uneven.map(f64::abs).fold(0.0, f64::max) <= 0.75 + 0.15 + 1e-9);
    }
}
