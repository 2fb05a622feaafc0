//! Recordings in a field of which nothing is known but its length: what the sensors read, corrected, is held
//! against a scalar magnetometer beside them.
//!
//! The residual is |B| − F, B the corrected vector in SEN and F the scalar reading. The chain is run forwards
//! in a field S that is close to B: the smooth readings, corrected by the basic chain. It predicts p, and B =
//! S + (μᵀ)⁻¹ k (y − p), y the readings and k the sensitivities: exact for the basic chain, and with effects
//! one Newton step from a field that is off by what they do. Whatever moves the readings moves
//! |B| by its projection on S. A turn of all sensors together does not move it, nor, in first order, does anything across the field.
//! S is smooth so that what follows the field's rate does not follow the noise of the readings themselves.

use common::{Axis, procedure};
use estimate::stats::median;
use nalgebra::{Matrix3, Vector3};
use physics::{Basic, Context, EffectInstance, Prediction};
use rayon::prelude::*;

use crate::Error;
use crate::channel::{Channel, Reader, Run};

/// The column of the scalar magnetometer.
const COLUMN: &str = "reference_nt";

/// Whether a recording has the length of its field and nothing else of it: no drive, and no field around.
pub fn alone(run: &Run<'_>) -> bool {
    let recording = run.recording;
    let given = |axis: Axis| {
        let name = format!("ambient_{axis}_nt");
        recording.column(&name).is_some() || recording.conditions.extra.contains_key(&name)
    };
    recording.procedure == procedure::FREE_RUN
        && recording.column(COLUMN).is_some()
        && !run.setting.context.in_coils
        && !Axis::ALL.into_iter().any(given)
}

/// The magnitude of run number `run`, whose rows begin at `at` in the stack; the run then has its smooth
/// readings. None where a sensor was not read.
pub fn channel(of: &mut Run<'_>, run: usize, at: usize) -> Result<Option<Channel>, Error> {
    let unit = of.setting.context.unit.suffix();
    let columns = Axis::ALL.map(|axis| of.recording.axis_column("sensor", axis, unit));
    let ([Some(x), Some(y), Some(z)], Some(reference)) = (columns, of.recording.column(COLUMN)) else {
        return Ok(None);
    };
    if of.setting.basic.mu.try_inverse().is_none() {
        let error = physics::Error::InOnePlane { recording: of.recording.id.clone() };
        return Err(error.at(&of.path));
    }
    let readings: Vec<Vector3<f64>> =
        x.iter().zip(y).zip(z).map(|((x, y), z)| Vector3::new(*x, *y, *z)).collect();
    let rows: Vec<usize> = (0..readings.len())
        .filter(|row| reference[*row].is_finite() && readings[*row].iter().all(|value| value.is_finite()))
        .collect();
    of.smooth = match of.time_s {
        Some(time) => smooth(time, &readings),
        None => readings.clone(),
    };
    let mix = unmix(&of.setting.basic).transpose();
    let shares =
        rows.iter().map(|row| mix * field(&of.setting.basic, &of.smooth[*row]).normalize()).collect();
    Ok(Some(Channel {
        run,
        reader: Reader::Magnitude,
        column: COLUMN.into(),
        readings: rows.iter().map(|row| reference[*row]).collect(),
        to_nt: 1.0,
        at,
        vectors: rows.iter().map(|row| readings[*row]).collect(),
        nominal: Vector3::from(of.setting.basic.sensors.map(|sensor| sensor.sensitivity)),
        shares,
        rows,
    }))
}

/// What readings mean by the basic chain, SEN, nT.
pub fn field(basic: &Basic, readings: &Vector3<f64>) -> Vector3<f64> {
    let along = |i: usize| basic.sensors[i].sensitivity * readings[i] + basic.sensors[i].offset_nt;
    unmix(basic) * Vector3::from_fn(|i, _| along(i))
}

/// S, the field that a run's smooth readings mean, in GEO as the context has it.
pub fn ambient(run: &Run<'_>, basic: &Basic, context: &Context<'_>) -> Vec<Vector3<f64>> {
    let smooth = run.smooth.iter().enumerate();
    smooth.map(|(row, readings)| context.rotation(row).transpose() * field(basic, readings)).collect()
}

/// (μᵀ)⁻¹: from what is along the sensors to SEN.
fn unmix(basic: &Basic) -> Matrix3<f64> {
    basic.mu.transpose().try_inverse().unwrap_or_else(Matrix3::identity)
}

/// B in SEN at a channel's rows, nT.
fn corrected(channel: &Channel, basic: &Basic, prediction: &Prediction) -> Vec<Vector3<f64>> {
    let unmix = unmix(basic);
    let of = |(row, y): (&usize, &Vector3<f64>)| {
        let missed = y - prediction.readings[*row];
        prediction.field_sen[*row] + unmix * Vector3::from_fn(|i, _| basic.sensors[i].sensitivity * missed[i])
    };
    channel.rows.iter().zip(&channel.vectors).map(of).collect()
}

