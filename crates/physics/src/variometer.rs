//! The field at an observatory from the readings of its variometer and the baseline.

use nalgebra::{Matrix3, Vector3};

/// What the three sensors of a variometer were set up along.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Components {
    /// Geographic north, east, down.
    #[default]
    Xyz,
    /// The magnetic meridian when it was set up, across it to the east, down: the field across has no constant
    /// part, and the declination of the meridian is a baseline.
    Hez,
}

impl Components {
    /// By the name in a document.
    pub fn of(name: &str) -> Option<Self> {
        match name {
            "xyz" => Some(Self::Xyz),
            "hez" => Some(Self::Hez),
            _ => None,
        }
    }

    /// The name in a document.
    pub fn name(self) -> &'static str {
        match self {
            Self::Xyz => "xyz",
            Self::Hez => "hez",
        }
    }

    /// The keys of the three baseline values.
    pub fn keys(self) -> [&'static str; 3] {
        match self {
            Self::Xyz => ["x_nt", "y_nt", "z_nt"],
            Self::Hez => ["h_nt", "d_deg", "z_nt"],
        }
    }

    /// The unit of each in that of the calculation: rad of one that is in degrees.
    pub fn units(self) -> [f64; 3] {
        self.keys().map(|key| if key.ends_with("_deg") { 1_f64.to_radians() } else { 1.0 })
    }

    /// The field north, east and down, nT, and its derivatives by the baseline values (INTERMAGNET Technical
    /// Reference Manual). Xyz: B = M + b. Hez, b in nT, rad, nT: B = Rz(b₂) (M₁ + b₁, M₂, M₃ + b₃).
    pub fn field_nt(
        self,
        reading_nt: &Vector3<f64>,
        baseline: &Vector3<f64>,
    ) -> (Vector3<f64>, Matrix3<f64>) {
        match self {
            Self::Xyz => (reading_nt + baseline, Matrix3::identity()),
            Self::Hez => {
                let (sin, cos) = baseline.y.sin_cos();
                let (along, across) = (reading_nt.x + baseline.x, reading_nt.y);
                let field = Vector3::new(
                    cos * along - sin * across,
                    sin * along + cos * across,
                    reading_nt.z + baseline.z,
                );
                let by = Matrix3::new(cos, -field.y, 0.0, sin, field.x, 0.0, 0.0, 0.0, 1.0);
                (field, by)
            }
        }
    }

    /// What the variometer reads in a field: the inverse of [`Components::field_nt`].
    pub fn reading_nt(self, field_nt: &Vector3<f64>, baseline: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Xyz => field_nt - baseline,
            Self::Hez => {
                let (sin, cos) = baseline.y.sin_cos();
                let along = cos * field_nt.x + sin * field_nt.y;
                let across = cos * field_nt.y - sin * field_nt.x;
                Vector3::new(along - baseline.x, across, field_nt.z - baseline.z)
            }
        }
    }

    /// The baseline values of readings that were taken in a known field.
    pub fn baseline(self, reading_nt: &Vector3<f64>, field_nt: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Xyz => field_nt - reading_nt,
            Self::Hez => {
                let horizontal = field_nt.x.hypot(field_nt.y);
                let along = (horizontal * horizontal - reading_nt.y * reading_nt.y).max(0.0).sqrt();
                let meridian = field_nt.y.atan2(field_nt.x) - reading_nt.y.atan2(along);
                Vector3::new(along - reading_nt.x, meridian, field_nt.z - reading_nt.z)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn baselines_lead_back_to_the_field() {
        let (reading, field) =
            (Vector3::new(21_007.0, 35.0, 43_850.0), Vector3::new(20_970.0, 1_590.0, 43_830.0));
        for components in [Components::Xyz, Components::Hez] {
            let baseline = components.baseline(&reading, &field);
            let (found, by) = components.field_nt(&reading, &baseline);
            assert!((found - field).norm() < 1e-8, "{components:?} {found}");
            let read = components.reading_nt(&field, &baseline);
            assert!((read - reading).norm() < 1e-8, "{components:?} {read}");
            for k in 0..3 {
                let at = |step: f64| components.field_nt(&reading, &(baseline + Vector3::ith(k, step))).0;
                let slope = (at(1e-4) - at(-1e-4)) / 2e-4;
                assert!((slope - by.column(k)).norm() < 1e-3, "{components:?} {k}");
            }
            assert_eq!(Components::of(components.name()), Some(components));
        }
    }
}
