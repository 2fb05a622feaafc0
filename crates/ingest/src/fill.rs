//! Values that stand for missing ones without the file's saying so.

/// How many values of a column stood for missing ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fill {
    /// 99999 of IAGA-2002, ±1e31 of CDF.
    pub missing: usize,
    /// 88888 of IAGA-2002.
    pub not_observed: usize,
}

/// Makes 99999 (missing) and 88888 (not observed) of a field in nT missing, whatever the decimals: files
/// write .00, .90 and .99, and no field on Earth is so strong; and ±1e31, CDF's, of any column.
pub fn without(values: &mut [f64], is_field: bool) -> Fill {
    let mut fill = Fill::default();
    for value in values {
        let count = match value.abs().trunc() {
            88_888.0 | 888_888.0 if is_field => &mut fill.not_observed,
            99_999.0 | 999_999.0 if is_field => &mut fill.missing,
            // A file in single precision has 1e31 to seven digits.
            size if (size / 1e31 - 1.0).abs() < 1e-6 => &mut fill.missing,
            _ => continue,
        };
        *count += 1;
        *value = f64::NAN;
    }
    fill
}

#[cfg(test)]
mod tests {
    use super::{Fill, without};

    #[test]
    fn what_stands_for_missing() {
        let readings = [48_520.3, 50_000.0, 1.0];
        let [missing, not_observed] = [[99_999.0, 99_999.9, -99_999.99], [88_888.0, -88_888.88, 888_888.0]];
        let cdf = [-1e31, f64::from(1e31_f32)];
        let mut values = [&missing[..], &not_observed, &cdf, &readings].concat();
        assert_eq!(without(&mut values, true), Fill { missing: 5, not_observed: 3 });
        assert!(values[..8].iter().all(|value| value.is_nan()));
        assert_eq!(values[8..], readings);
        let mut seconds = [99_999.0, -1e31];
        assert_eq!(without(&mut seconds, false), Fill { missing: 1, not_observed: 0 });
        assert_eq!(seconds[0], 99_999.0);
    }
}
