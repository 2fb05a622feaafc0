//! Even series at other times: band-limited interpolation.

use std::borrow::Cow;
use std::f64::consts::PI;
use std::sync::LazyLock;

use crate::linear::dot;

/// Shape of the Kaiser window for a stopband of −80 dB: β = 0.1102 (A − 8.7) (Kaiser 1974).
const BETA: f64 = 0.1102 * (80.0 - 8.7);
/// Half the length of the kernel, in steps of the slower series. With β it sets the passband's end.
const HALF: usize = 26;
/// The band that passes, in Nyquist frequencies of the slower series; the stopband begins as far beyond.
pub const PASSBAND: f64 = 0.9;
/// Points of the kernel's table for each step of the slower series; between them straight lines.
const TABLE: usize = 2048;
/// An output is missing when missing inputs have more than this share of the sum of the weights' sizes.
const MISSING: f64 = 0.1;
/// Two places with the same fraction of a row have the same weights.
const SAME_PHASE: f64 = 1e-6;

/// A series at its new times.
#[derive(Clone, Debug)]
pub struct Resampled {
    /// The columns; NaN where too much of what a value needs is missing.
    pub columns: Vec<Vec<f64>>,
    /// What passes of the rms of white noise: root of the mean over the outputs of Σ w².
    pub white_share: f64,
}

/// Columns of one even series, read at fractional rows `places`, after all above the slower series' Nyquist
/// frequency is taken out. `stretch` is the step of the output over that of the input, or 1 where it is less.
///
/// y(p) = Σ_k w_k x_k / Σ w_k, w_k = sinc(u) I₀(β √(1 − (u/26)²))/I₀(β), u = (p − k)/stretch, |u| ≤ 26.
///
/// The kernel's half-way point lies at the slower Nyquist frequency f_N. Up to 0.9 f_N the gain is 1 within
/// 2·10⁻⁴; from 1.1 f_N on less than 10⁻⁴ (−80 dB) is left. Between them what is damped is folded too.
///
/// A row with any NaN is missing in all columns. Missing rows count as straight lines between their
/// neighbours, rows beyond an end as the series turned about its last value; an output is NaN where such rows
/// have more than a tenth of Σ |w|, so that a missing row costs at most the two outputs beside it.
///
/// Source: J. F. Kaiser, Nonrecursive digital filter design using the I₀-sinh window function, Proc. IEEE
/// ISCAS 1974, 20–23.
pub fn resample<C: AsRef<[f64]>>(columns: &[C], places: &[f64], stretch: f64) -> Resampled {
    let columns: Vec<&[f64]> = columns.iter().map(AsRef::as_ref).collect();
    let rows = columns.first().map_or(0, |column| column.len());
    let missing: Vec<bool> = (0..rows).map(|k| columns.iter().any(|c| !c[k].is_finite())).collect();
    if missing.iter().all(|missing| *missing) {
        return Resampled {
            columns: vec![vec![f64::NAN; places.len()]; columns.len()],
            white_share: f64::NAN,
        };
    }
    let holes = missing.contains(&true);
    let bridged: Vec<Cow<'_, [f64]>> = columns
        .iter()
        .map(|column| if holes { bridged(column, &missing).into() } else { Cow::Borrowed(*column) })
        .collect();
    let stretch = stretch.max(1.0);
    let reach = HALF as f64 * stretch;
    let mut outputs = vec![Vec::with_capacity(places.len()); columns.len()];
    let (mut weights, mut phase, mut size, mut squares) = (Vec::new(), f64::NAN, 0.0, 0.0);
    let mut white = 0.0;
    for place in places {
        let first = (place - reach).ceil();
        // Whether the same weights serve as before; NaN at the first.
        let same = (place - first - phase).abs() < SAME_PHASE;
        if !same {
            phase = place - first;
            fill(&mut weights, &KERNEL, phase, stretch);
            size = weights.iter().map(|w| w.abs()).sum();
            squares = weights.iter().map(|w| w * w).sum();
        }
        white += squares / places.len() as f64;
        let first = first as i64;
        let inside = first >= 0 && first as usize + weights.len() <= rows;
        if inside {
            let (from, to) = (first as usize, first as usize + weights.len());
            let absent = (from..to).zip(&weights).filter(|(k, _)| missing[*k]);
            let lost: f64 = if holes { absent.map(|(_, w)| w.abs()).sum() } else { 0.0 };
            for (output, column) in outputs.iter_mut().zip(&bridged) {
                let sum = dot(&column[from..to], &weights);
                output.push(if lost > MISSING * size { f64::NAN } else { sum });
            }
        } else {
            let last = rows as i64 - 1;
            let row = |k: i64| if k < 0 { -k } else { 2 * last - k }.clamp(0, last) as usize;
            let absent = |k: i64| !(0..=last).contains(&k) || missing[k as usize];
            let lost: f64 =
                weights.iter().zip(first..).filter(|(_, k)| absent(*k)).map(|(w, _)| w.abs()).sum();
            for (output, column) in outputs.iter_mut().zip(&bridged) {
                let value = |k: i64| match k {
                    k if k < 0 => 2.0 * column[0] - column[row(k)],
                    k if k > last => 2.0 * column[last as usize] - column[row(k)],
                    k => column[k as usize],
                };
                let sum: f64 = weights.iter().zip(first..).map(|(w, k)| w * value(k)).sum();
                output.push(if lost > MISSING * size { f64::NAN } else { sum });
            }
        }
    }
    Resampled { columns: outputs, white_share: white.sqrt() }
}

