//! Matched filters: what a departure in each row would look like in the whitened residual, for all rows at once.

use fourier::{Complex, Planner};
use std::cell::RefCell;

thread_local! {
    /// Plans are kept: the same few lengths come again and again.
    static PLANNER: RefCell<Planner> = RefCell::new(Planner::new());
}

/// Σ_i series[j+i] template[i] for every row j, zero beyond the end.
pub fn correlate(series: &[f64], template: &[f64]) -> Vec<f64> {
    if let [only] = template {
        return series.iter().map(|value| value * only).collect();
    }
    let points = (series.len() + template.len()).next_power_of_two();
    let forward = PLANNER.with_borrow_mut(|planner| planner.forward(points));
    let spectrum = |values: &[f64]| {
        let mut padded = forward.make_input_vec();
        padded[..values.len()].copy_from_slice(values);
        let mut found = forward.make_output_vec();
        // The lengths are the planner's own.
        let _ = forward.process(&mut padded, &mut found);
        found
    };
    let mut product: Vec<Complex<f64>> =
        spectrum(series).iter().zip(spectrum(template)).map(|(a, b)| a * b.conj() / points as f64).collect();
    let inverse = PLANNER.with_borrow_mut(|planner| planner.inverse(points));
    let mut found = inverse.make_output_vec();
    let _ = inverse.process(&mut product, &mut found);
    found.truncate(series.len());
    found
}

/// |Σ y e^(2πi ν x)|² over ν = k/(points·cell), k = 0 to points/2: every y is put into the cell nearest to its x.
pub fn power_along(x: &[f64], y: &[f64], cell: f64, points: usize) -> Vec<f64> {
    let low = x.iter().copied().fold(f64::INFINITY, f64::min);
    let forward = PLANNER.with_borrow_mut(|planner| planner.forward(points));
    let mut cells = forward.make_input_vec();
    for (x, y) in x.iter().zip(y) {
        let at = ((x - low) / cell).round();
        if at.is_finite() {
            cells[at as usize % points] += y;
        }
    }
    let mut found = forward.make_output_vec();
    let _ = forward.process(&mut cells, &mut found);
    found.iter().map(Complex::norm_sqr).collect()
}

/// |Σ y e^(2πi ν x)|² at one ν.
pub fn power_at(x: &[f64], y: &[f64], frequency: f64) -> f64 {
    let (mut c, mut s) = (0.0, 0.0);
    for (x, y) in x.iter().zip(y) {
        let (sine, cosine) = (std::f64::consts::TAU * frequency * x).sin_cos();
        (c, s) = (c + cosine * y, s + sine * y);
    }
    c * c + s * s
}

/// The strongest between the neighbours of a grid point, `finer` steps to either side, and its power.
pub fn sharpened(near: f64, grid: f64, finer: i32, power: impl Fn(f64) -> f64) -> (f64, f64) {
    let tried = (-finer..=finer).map(|k| near + grid * f64::from(k) / f64::from(finer));
    tried.map(|f| (f, power(f))).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((near, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlation_is_the_sum() {
        let series: Vec<f64> = (0..23).map(|k| f64::sin(k as f64 * k as f64)).collect();
        let template = [0.5, -1.0, 0.25, 2.0];
        for (j, found) in correlate(&series, &template).iter().enumerate() {
            let sum: f64 =
                template.iter().enumerate().filter_map(|(i, t)| Some(series.get(j + i)? * t)).sum();
            assert!((found - sum).abs() < 1e-12);
        }
    }

    #[test]
    fn a_wave_along_anything_is_found_where_it_is() {
        let x: Vec<f64> = (0..300).map(|k| 1000.0 * f64::sin(k as f64 * 0.7)).collect();
        let y: Vec<f64> = x.iter().map(|x| (x / 7.3).cos()).collect();
        let (cell, points) = (2.0, 4096);
        let power = power_along(&x, &y, cell, points);
        let strongest = (1..power.len()).max_by(|a, b| power[*a].total_cmp(&power[*b])).expect("points");
        let grid = 1.0 / (points as f64 * cell);
        let (frequency, _) = sharpened(strongest as f64 * grid, grid, 16, |f| power_at(&x, &y, f));
        assert!((frequency * 7.3 * std::f64::consts::TAU - 1.0).abs() < 1e-3, "{frequency}");
    }
}
