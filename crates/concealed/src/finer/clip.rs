//! An amplifier that ends at a level.

/// Reading of an amplifier whose output ends at ± a level, its edge rounded over a width, all in nT:
///
/// ```text
/// y = M − w ln(1 + exp((M − L)/w)) + w ln(1 + exp((−M − L)/w))
/// ```
///
/// Within the level nothing changes, beyond it the reading stays there, and at it the slope is a half. A
/// transistor that is driven into saturation goes so with its exponential law; Sedra and Smith,
/// Microelectronic Circuits.
pub fn clipped(reading_nt: f64, level_nt: f64, width_nt: f64) -> f64 {
    let over = |x: f64| {
        // ln(1 + exp(x)) without overflow.
        let x = x / width_nt;
        width_nt * (x.max(0.0) + (-x.abs()).exp().ln_1p())
    };
    reading_nt - over(reading_nt - level_nt) + over(-reading_nt - level_nt)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn within_it_reads_and_beyond_it_stays() {
        let of = |m: f64| clipped(m, 40_000.0, 10.0);
        assert!((of(39_000.0) - 39_000.0).abs() < 1e-9 && (of(-5.0) + 5.0).abs() < 1e-9);
        assert!((of(70_000.0) - 40_000.0).abs() < 1e-6 && (of(-70_000.0) + 40_000.0).abs() < 1e-6);
        assert!((of(40_000.0) - (40_000.0 - 10.0 * 2.0_f64.ln())).abs() < 1e-6);
        assert!((of(40_001.0) - of(39_999.0) - 1.0).abs() < 1e-3);
    }
}
