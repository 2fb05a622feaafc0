//! The matrix and the difference, as a document has them.

use common::{
    Axis, DifferenceAxis, DifferentialCalibration, DifferentialFit, HeldOutPrediction, KeptOut, KeptOutEvent,
    MatrixElement, PerAxis, Quantity,
};

use crate::difference;
use crate::regression::{AxisFit, step_sizes};
use crate::{Error, contributions, words};
use joined::Pair;
use paired::prepare::Prepared;
use paired::residual::scatter;

/// Of a pair as it was recorded, and less what columns explain.
pub fn calibrate(
    (recorded, raw): (&Pair, &Pair),
    prepared: &Prepared,
    fits: &[AxisFit; 3],
    held_out: Option<HeldOutPrediction>,
) -> Result<DifferentialCalibration, Error> {
    let pair = &prepared.pair;
    let mut fit = DifferentialFit {
        recordings: pair.recordings.clone(),
        samples: pair.samples(),
        step_s: pair.step_s,
        missing: pair.whole.len() - pair.samples(),
        held_out,
        ..DifferentialFit::default()
    };
    fit.kept_out = kept_out(raw, prepared, fits);
    fit.clock = prepared.clock.clone();
    let [x, y, z] = fits;
    let axes = [of_axis(pair, 0, x)?, of_axis(pair, 1, y)?, of_axis(pair, 2, z)?];
    let mut calibration = assembled(fit, axes);
    if let Some(fit) = &mut calibration.fit {
        contributions::add((recorded, raw), prepared, &fits[0].follows, fit)?;
        fit.answer = words::answer(fit);
        fit.findings = words::findings(fit, &fits.each_ref().map(|found| found.wider));
        fit.findings.extend(words::unconfirmed(prepared.events.unconfirmed));
        fit.findings.extend(pair.told.iter().cloned());
        fit.findings.extend(pair.third.iter().map(|_| words::third()));
    }
    Ok(calibration)
}

/// η and the difference of one axis of the test instrument, as a document has them.
pub struct OfAxis {
    pub elements: [MatrixElement; 3],
    /// Covariance of η with that of each axis.
    pub covariances: [[[f64; 3]; 3]; 3],
    /// Mean of T − R η, nT.
    pub offset_nt: Quantity,
    pub described: DifferenceAxis,
}

fn of_axis(pair: &Pair, axis: usize, found: &AxisFit) -> Result<OfAxis, Error> {
    let source = &found.source;
    let described = difference::describe(&found.difference, &source.difference, &found.noise, pair.step_s)?;
    let follows = found.followed().into_iter();
    let described = DifferenceAxis {
        rms_left_nt: Some(scatter(&found.difference, &pair.whole)),
        drift: found.drift.clone(),
        follows: follows.map(|(follows, sizes)| follows.document(axis, &sizes)).collect(),
        weighted_up_to_hz: Some(found.noise.highest_hz()).filter(|highest| highest.is_finite()),
        ..described
    };
    let variance = described.rms_nt.powi(2);
    let elements = std::array::from_fn(|i| MatrixElement {
        least_squares: source.fit.least_squares[i],
        std_independent: (source.fit.independent[(i, i)] * variance).sqrt(),
        std_newey_west: Some(source.newey_west[i]),
        std_noise: source.fit.covariance[(i, i)].sqrt(),
        weighted: found.fit.weighted[i],
        weighted_std: found.fit.weighted_covariance[(i, i)].sqrt(),
        degrees_of_freedom: Some(found.freedom[i]).filter(|freedom| freedom.is_finite()),
    });
    // The mean of the noise is what is lowest in its spectrum: that of one over the length.
    let length_s = pair.whole.len() as f64 * pair.step_s;
    let lowest = found.noise.density(1.0 / length_s) / length_s;
    let offset_nt = Quantity::new(found.offset_nt, lowest.sqrt());
    Ok(OfAxis { elements, covariances: found.across, offset_nt, described })
}

/// The axes together; the covariance of the matrix runs column by column.
pub fn assembled(mut fit: DifferentialFit, axes: [OfAxis; 3]) -> DifferentialCalibration {
    fit.quoted = words::quoted();
    let covariance = (0..9).map(|k| axes[k / 3].covariances.iter().flat_map(|of| of[k % 3]).collect());
    let covariance = covariance.collect();
    let matrix = std::array::from_fn(|i| std::array::from_fn(|j| axes[j].elements[i].weighted));
    let mut offsets = PerAxis::default();
    for (axis, of) in Axis::ALL.into_iter().zip(axes) {
        for (from, element) in Axis::ALL.into_iter().zip(of.elements) {
            fit.elements.insert(format!("{from}{axis}"), element);
        }
        *offsets.entry(axis) = Some(of.offset_nt);
        *fit.axes.entry(axis) = Some(of.described);
    }
    DifferentialCalibration {
        matrix: Some(matrix),
        offset_nt: Some(offsets),
        covariance: Some(covariance),
        covariance_order: Some((0..9).map(|at| format!("matrix[{}][{}]", at % 3, at / 3)).collect()),
        fit: Some(Box::new(fit)),
        ..DifferentialCalibration::default()
    }
}

/// What was kept out, steps with their sizes under the fit.
fn kept_out(raw: &Pair, prepared: &Prepared, fits: &[AxisFit; 3]) -> KeptOut {
    let sizes = step_sizes(&prepared.events, fits);
    let events = prepared.events.found.iter().zip(sizes).map(|(event, size)| KeptOutEvent {
        kind: event.kind,
        instrument: event.instrument,
        axis: Axis::ALL[event.axis],
        time_s: raw.time_s(event.from),
        rows: [event.from, event.to],
        size_nt: size.unwrap_or_else(|| Quantity::new(event.size, event.std)),
        z: event.z(),
        extra: common::Extra::new(),
    });
    KeptOut {
        events: events.collect(),
        gaps: raw.gaps(),
        more: prepared.events.more,
        extra: common::Extra::new(),
    }
}
