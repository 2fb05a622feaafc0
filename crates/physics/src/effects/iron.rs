use super::prelude::*;

const SOURCE: &str = "Leliak 1961, Identification and evaluation of magnetic-field sources of MAD equipped aircraft, IRE \
    Trans. ANE-8, 95";

/// A constant vector in GEO, nT.
pub struct HardIron;

impl Effect for HardIron {
    const ABOUT: About = About {
        name: "hard_iron",
        title: "magnetised iron near the coil",
        physics: "Something near the coil is magnetised: a constant field that does not turn with the sensor block.",
        equation: "dB_geo = h",
        source: SOURCE,
        family: Family::OutsideField,
        place: Place::Facility,
        stage: Stage::Geo,
        acts: Acts::Everything,
        parameters: &[
            ParameterInfo::amplitude("north_nt", 0.1, 1000.0),
            ParameterInfo::amplitude("east_nt", 0.1, 1000.0),
            ParameterInfo::amplitude("down_nt", 0.1, 1000.0),
        ],
        needs: &[],
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], _: &Surroundings<'_, T>) -> Result {
        let constant = Vector3::from_column_slice(parameters);
        signal.iter_mut().for_each(|field| *field += constant);
        Ok(())
    }
}

/// ΔB = S B in GEO, S in ppm.
pub struct SoftIron;

impl Effect for SoftIron {
    const ABOUT: About = About {
        name: "soft_iron",
        title: "iron near the coil is magnetised by its field",
        physics: "Iron near the coil takes on a magnetisation proportional to the field, and adds a field that is a \
            constant matrix times the coil's, fixed in GEO.",
        equation: "dB_geo = S B_geo 1e-6, S[row][column], row = component added",
        source: SOURCE,
        family: Family::OutsideField,
        place: Place::Facility,
        stage: Stage::Geo,
        acts: Acts::Everything,
        parameters: MATRIX,
        needs: &[],
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], _: &Surroundings<'_, T>) -> Result {
        add_matrix(parameters, signal);
        Ok(())
    }
}

/// The nine elements of a matrix, row by row.
pub(super) const MATRIX: &[ParameterInfo] = &[
    ParameterInfo::amplitude("xx_ppm", 1.0, 10_000.0),
    ParameterInfo::amplitude("xy_ppm", 1.0, 10_000.0),
    ParameterInfo::amplitude("xz_ppm", 1.0, 10_000.0),
    ParameterInfo::amplitude("yx_ppm", 1.0, 10_000.0),
    ParameterInfo::amplitude("yy_ppm", 1.0, 10_000.0),
    ParameterInfo::amplitude("yz_ppm", 1.0, 10_000.0),
    ParameterInfo::amplitude("zx_ppm", 1.0, 10_000.0),
    ParameterInfo::amplitude("zy_ppm", 1.0, 10_000.0),
    ParameterInfo::amplitude("zz_ppm", 1.0, 10_000.0),
];

/// B + S B with S in ppm, row by row.
pub(super) fn add_matrix<T: Real>(parameters: &[T], signal: &mut [Vector3<T>]) {
    let matrix = nalgebra::Matrix3::from_row_slice(parameters);
    for field in signal {
        let induced = matrix * *field;
        *field += induced * T::from(1e-6);
    }
}
