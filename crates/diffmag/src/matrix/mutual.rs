//! The fourteen parameters as a document has them: what is known of either instrument in, angles and ratios
//! out.

use common::{Angle, DifferentialCalibration, FourteenParameters, KnownInstrument, Magnetometer, Quantity};
use indexmap::IndexMap;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use physics::frames::{self, ARCSEC};

use crate::Error;
use crate::fourteen::{self, EtaCovariance, Fourteen, KNOWN_PATH, KnownFive, NAMES};

/// Pairs of axes, in the order of the fourteen's cosines.
const PAIRS: [&str; 3] = ["xy", "yz", "xz"];
/// The angles of instruments that stand as meant, in the order of the names, deg.
const NOMINAL_DEG: [Option<f64>; 9] =
    [None, Some(0.0), Some(0.0), Some(90.0), Some(90.0), Some(0.0), Some(90.0), None, Some(0.0)];

/// The fourteen of a matrix with its covariance. Where nobody said what is known, the reference is taken as
/// orthogonal, with equal scales.
pub fn parameters(
    calibration: &DifferentialCalibration,
    known: Option<&KnownInstrument>,
) -> Result<Option<FourteenParameters>, Error> {
    let (Some(matrix), Some(covariance)) = (&calibration.matrix, &calibration.covariance) else {
        return Ok(None);
    };
    let eta = frames::matrix(matrix);
    let covariance = EtaCovariance::from_fn(|i, j| covariance[i][j]);
    let stated = known.cloned().unwrap_or_default();
    let five = five(&stated)?;
    let found = fourteen::solve(&eta, &covariance, &five)?;
    let numerical = fourteen::solve_numerically(&eta, &five)?;
    Ok(Some(told(&found, &numerical, stated.instrument, known.is_none())))
}

/// The five as the closed form wants them. A reference is known by
///
/// sin γ cos α = sin ε_yz, sin γ sin α = (sin ε_xz − sin ε_xy sin ε_yz)/cos ε_xy, β = ε_xy
///
/// (the non-orthogonalities ε of fourteen.rs solved for its angles).
fn five(stated: &KnownInstrument) -> Result<KnownFive, Error> {
    if let Some(key) = stated.non_orthogonality_arcsec.keys().find(|key| !PAIRS.contains(&key.as_str())) {
        let path = format!("{KNOWN_PATH}.non_orthogonality_arcsec.{key}");
        return Err(Error::document(path, "a pair of axes of that name", "`xy`, `yz` or `xz`"));
    }
    let epsilon = PAIRS.map(|pair| {
        let given = stated.non_orthogonality_arcsec.get(pair);
        let of = |quantity: &Quantity| [quantity.value(), quantity.std().unwrap_or(0.0)];
        given.map_or([0.0; 2], of).map(|arcsec| arcsec * ARCSEC)
    });
    let ratio = |quantity: &Option<Quantity>| {
        quantity.as_ref().map_or([1.0, 0.0], |quantity| [quantity.value(), quantity.std().unwrap_or(0.0)])
    };
    let ratios = [ratio(&stated.ratio_x_y), ratio(&stated.ratio_z_y)];
    let [xy, yz, xz] = epsilon.map(|[value, _]| value);
    let mut jacobian = SMatrix::<f64, 5, 5>::identity();
    let ([a, b, c], derivatives) = match stated.instrument {
        Magnetometer::Test => {
            ([xy, yz, xz].map(f64::sin), Matrix3::from_diagonal(&Vector3::new(xy.cos(), yz.cos(), xz.cos())))
        }
        Magnetometer::Reference => {
            let toward_x = (xz.sin() - xy.sin() * yz.sin()) / xy.cos();
            let of_toward_x = [toward_x * xy.tan() - yz.sin(), -xy.tan() * yz.cos(), xz.cos() / xy.cos()];
            let rows = [of_toward_x, [0.0, yz.cos(), 0.0], [1.0, 0.0, 0.0]];
            ([toward_x, yz.sin(), xy], frames::matrix(&rows))
        }
    };
    jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&derivatives);
    let variances: Vec<f64> = epsilon.iter().chain(&ratios).map(|[_, std]| std * std).collect();
    let given = SMatrix::<f64, 5, 5>::from_diagonal(&SVector::<f64, 5>::from_column_slice(&variances));
    let [x_y, z_y] = ratios.map(|[value, _]| value);
    let covariance = jacobian * given * jacobian.transpose();
    Ok(KnownFive { instrument: stated.instrument, values: [a, b, c, x_y, z_y], covariance })
}

fn told(found: &Fourteen, numerical: &[f64; 14], known: Magnetometer, assumed: bool) -> FourteenParameters {
    let uncertainties = found.uncertainties();
    let short = |name: &str| name.trim_end_matches("_rad").trim_start_matches("ratio_").to_string();
    let ratio = |k: usize| (short(NAMES[k]), Quantity::new(found.values[k], uncertainties[k]));
    let angle = |k: usize| {
        let value_deg = found.values[k].to_degrees();
        Angle {
            value_deg,
            std_arcsec: uncertainties[k] / ARCSEC,
            off_nominal_arcsec: NOMINAL_DEG[k].map(|nominal| 3600.0 * (value_deg - nominal)),
        }
    };
    let orthogonality = |from: usize| -> IndexMap<String, Quantity> {
        (0..3)
            .map(|k| {
                let (cosine, std) = (found.cosines[from + k], found.cosine_uncertainties[from + k]);
                let sine = (1.0 - cosine * cosine).sqrt();
                let quantity = Quantity::new(cosine.asin() / ARCSEC, std / sine / ARCSEC);
                (PAIRS[k].to_string(), quantity)
            })
            .collect()
    };
    // Azimuths that mean nothing differ at will, and others by whole turns.
    let difference = |k: usize| {
        let difference = found.values[k] - numerical[k];
        let turned =
            if k < NOMINAL_DEG.len() { difference.sin().atan2(difference.cos()) } else { difference };
        if found.undetermined.contains(&NAMES[k]) { 0.0 } else { turned.abs() }
    };
    FourteenParameters {
        known,
        assumed,
        angles: (0..9).map(|k| (short(NAMES[k]), angle(k))).collect(),
        ratios: (9..14).map(ratio).collect(),
        undetermined: found.undetermined.iter().map(|name| short(name)).collect(),
        reference_non_orthogonality_arcsec: orthogonality(0),
        test_non_orthogonality_arcsec: orthogonality(3),
        numerical_difference_rad: (0..14).map(difference).fold(0.0, f64::max),
        ..FourteenParameters::default()
    }
}
