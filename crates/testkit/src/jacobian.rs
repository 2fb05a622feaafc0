/// Checks a Jacobian against central differences.
///
/// `predict` gives the predictions for a vector of unknowns; `columns` the derivatives to check, one
/// series for each unknown; `scales` a plausible change of each. Differences of two step sizes are
/// joined (Richardson), and each column must agree to `tolerance` of its largest entry.
pub fn check_jacobian(
    predict: impl Fn(&[f64]) -> Vec<f64>,
    at: &[f64],
    scales: &[f64],
    columns: &[Vec<f64>],
    tolerance: f64,
) {
    let difference = |unknown: usize, step: f64| -> Vec<f64> {
        let moved = |sign: f64| {
            let mut unknowns = at.to_vec();
            unknowns[unknown] += sign * step;
            predict(&unknowns)
        };
        moved(1.0).iter().zip(moved(-1.0)).map(|(plus, minus)| (plus - minus) / (2.0 * step)).collect()
    };
    for (unknown, column) in columns.iter().enumerate() {
        let coarse = difference(unknown, scales[unknown]);
        let fine = difference(unknown, scales[unknown] / 2.0);
        let largest = column.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        assert!(largest > 0.0, "unknown {unknown} changes nothing");
        for (row, analytic) in column.iter().enumerate() {
            let numeric = (4.0 * fine[row] - coarse[row]) / 3.0;
            assert!(
                (analytic - numeric).abs() <= tolerance * largest,
                "unknown {unknown}, row {row}: derivative {analytic:e}, by differences {numeric:e}"
            );
        }
    }
}
