//! The matrix and the difference, as a document has them.

use common::{
    Axis, DifferentialCalibration, DifferentialFit, HeldOutPrediction, KeptOut, KeptOutEvent, MatrixElement,
    PerAxis, Quantity,
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
    let rows = pair.whole.len();
    let mut fit = DifferentialFit {
        recordings: pair.recordings.clone(),
        samples: pair.samples(),
        step_s: pair.step_s,
        missing: rows - pair.samples(),
        quoted: words::quoted(),
        held_out,
        ..DifferentialFit::default()
    };
    let mut matrix = [[0.0; 3]; 3];
    let mut covariance = vec![vec![0.0; 9]; 9];
    let mut offsets = PerAxis::default();
    for (axis, found) in Axis::ALL.into_iter().zip(fits) {
        let j = axis.index();
        let source = &found.source;
        let mut described =
            difference::describe(&found.difference, &source.difference, &found.noise, pair.step_s)?;
        described.rms_left_nt = Some(scatter(&found.difference, &pair.whole));
        described.drift = found.drift.clone();
        described.follows =
            found.followed().into_iter().map(|(follows, sizes)| follows.document(j, &sizes)).collect();
        described.weighted_up_to_hz = Some(found.noise.highest_hz()).filter(|highest| highest.is_finite());
        let variance = described.rms_nt.powi(2);
        for (i, reference) in Axis::ALL.into_iter().enumerate() {
            matrix[i][j] = found.fit.weighted[i];
            for k in 0..3 {
                covariance[3 * j + i][3 * j + k] = found.fit.weighted_covariance[(i, k)];
            }
            for (m, across) in found.across.iter().enumerate().filter(|(m, _)| *m != j) {
                covariance[3 * j + i][3 * m..3 * m + 3].copy_from_slice(&across[i]);
            }
            let element = MatrixElement {
                least_squares: source.fit.least_squares[i],
                std_independent: (source.fit.independent[(i, i)] * variance).sqrt(),
                std_newey_west: Some(source.newey_west[i]),
                std_noise: source.fit.covariance[(i, i)].sqrt(),
                weighted: found.fit.weighted[i],
                weighted_std: found.fit.weighted_covariance[(i, i)].sqrt(),
                degrees_of_freedom: Some(found.freedom[i]).filter(|freedom| freedom.is_finite()),
            };
            fit.elements.insert(format!("{reference}{axis}"), element);
        }
        // The mean of the noise is what is lowest in its spectrum: that of one over the length.
        let lowest = found.noise.density(1.0 / (rows as f64 * pair.step_s)) / (rows as f64 * pair.step_s);
        *offsets.entry(axis) = Some(Quantity::new(found.offset_nt, lowest.sqrt()));
        *fit.axes.entry(axis) = Some(described);
    }
    fit.kept_out = kept_out(raw, prepared, fits);
    fit.clock = prepared.clock.clone();
    contributions::add((recorded, raw), prepared, &fits[0].follows, &mut fit)?;
    fit.answer = words::answer(&fit);
    fit.findings = words::findings(&fit, &fits.each_ref().map(|found| found.wider));
    fit.findings.extend(words::unconfirmed(prepared.events.unconfirmed));
    fit.findings.extend(pair.told.iter().cloned());
    fit.findings.extend(pair.third.iter().map(|_| words::third()));
    Ok(DifferentialCalibration {
        matrix: Some(matrix),
        offset_nt: Some(offsets),
        covariance: Some(covariance),
        covariance_order: Some(covariance_order()),
        fit: Some(Box::new(fit)),
        ..DifferentialCalibration::default()
    })
}

/// Places of the matrix in its covariance, column by column.
pub fn covariance_order() -> Vec<String> {
    (0..9).map(|at| format!("matrix[{}][{}]", at % 3, at / 3)).collect()
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
        z: event.z,
        extra: common::Extra::new(),
    });
    KeptOut {
        events: events.collect(),
        gaps: raw.gaps(),
        more: prepared.events.more,
        extra: common::Extra::new(),
    }
}
