//! Cubic pieces that do not overshoot.

/// Readings at rising times, read at other times within them: cubic pieces whose slopes are the weighted
/// harmonic means of those of the neighbouring chords, zero where these differ in sign, and at the ends of
/// three points, held to the chord's sign. Outside the times NaN.
///
/// Source: F. N. Fritsch and J. Butland, A method for constructing local monotone piecewise cubic
/// interpolants, SIAM J. Sci. Stat. Comput. 5 (1984) 300–304; as SciPy's `PchipInterpolator`.
pub fn pchip(time: &[f64], values: &[f64], at: &[f64]) -> Vec<f64> {
    let last = time.len() - 1;
    if last == 0 {
        return at.iter().map(|t| if *t == time[0] { values[0] } else { f64::NAN }).collect();
    }
    let width: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let chord: Vec<f64> = values.windows(2).zip(&width).map(|(pair, h)| (pair[1] - pair[0]) / h).collect();
    let slope: Vec<f64> = (0..=last)
        .map(|k| match k {
            _ if last == 1 => chord[0],
            0 => end_slope([width[0], width[1]], [chord[0], chord[1]]),
            _ if k == last => end_slope([width[k - 1], width[k - 2]], [chord[k - 1], chord[k - 2]]),
            _ if chord[k - 1] * chord[k] <= 0.0 => 0.0,
            _ => {
                let (before, after) = (2.0 * width[k] + width[k - 1], width[k] + 2.0 * width[k - 1]);
                (before + after) / (before / chord[k - 1] + after / chord[k])
            }
        })
        .collect();
    at.iter()
        .map(|t| {
            if !(time[0]..=time[last]).contains(t) {
                return f64::NAN;
            }
            let k = (time.partition_point(|known| known <= t).max(1) - 1).min(last - 1);
            let s = (t - time[k]) / width[k];
            let (rest, bend) = (1.0 - s, s * (1.0 - s));
            let ends = values[k] * rest * rest * (1.0 + 2.0 * s) + values[k + 1] * s * s * (3.0 - 2.0 * s);
            ends + width[k] * bend * (slope[k] * rest - slope[k + 1] * s)
        })
        .collect()
}

/// The slope at an end, from the two intervals next to it, the outer one first.
fn end_slope(width: [f64; 2], chord: [f64; 2]) -> f64 {
    let slope = ((2.0 * width[0] + width[1]) * chord[0] - width[0] * chord[1]) / (width[0] + width[1]);
    if slope * chord[0] <= 0.0 {
        0.0
    } else if chord[0] * chord[1] <= 0.0 && slope.abs() > 3.0 * chord[0].abs() {
        3.0 * chord[0]
    } else {
        slope
    }
}
