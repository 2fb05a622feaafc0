//! Two magnetometers side by side: less what the document's model states already, and beside their declared noise.

use common::{Axis, Document, Instrument, Noise, NoiseOfSensors, Quantity};
use joined::Pair;
use noise::Whitening;
use physics::{References, Setting};

use super::{Compared, readings, rms};
use crate::Error;
use crate::level::Rest;
use crate::whitening::known_freedom;

/// Explains the difference of the instruments of a document's differential recordings.
pub fn compared(document: &Document, told: &dyn Fn(&str)) -> Result<Compared, Error> {
    let (frozen, document) = readings::without_frozen(document);
    let document = &less_effects(&document)?;
    let read = joined::read(document)?;
    let of = paired::find(&read, super::asked(document, &read.recordings), told)?.explained(told)?;
    let as_it_came = (0..3).map(|axis| rms(&stated(document, &read, axis, &of.rows))).collect();
    let channels = Axis::ALL.iter().map(|axis| (format!("test_{axis}_nt"), Some(*axis))).collect();
    let instruments = document.instrument.as_ref().zip(read.reference_noise.as_ref());
    let declared =
        instruments.and_then(|both| Declared::of(both, &of.problem.time_s, &of.explained.residual));
    Ok(Compared {
        declared,
        recordings: read.recordings.clone(),
        channels,
        what: "the test instrument",
        as_it_came,
        notes: read.told.into_iter().map(|told| told.words).collect(),
        coarse: readings::coarse(document),
        frozen,
        main_field: None,
        of,
    })
}

/// The difference with the stated matrix and offsets; with equal axes and levels where none are stated.
fn stated(document: &Document, pair: &Pair, axis: usize, rows: &[usize]) -> Vec<f64> {
    let known = document.calibration.as_ref().and_then(|calibration| calibration.differential.as_ref());
    let matrix = known.and_then(|known| known.matrix);
    let offset = known.and_then(|known| known.offset_nt.as_ref()?.get(Axis::ALL[axis])).map(Quantity::value);
    let predicted = |row: usize| match &matrix {
        Some(matrix) => (0..3).map(|i| matrix[i][axis] * pair.reference[i][row]).sum(),
        None => pair.reference[axis][row],
    };
    let left: Vec<f64> = rows.iter().map(|row| pair.test[axis][*row] - predicted(*row)).collect();
    let level = offset.unwrap_or_else(|| estimate::stats::mean(&left));
    left.iter().map(|value| value - level).collect()
}

/// The document with the test instrument's readings less what the effects of its model do to them, as the catalogue
/// predicts it from the reference's readings in the same recording; what cannot act there stays as it is.
fn less_effects(document: &Document) -> Result<Document, Error> {
    let effects = physics::adopt(document).map_err(|error| error.at("model"))?;
    let mut less = document.clone();
    if effects.is_empty() {
        return Ok(less);
    }
    let references = References::of(document);
    for (index, recording) in document.recordings.iter().enumerate() {
        let at = |error: physics::Error| error.at(&format!("recordings[{index}]"));
        let Setting { basic, context } = Setting::of(document, recording, references).map_err(at)?;
        if context.reference_nt.is_none() {
            continue;
        }
        let own: Vec<_> = effects.iter().filter(|effect| effect.acts(recording)).cloned().collect();
        let with = physics::predict_acting(&basic, &own, &context).map_err(at)?.0.readings;
        let without = physics::predict(&basic, &[], &context).map_err(at)?.readings;
        for axis in Axis::ALL {
            let Some(column) = less.recordings[index].columns.get_mut(&format!("test_{axis}_nt")) else {
                continue;
            };
            for (value, (with, without)) in column.iter_mut().zip(with.iter().zip(&without)) {
                *value -= with[axis.index()] - without[axis.index()];
            }
        }
    }
    Ok(less)
}

pub struct Declared {
    /// Rms of a reading of each axis, nT.
    pub rms_nt: Vec<f64>,
    /// What is left, whitened by it.
    pub rest: Rest,
}

impl Declared {
    /// Beside the residual of each axis (nT) at some times; None unless both instruments' noise is declared.
    pub fn of(
        (instrument, reference): (&Instrument, &NoiseOfSensors),
        time_s: &[f64],
        residual: &[Vec<f64>],
    ) -> Option<Self> {
        let code = instrument.quantisation_nt.unwrap_or(0.0) / 12.0_f64.sqrt();
        let length_s = time_s.last()? - time_s.first()?;
        let (mut noises, mut rms_nt, mut sum_of_squares, mut freedom) = (Vec::new(), Vec::new(), 0.0, 0.0);
        for (axis, residual) in Axis::ALL.into_iter().zip(residual) {
            let rounded = Noise { white_rms_nt: Some(code), ..Noise::default() };
            let both = [instrument.noise_of(axis)?.clone(), reference.of(axis)?.clone(), rounded];
            let whitening = Whitening::of_sum(&both, Some(time_s), time_s.len(), length_s).ok()?;
            rms_nt.push(whitening.variance_nt2().sqrt());
            sum_of_squares += whitening.whiten(residual).iter().map(|white| white * white).sum::<f64>();
            freedom += residual.len() as f64;
            noises.extend(both.into_iter().take(2).map(Some));
        }
        Some(Self { rms_nt, rest: Rest { sum_of_squares, freedom, known: known_freedom(&noises) } })
    }
}