/// The length of the field that readings mean by a whole chain, solved for it as `correct` does, less the
/// scalar reading; none where they do not determine it.
pub fn solved(
    channel: &Channel,
    (basic, context): (&Basic, &Context<'_>),
    effects: &[EffectInstance],
) -> Option<Vec<f64>> {
    let mut readings = vec![Vector3::repeat(f64::NAN); context.rows];
    channel.rows.iter().zip(&channel.vectors).for_each(|(row, reading)| readings[*row] = *reading);
    let field = physics::field_in_sen(basic, effects, context, &readings).ok()?;
    let of = |(row, reference): (&usize, &f64)| field[*row].norm() - reference;
    Some(channel.rows.iter().zip(&channel.readings).map(of).collect())
}

/// How far along readings a length along b moves, in those units that the document's sensitivities make nT:
/// |k₀/k μᵀ b|, which is one with the document's calibration. Errors are those of readings: a residual in the
/// fitted nT would be least with sensors that feel nothing.
fn measure(channel: &Channel, basic: &Basic, field: &Vector3<f64>) -> f64 {
    let along = basic.mu.transpose() * field.normalize();
    Vector3::from_fn(|i, _| channel.nominal[i] / basic.sensors[i].sensitivity * along[i]).norm()
}

/// F − (|B| − F) in that measure: as far below the scalar reading as the corrected vector is longer, nT.
pub fn predicted(channel: &Channel, basic: &Basic, prediction: &Prediction) -> Vec<f64> {
    let corrected = corrected(channel, basic, prediction);
    let of = |(b, reference): (&Vector3<f64>, &f64)| {
        reference - (b.norm() - reference) * measure(channel, basic, b)
    };
    corrected.iter().zip(&channel.readings).map(of).collect()
}

/// The derivative of that: b · (μᵀ)⁻¹ k ∂p in that measure.
pub fn derivative(
    channel: &Channel,
    basic: &Basic,
    prediction: &Prediction,
    derivative: &Prediction,
) -> Vec<f64> {
    let mix = unmix(basic).transpose();
    let of = |row: &usize| {
        let field = &prediction.field_sen[*row];
        let along = mix * field.normalize() * measure(channel, basic, field);
        (0..3).map(|i| along[i] * basic.sensors[i].sensitivity * derivative.readings[*row][i]).sum()
    };
    channel.rows.iter().map(of).collect()
}

/// Rows to either side of one, tried in turn.
const REACHES: [usize; 5] = [2, 4, 8, 16, 32];
/// A signal that neighbours do not tell to this share of its length is too fast: it stays as sampled.
const TOLD: f64 = 1e-3;

/// The signal at times that rise; missing samples are filled from their neighbours. Of several widths the one
/// from which left-out samples are told best is taken (by the median, so that a few wild samples count no
/// more than others).
fn smooth(time_s: &[f64], samples: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let there: Vec<usize> =
        (0..samples.len()).filter(|row| samples[*row].iter().all(|value| value.is_finite())).collect();
    let tried = REACHES.iter().filter(|reach| 2 * **reach < there.len()).map(|reach| {
        let rows = (0..samples.len()).into_par_iter();
        let told: Vec<Local> = rows.map(|row| local(time_s, samples, &there, row, *reach)).collect();
        let missed: Vec<f64> = there.iter().map(|row| told[*row].missed(&samples[*row])).collect();
        (median(&missed), told)
    });
    let length = median(&there.iter().map(|row| samples[*row].norm()).collect::<Vec<_>>());
    let best = tried.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(missed, _)| *missed < TOLD * length);
    match best {
        Some((_, told)) => told.into_iter().map(|local| local.value).collect(),
        None => samples.to_vec(),
    }
}

/// A signal at one row, and the share of the row's own sample in it.
struct Local {
    value: Vector3<f64>,
    own: f64,
}

impl Local {
    /// How far a sample is from what its neighbours alone tell.
    fn missed(&self, sample: &Vector3<f64>) -> f64 {
        (sample - self.value).norm() / (1.0 - self.own).max(f64::EPSILON)
    }
}

/// The parabola through the samples that are there up to `reach` rows to either side, at a row; fewer towards
/// the ends, for beside its middle a parabola is off by the signal's third derivative.
fn local(time_s: &[f64], samples: &[Vector3<f64>], there: &[usize], row: usize, reach: usize) -> Local {
    let middle = there.partition_point(|other| *other < row);
    let reach = reach.min(middle).min(there.len() - 1 - middle.min(there.len() - 1)).max(REACHES[0]);
    let from = middle.saturating_sub(reach).min(there.len() - 2 * reach - 1);
    let window = &there[from..=from + 2 * reach];
    let span = time_s[window[2 * reach]] - time_s[window[0]];
    let powers = |at: usize| {
        let x = (time_s[at] - time_s[row]) / span;
        Vector3::new(1.0, x, x * x)
    };
    let (mut products, mut along) = (Matrix3::zeros(), Matrix3::zeros());
    for at in window {
        let powers = powers(*at);
        products += powers * powers.transpose();
        along += powers * samples[*at].transpose();
    }
    match products.try_inverse() {
        Some(inverse) => Local { value: (inverse * along).row(0).transpose(), own: inverse[(0, 0)] },
        None => Local { value: samples[row], own: 0.0 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wave of 40 samples a period with errors that alternate: half of them are gone, gaps are filled, and
    /// a signal of three samples a period is left alone.
    #[test]
    fn slow_signals_lose_their_noise_and_fast_ones_stay() {
        let time: Vec<f64> = (0..200).map(f64::from).collect();
        let wave = |period: f64, t: f64| Vector3::new((t / period).sin(), (t / period).cos(), 2.0) * 1000.0;
        let error = |row: usize| if row.is_multiple_of(2) { 0.1 } else { -0.1 };
        let mut samples: Vec<Vector3<f64>> =
            time.iter().enumerate().map(|(row, t)| wave(40.0, *t).add_scalar(error(row))).collect();
        samples[50] = Vector3::repeat(f64::NAN);
        let smooth_samples = smooth(&time, &samples);
        for (row, found) in smooth_samples.iter().enumerate().skip(4).take(190) {
            assert!((found - wave(40.0, time[row])).norm() < 0.09, "{row}: {found}");
        }
        let fast: Vec<Vector3<f64>> = time.iter().map(|t| wave(0.5, *t)).collect();
        assert_eq!(smooth(&time, &fast), fast);
    }
}
