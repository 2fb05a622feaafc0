use super::prelude::*;

impl Effect for HardIron {
    const ABOUT: About = About {
        name: "hard_iron",
        title: "magnetised iron near the coil",
        physics: "Something near the coil is magnetised: a constant field that does not turn with the sensor block.",
        equation: "dB_geo = h",
        source: "Leliak 1961, Identification and evaluation of magnetic-field sources of MAD equipped aircraft, IRE \
            Trans. ANE-8, 95",
        parameters: amplitudes!(0.1 to 1000.0: "north_nt", "east_nt", "down_nt"),
        ..About::of(Family::OutsideField, Place::Facility, Stage::Geo, Acts::Everything)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], _: &Surroundings<'_, T>) -> Result {
        let constant = Vector3::from_column_slice(parameters);
        signal.iter_mut().for_each(|field| *field += constant);
        Ok(())
    }
}

impl Effect for SoftIron {
    const ABOUT: About = About {
        name: "soft_iron",
        title: "iron near the coil is magnetised by its field",
        physics: "Iron near the coil takes on a magnetisation proportional to the field, and adds a field that is a \
            constant matrix times the coil's, fixed in GEO.",
        equation: "dB_geo = S B_geo 1e-6, S[row][column], row = component added",
        parameters: MATRIX,
        ..HardIron::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], _: &Surroundings<'_, T>) -> Result {
        add_matrix(parameters, signal);
        Ok(())
    }
}

/// The nine elements of a matrix, row by row.
pub(super) const MATRIX: &[ParameterInfo] = amplitudes!(
    1.0 to 10_000.0: "xx_ppm", "xy_ppm", "xz_ppm", "yx_ppm", "yy_ppm", "yz_ppm", "zx_ppm", "zy_ppm", "zz_ppm"
);

/// B + S B with S in ppm, row by row.
pub(super) fn add_matrix<T: Real>(parameters: &[T], signal: &mut [Vector3<T>]) {
    let matrix = nalgebra::Matrix3::from_row_slice(parameters);
    for field in signal {
        let induced = matrix * *field;
        *field += induced * T::from(1e-6);
    }
}
