//! Many points as few: means of neighbours, for plots.

/// Means of neighbouring points.
#[derive(Clone, Debug, PartialEq)]
pub struct Grouped {
    /// Mean of x, rising.
    pub x: Vec<f64>,
    /// Means of each column.
    pub columns: Vec<Vec<f64>>,
    /// Points in each mean; the last may have fewer.
    pub points: usize,
}

/// The points in rising order of x, neighbours together, so that at most `most` remain. Points of which x is
/// not finite are left out; None where all stand at one place.
pub fn grouped(x: &[f64], columns: &[&[f64]], most: usize) -> Option<Grouped> {
    let mut rows: Vec<usize> = (0..x.len()).filter(|row| x[*row].is_finite()).collect();
    rows.sort_by(|a, b| x[*a].total_cmp(&x[*b]));
    if x[*rows.first()?] == x[*rows.last()?] {
        return None;
    }
    let points = rows.len().div_ceil(most);
    let mean = |of: &[f64]| -> Vec<f64> {
        rows.chunks(points)
            .map(|some| some.iter().map(|row| of[*row]).sum::<f64>() / some.len() as f64)
            .collect()
    };
    Some(Grouped { x: mean(x), columns: columns.iter().map(|of| mean(of)).collect(), points })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_become_their_mean() {
        let found =
            grouped(&[3.0, 1.0, f64::NAN, 2.0, 9.0], &[&[30.0, 10.0, 7.0, 20.0, 90.0]], 2).expect("points");
        assert_eq!(found, Grouped { x: vec![1.5, 6.0], columns: vec![vec![15.0, 60.0]], points: 2 });
        assert_eq!(grouped(&[1.0, 1.0], &[&[1.0, 2.0]], 10), None);
        assert_eq!(grouped(&[f64::NAN], &[&[1.0]], 10), None);
    }
}
