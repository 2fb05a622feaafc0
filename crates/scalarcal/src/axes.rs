//! Which axis each sensor is nearest to, and in which sense: swapped and mirrored channels.

use nalgebra::Matrix3;

use crate::model::AXES;

/// For each sensor the axis of the stated ones that it is nearest to, and the sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes([(usize, f64); 3]);

/// The axes nearest to directions that were found, each taken once: the assignment with the largest sum of
/// cosines.
pub fn nearest(mu: &Matrix3<f64>, stated: &Matrix3<f64>) -> Axes {
    let cosine = |sensor: usize, axis: usize| mu.column(sensor).dot(&stated.column(axis));
    let orders = [[0, 1, 2], [1, 0, 2], [0, 2, 1], [2, 1, 0], [1, 2, 0], [2, 0, 1]];
    let sum = |order: &[usize; 3]| (0..3).map(|sensor| cosine(sensor, order[sensor]).abs()).sum::<f64>();
    let best = orders.into_iter().max_by(|a, b| sum(a).total_cmp(&sum(b))).unwrap_or(orders[0]);
    Axes(std::array::from_fn(|sensor| (best[sensor], cosine(sensor, best[sensor]).signum())))
}

impl Axes {
    /// The stated directions in the order and with the signs that were found.
    pub fn mu(&self, stated: &Matrix3<f64>) -> Matrix3<f64> {
        let columns = self.0.map(|(axis, sign)| sign * stated.column(axis));
        Matrix3::from_columns(&columns)
    }

    /// What is odd about them, with the remedy.
    pub fn told(&self) -> Option<String> {
        let order = self.0.map(|(axis, _)| axis);
        let mirrored: Vec<&str> =
            (0..3).filter(|sensor| self.0[*sensor].1 < 0.0).map(|sensor| AXES[sensor]).collect();
        let swapped: Vec<&str> =
            (0..3).filter(|sensor| order[*sensor] != *sensor).map(|sensor| AXES[sensor]).collect();
        let along = |sensor: usize| {
            let (axis, sign) = self.0[sensor];
            format!("{} along {}{}", AXES[sensor], if sign < 0.0 { "−" } else { "" }, AXES[axis])
        };
        let all = [0, 1, 2].map(along).join(", ");
        let left_handed = self.mu(&Matrix3::identity()).determinant() < 0.0;
        match (swapped.as_slice(), mirrored.as_slice(), left_handed) {
            ([], [], _) => None,
            ([a, b], [], _) => Some(format!(
                "the channels of sensors {a} and {b} are swapped, or the sensors are mounted that way: exchange the two columns, or state the directions under calibration.axes.sensors"
            )),
            ([], [one], _) => Some(format!(
                "sensor {one} reads the field with the opposite sign: change the sign of its column, or state its direction under \
                 calibration.axes.sensors"
            )),
            (_, _, true) => Some(format!(
                "the axes are left-handed ({all}): channels are swapped or mirrored; exchange columns or change signs, or state the directions \
                 under calibration.axes.sensors"
            )),
            (_, _, false) => Some(format!(
                "the sensors are rotated relative to the axes of the attitude ({all}): state the directions under calibration.axes.sensors, or give \
                 the attitude of the sensors' own frame"
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn swapped_and_mirrored() {
        let unit = Matrix3::identity();
        let told = |columns: [Vector3<f64>; 3]| nearest(&Matrix3::from_columns(&columns), &unit).told();
        let [x, y, z] = [Vector3::new(1.0, 0.02, 0.0), Vector3::new(0.01, 1.0, 0.03), Vector3::z()];
        assert_eq!(told([x, y, z]), None);
        let contains = |columns, words: &str| told(columns).is_some_and(|told| told.contains(words));
        assert!(contains([y, x, z], "sensors x and y are swapped"));
        assert!(contains([x, y, -z], "sensor z reads the field with the opposite sign"));
        assert!(contains([y, z, -x], "left-handed"));
        assert!(contains(
            [y, -x, z],
            "rotated relative to the axes of the attitude (x along y, y along −x, z along z)"
        ));
    }
}
