//! |B| against a scalar by plain least squares, without any code of the stages: what a program's own count is held against.

use super::affine::least_squares;
use super::series::{Series, length};

/// What is left of vector less scalar in a part, nT, by constants fitted on another.
pub type ByHand = fn(fitted: &Series, part: &Series, offset_nt: [f64; 3]) -> Option<Vec<f64>>;

/// |v + offset| − reference of each row, nT.
pub fn mismatch(series: &Series, quantity: &str, offset_nt: [f64; 3]) -> Vec<f64> {
    let vectors = series.vectors(quantity).into_iter();
    let total = vectors.map(|v| length([0, 1, 2].map(|k| v[k] + offset_nt[k])));
    total.zip(series.column("reference_nt")).map(|(total, reference)| total - reference).collect()
}

/// The sum of columns by coefficients, row by row.
fn sum(columns: &[Vec<f64>], coefficients: &[f64]) -> Vec<f64> {
    let rows = columns.first().map_or(0, Vec::len);
    (0..rows).map(|row| columns.iter().zip(coefficients).map(|(column, c)| c * column[row]).sum()).collect()
}

/// A level and slopes along the three readings: all that nine constants do to |B|, to first order, where the
/// field points one way.
pub fn plane(fitted: &Series, part: &Series, offset_nt: [f64; 3]) -> Option<Vec<f64>> {
    let columns = |series: &Series| -> Vec<Vec<f64>> {
        let readings = ["x", "y", "z"].map(|axis| series.column(&format!("sensor_{axis}_nt")).to_vec());
        std::iter::once(vec![1.0; series.rows()]).chain(readings).collect()
    };
    let found = least_squares(&columns(fitted), &mismatch(fitted, "sensor", offset_nt))?;
    let left = mismatch(part, "sensor", offset_nt).into_iter().zip(sum(&columns(part), &found));
    Some(left.map(|(value, plane)| value - plane).collect())
}

/// How free an ellipsoid is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Three offsets and one scale.
    Sphere,
    /// Three offsets and three scales.
    AlongAxes,
    /// Three offsets, three scales and three angles.
    Full,
}

impl Shape {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Shape::Sphere => "a sphere by plain least squares",
            Shape::AlongAxes => "an ellipsoid along the axes by plain least squares",
            Shape::Full => "an ellipsoid by plain least squares",
        }
    }

    /// The coefficients of xx, yy, zz, xy, xz, yz, x, y, z that are alike, and those that are zero left out.
    fn alike(self) -> &'static [&'static [usize]] {
        match self {
            Shape::Sphere => &[&[0, 1, 2], &[6], &[7], &[8]],
            Shape::AlongAxes => &[&[0], &[1], &[2], &[6], &[7], &[8]],
            Shape::Full => &[&[0], &[1], &[2], &[3], &[4], &[5], &[6], &[7], &[8]],
        }
    }
}

/// F − magnitude of each row of a part by the full ellipsoid of another.
pub fn ellipsoid(fitted: &Series, part: &Series, offset_nt: [f64; 3]) -> Option<Vec<f64>> {
    let size = fitted.column("reference_nt").first().copied()?;
    let magnitudes = magnitudes(Shape::Full, fitted, part, offset_nt)?;
    Some(magnitudes.into_iter().map(|magnitude| size * (magnitude - 1.0)).collect())
}

