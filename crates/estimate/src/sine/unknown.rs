//! Sines of unknown frequency along anything: lines along times, codes along readings.

use fourier::Complex;

use crate::line_search::largest;

/// Golden sections between the neighbours of a grid's frequency: to a thousandth of their distance.
const SECTIONS: usize = 16;

/// A series whose sines are sought.
#[derive(Clone, Debug)]
pub struct Series<'a> {
    /// Along what.
    pub x: Vec<f64>,
    /// Values.
    pub y: &'a [f64],
    /// What |Σ y e^(2πi ν x)|² of it counts.
    pub weight: f64,
}

/// The sine that stands out most.
#[derive(Clone, Copy, Debug)]
pub struct Strongest {
    /// ν.
    pub frequency: f64,
    /// Σ over the series of weight |Σ y e^(2πi ν x)|².
    pub power: f64,
    /// Width of the band of frequencies that were tried.
    pub band: f64,
}

/// The sine of the greatest power in a band of frequencies, in all of some series together: on the grid of
/// [`power_along`], then between its neighbours there. None without a frequency in the band.
pub fn strongest(
    series: &[Series<'_>],
    cell: f64,
    points: usize,
    (low, high): (f64, f64),
) -> Option<Strongest> {
    let grid = 1.0 / (points as f64 * cell);
    let (from, to) = ((low / grid).ceil() as usize, ((high / grid).floor() as usize).min(points / 2));
    let mut whole = vec![0.0; points / 2 + 1];
    for one in series {
        let power = power_along(&one.x, one.y, cell, points);
        whole.iter_mut().zip(power).for_each(|(sum, power)| *sum += one.weight * power);
    }
    let best = (from..=to).max_by(|a, b| whole[*a].total_cmp(&whole[*b]))?;
    let of = |frequency: f64| -> f64 {
        series.iter().map(|one| one.weight * power_at(&one.x, one.y, frequency)).sum()
    };
    let (frequency, power) = sharpened(best as f64 * grid, grid, of);
    Some(Strongest { frequency, power, band: (to - from + 1) as f64 * grid })
}

/// |Σ y e^(2πi ν x)|² over ν = k/(points·cell), k = 0 to points/2: every y is put into the cell nearest to its x.
pub fn power_along(x: &[f64], y: &[f64], cell: f64, points: usize) -> Vec<f64> {
    let low = x.iter().copied().fold(f64::INFINITY, f64::min);
    let mut cells = vec![0.0; points];
    for (x, y) in x.iter().zip(y) {
        let at = ((x - low) / cell).round();
        if at.is_finite() {
            cells[at as usize % points] += y;
        }
    }
    fourier::forward(cells).iter().map(Complex::norm_sqr).collect()
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

/// The strongest frequency between the neighbours of one of a grid, and its power.
pub fn sharpened(near: f64, grid: f64, power: impl Fn(f64) -> f64) -> (f64, f64) {
    let frequency = largest((near - grid, near + grid), SECTIONS, &power);
    (frequency, power(frequency))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_along_anything_is_found_where_it_is() {
        let x: Vec<f64> = (0..300).map(|k| 1000.0 * f64::sin(k as f64 * 0.7)).collect();
        let y: Vec<f64> = x.iter().map(|x| (x / 7.3).cos()).collect();
        let series = [Series { x: x.clone(), y: &y, weight: 2.0 / 300.0 }];
        let found = strongest(&series, 2.0, 4096, (0.001, 0.2)).expect("a sine");
        assert!((found.frequency * 7.3 * std::f64::consts::TAU - 1.0).abs() < 1e-3, "{found:?}");
        // No frequency beside it has more.
        let beside = |apart: f64| power_at(&x, &y, found.frequency + apart) / 150.0;
        assert!(found.power >= beside(2e-6).max(beside(-2e-6)), "{found:?}");
        assert!(strongest(&series, 2.0, 4096, (0.2, 0.1)).is_none());
    }
}
