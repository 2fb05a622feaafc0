//! What the statistics say, as a document has it.

use common::{
    AllanDeviation, Axis, Calibration, DifferenceAxis, DifferentialCalibration, DifferentialFit, Document,
    Drift, DriftForm, FORMAT_VERSION, MatrixElement, PerAxis, Quantity,
};

use estimate::stats;

use super::answer::{AxisFit, Estimate, StreamFit, answer};
use super::partial::Partial;
use crate::calibration::covariance_order;
use crate::drift::LEVEL;
use crate::{Error, mutual, words};

/// The document of a series of which only the statistics are left; fails as [`answer`] does.
pub fn document(partial: &Partial) -> Result<Document, Error> {
    let differential = calibration(&answer(partial)?)?;
    let calibration = Calibration { differential: Some(differential), ..Calibration::default() };
    Ok(Document { fluxcal: FORMAT_VERSION, calibration: Some(calibration), ..Document::default() })
}

fn quantity(estimate: Estimate) -> Quantity {
    Quantity::new(estimate.value, estimate.std)
}

fn calibration(found: &StreamFit) -> Result<DifferentialCalibration, Error> {
    let mut fit = DifferentialFit {
        recordings: vec![format!("from {} s to {} s", found.span_s[0], found.span_s[1])],
        samples: found.samples as usize,
        step_s: found.grid.step_s,
        missing: (found.missing + found.absent) as usize,
        quoted: words::quoted(),
        ..DifferentialFit::default()
    };
    let mut matrix = [[0.0; 3]; 3];
    let mut covariance = vec![vec![0.0; 9]; 9];
    let mut offsets = PerAxis::default();
    for (axis, of) in Axis::ALL.into_iter().zip(&found.axes) {
        let j = axis.index();
        for (i, reference) in Axis::ALL.into_iter().enumerate() {
            matrix[i][j] = of.weighted[i].value;
            for k in 0..3 {
                covariance[3 * j + i][3 * j + k] = of.weighted_covariance[i][k];
            }
            let element = MatrixElement {
                least_squares: of.least_squares[i].value,
                std_independent: of.least_squares[i].std,
                std_newey_west: None,
                std_noise: of.least_squares_std_noise[i],
                weighted: of.weighted[i].value,
                weighted_std: of.weighted[i].std,
                degrees_of_freedom: Some(of.weighted[i].freedom).filter(|freedom| freedom.is_finite()),
            };
            fit.elements.insert(format!("{reference}{axis}"), element);
        }
        *offsets.entry(axis) = Some(quantity(of.offset_nt));
        *fit.axes.entry(axis) = Some(difference(of));
        let octaves = of.octaves.iter().map(|octave| octave.agreement);
        *fit.octaves.get_or_insert_default().entry(axis) = Some(octaves.collect());
    }
    let mut differential = DifferentialCalibration {
        matrix: Some(matrix),
        offset_nt: Some(offsets),
        covariance: Some(covariance),
        covariance_order: Some(covariance_order()),
        fit: Some(Box::new(fit)),
        ..DifferentialCalibration::default()
    };
    differential.fourteen = mutual::parameters(&differential, None)?.map(Box::new);
    Ok(differential)
}

fn difference(of: &AxisFit) -> DifferenceAxis {
    let mut allan = AllanDeviation::default();
    for octave in &of.octaves {
        allan.push(0, octave.agreement.averaging_s, octave.allan_nt, octave.allan_interval_nt);
    }
    let amplitude = of.noise.flicker_nt2_per_hz_at_1hz;
    let density = amplitude.value.sqrt();
    DifferenceAxis {
        rms_nt: of.rms_nt,
        rms_interval_independent_nt: of.rms_interval_independent_nt,
        flicker_nt2_per_hz_at_1hz: quantity(amplitude),
        flicker_exponent: quantity(of.noise.flicker_exponent),
        white_rms_nt: quantity(of.noise.white_rms_nt),
        // √A has half the relative uncertainty of A.
        density_at_1hz_nt_per_sqrt_hz: Quantity::new(density, 0.5 * density * of.noise.flicker_log_std),
        allan,
        drift: drift(of.drift_nt_per_day),
        ..DifferenceAxis::default()
    }
}

/// A straight drift is the only one that the statistics show.
fn drift(slope: Estimate) -> Drift {
    let straight_p = stats::two_sided_p(slope.value / slope.std, slope.freedom);
    let demanded = if straight_p < LEVEL { DriftForm::Straight } else { DriftForm::None };
    Drift {
        demanded,
        level: LEVEL,
        straight_nt_per_day: quantity(slope),
        straight_p,
        exponential_p: 1.0,
        ..Drift::default()
    }
}