/// Magnitudes of a part, over the one of the field, by an ellipsoid of another: (v + o)ᵀ Q (v + o) = F²,
/// solved as vᵀ Q' v + 2 b'ᵀ v = 1 with nine coefficients at most; a magnitude is √(vᵀ Q' v + 2 b'ᵀ v + c) /
/// √(1 + c) with c = b'ᵀ Q'⁻¹ b'. None where the form is that of no ellipsoid.
pub fn magnitudes(shape: Shape, fitted: &Series, part: &Series, offset_nt: [f64; 3]) -> Option<Vec<f64>> {
    let moved = |v: [f64; 3]| [0, 1, 2].map(|k| v[k] + offset_nt[k]);
    let size = fitted.vectors("sensor").into_iter().map(|v| length(moved(v))).fold(0.0, f64::max);
    let columns = |series: &Series| -> Vec<Vec<f64>> {
        let vectors: Vec<[f64; 3]> =
            series.vectors("sensor").into_iter().map(|v| moved(v).map(|value| value / size)).collect();
        let column = |value: fn(&[f64; 3]) -> f64| vectors.iter().map(value).collect();
        vec![
            column(|v| v[0] * v[0]),
            column(|v| v[1] * v[1]),
            column(|v| v[2] * v[2]),
            column(|v| 2.0 * v[0] * v[1]),
            column(|v| 2.0 * v[0] * v[2]),
            column(|v| 2.0 * v[1] * v[2]),
            column(|v| 2.0 * v[0]),
            column(|v| 2.0 * v[1]),
            column(|v| 2.0 * v[2]),
        ]
    };
    let all = columns(fitted);
    let together = |group: &&[usize]| -> Vec<f64> {
        (0..fitted.rows()).map(|row| group.iter().map(|k| all[*k][row]).sum()).collect()
    };
    let groups = shape.alike();
    let solved = least_squares(&groups.iter().map(together).collect::<Vec<_>>(), &vec![1.0; fitted.rows()])?;
    let mut found = [0.0; 9];
    for (group, value) in groups.iter().zip(solved) {
        group.iter().for_each(|k| found[*k] = value);
    }
    let [xx, yy, zz, xy, xz, yz, x, y, z] = found;
    let form = nalgebra::Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    if form.symmetric_eigenvalues().min() <= 0.0 {
        return None;
    }
    let centre = nalgebra::Vector3::new(x, y, z);
    let c = centre.dot(&(form.try_inverse()? * centre));
    let squares = sum(&columns(part), &found);
    Some(squares.into_iter().map(|square| ((square + c) / (1.0 + c)).sqrt()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::rms;

    /// Directions all over the sphere.
    fn directions() -> Vec<[f64; 3]> {
        let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        let direction = |k: u32| {
            let (height, azimuth) = (1.0 - f64::from(2 * k + 1) / 200.0, golden * f64::from(k));
            let across = (1.0 - height * height).sqrt();
            [across * azimuth.cos(), across * azimuth.sin(), height]
        };
        (0..200).map(direction).collect()
    }

    #[test]
    fn an_ellipsoid_off_its_centre_becomes_a_sphere() {
        let reading =
            |d: [f64; 3]| [1.1 * d[0] + 0.05 * d[1] + 0.2, 0.9 * d[1] - 0.1, d[2] + 0.3 + 0.02 * d[0]];
        let vectors: Vec<[f64; 3]> =
            directions().into_iter().map(|d| reading(d).map(|v| 50_000.0 * v)).collect();
        let series = Series::default()
            .with_vectors("sensor", &vectors)
            .with("reference_nt", vec![50_000.0; vectors.len()]);
        assert!(rms(mismatch(&series, "sensor", [0.0; 3])) > 1000.0);
        let left = ellipsoid(&series, &series, [0.0; 3]).expect("an ellipsoid");
        assert!(rms(left.iter().copied()) < 1e-6, "{}", rms(left));
        let of = |shape| {
            let all = magnitudes(shape, &series, &series, [0.0; 3]).expect("an ellipsoid");
            rms(all.into_iter().map(|magnitude| magnitude - 1.0))
        };
        let [sphere, along, full] = [Shape::Sphere, Shape::AlongAxes, Shape::Full].map(of);
        assert!(sphere > 1.5 * along && along > 1e6 * full, "{sphere} {along} {full}");
    }

    #[test]
    fn slopes_that_were_fitted_predict_other_rows() {
        let vectors: Vec<[f64; 3]> = directions()
            .into_iter()
            .map(|d| [20_000.0 + 30.0 * d[0], 20.0 * d[1], 45_000.0 + 10.0 * d[2]])
            .collect();
        let reference = vectors.iter().map(|v| length(*v) - 5.0 - 0.01 * (v[0] - 20_000.0)).collect();
        let series = Series::default().with_vectors("sensor", &vectors).with("reference_nt", reference);
        let (first, last) = (series.filter(|row| row < 100), series.filter(|row| row >= 100));
        let left = plane(&first, &last, [0.0; 3]).expect("a plane");
        assert!(rms(left.iter().copied()) < 1e-6, "{}", rms(left));
    }
}
