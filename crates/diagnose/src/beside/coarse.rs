//! Readings that are whole numbers of coarse codes: what rounding to them leaves.

use common::{Axis, Document};

/// Readings take so few values, as a share of their number.
const FEW: f64 = 0.25;
/// Steps between these are whole numbers of the width within this share of it.
const WHOLE: f64 = 0.1;
/// Fewest values and codes.
const LEAST: usize = 3;

/// The width of the codes of each sensor whose readings a document holds in nT, where they are coarse.
pub fn widths(document: &Document) -> Vec<(Axis, f64)> {
    let of = |axis: Axis| {
        let names = [format!("test_{axis}_nt"), format!("sensor_{axis}_nt")];
        let columns = document.recordings.iter().flat_map(|r| names.iter().filter_map(|name| r.column(name)));
        let values: Vec<f64> = columns.flatten().copied().filter(|value| value.is_finite()).collect();
        Some((axis, width(values)?))
    };
    Axis::ALL.into_iter().filter_map(of).collect()
}

/// The width of which all differences of some values are whole numbers; None where they take too many.
fn width(mut values: Vec<f64>) -> Option<f64> {
    let count = values.len();
    values.sort_by(f64::total_cmp);
    values.dedup();
    if values.len() < LEAST || values.len() as f64 > FEW * count as f64 {
        return None;
    }
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let (mut above, mut below) = (0.0, 0.0);
    for step in &steps {
        let codes = (step / least).round();
        (above, below) = (above + codes * step, below + codes * codes);
    }
    let width = above / below;
    let is_whole = |step: &f64| (step / width - (step / width).round()).abs() < WHOLE;
    steps.iter().all(is_whole).then_some(width)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_those_of_the_codes() {
        let mut stream = noise::Stream::new(4, "coarse");
        let fine: Vec<f64> = (0..2000).map(|_| 3.0 * stream.normal()).collect();
        assert_eq!(width(fine.clone()), None);
        // Printed with two digits.
        let coarse = fine.iter().map(|x| (100.0 * 1.237 * (x / 1.237).round()).round() / 100.0).collect();
        let found = width(coarse).expect("codes");
        assert!((found - 1.237).abs() < 2e-3, "{found}");
    }
}