/// Missing rows replaced by straight lines between their neighbours, constant at the ends.
fn bridged(column: &[f64], missing: &[bool]) -> Vec<f64> {
    let mut filled = column.to_vec();
    let mut known: Option<usize> = None;
    for row in 0..filled.len() {
        if missing[row] {
            continue;
        }
        let from = known.map_or(0, |before| before + 1);
        for (k, value) in filled[..row].iter_mut().enumerate().skip(from) {
            *value = known.map_or(column[row], |before| {
                let share = (k - before) as f64 / (row - before) as f64;
                column[before] + share * (column[row] - column[before])
            });
        }
        known = Some(row);
    }
    if let Some(last) = known {
        filled[last + 1..].fill(column[last]);
    }
    filled
}

/// The kernel at u = 0 … 26, [`TABLE`] points a step, and a zero beyond the end; made once.
static KERNEL: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let end = HALF * TABLE;
    let mut values: Vec<f64> = (0..=end)
        .map(|i| {
            let u = i as f64 / TABLE as f64;
            let sinc = if i == 0 { 1.0 } else { (PI * u).sin() / (PI * u) };
            let inside = 1.0 - (u / HALF as f64).powi(2);
            sinc * bessel_i0(BETA * inside.max(0.0).sqrt()) / bessel_i0(BETA)
        })
        .collect();
    values.push(0.0);
    values
});

/// Weights of the rows from the first within reach on, for a place `phase` rows after that; their sum is one.
fn fill(weights: &mut Vec<f64>, table: &[f64], phase: f64, stretch: f64) {
    weights.clear();
    let count = (phase + HALF as f64 * stretch).floor() as usize + 1;
    weights.extend((0..count).map(|k| {
        let at = ((phase - k as f64).abs() / stretch * TABLE as f64).min((table.len() - 2) as f64);
        let low = (at as usize).min(table.len() - 2);
        table[low] + (at - low as f64) * (table[low + 1] - table[low])
    }));
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= sum);
}

/// I₀(x) = Σ ((x/2)^k/k!)².
fn bessel_i0(x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
    while term > 1e-17 * sum {
        term *= (0.5 * x / k).powi(2);
        sum += term;
        k += 1.0;
    }
    sum
}
