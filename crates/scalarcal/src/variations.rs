//! Readings whose field hardly turns, beside a scalar magnetometer: rotations that determine each sensor are
//! missing, and a level with three slopes is what is seen (`paired::magnitude`). That gives the main field about
//! which the readings vary; what else explains the rest is looked for, clocks and temperatures and steps.

use common::number::{counted, significant, uncertain};
use common::{Axis, Code, Document, Finding, Noise, Quantity, ScalarCalibration, ScalarParameter};
use estimate::stats;
use explain::{Amplitude, Cause, Covariate};
use paired::magnitude::{Level, Readings};
use paired::{Acting, Asked};
use physics::{Basic, References, Unit};

use crate::directions::unmixed;
use crate::read::{Series, Source, along, read};
use crate::{Error, Options};

/// What is not determined, and what would determine it.
const OPEN: &str = "the field hardly turns in the sensors: their scale factors one by one and the angles between them are not determined, and the stated ones are kept; rotations in the field, or absolute measurements, would determine them";

/// Writes the main field to `calibration.sensors`, the rest to `calibration.scalar`; None for other readings.
pub fn calibrated(document: &Document, options: &Options) -> Result<Option<Document>, Error> {
    let (unit, series) = read(document, options)?;
    let suits = |one: &Series| one.source == Source::Scalar && one.time_s.is_some();
    if options.vector || !options.with.is_empty() || !series.iter().all(suits) {
        return Ok(None);
    }
    let readings = readings(document, &series, unit).sorted();
    if readings.turn() {
        return Ok(None);
    }
    let level = readings.level()?;
    let ids: Vec<String> = series.iter().map(|one| one.id.clone()).collect();
    let covariates = joined::beside(document, &ids);
    let asked = Asked { covariates: covariates.clone(), ..Asked::default() };
    let of = paired::find(&readings.pair(&level), asked, &|_| ())?.explained(&|_| ())?;
    let (base, last) = (&of.explained.base[0], of.problem.base.len());
    let level = level.fitted(base, last);
    let slope_std: [f64; 3] = std::array::from_fn(|axis| base[axis].1);
    let level_std = base[last].1;
    let (scale, added) = level.main_field(slope_std);
    let mut document = document.clone();
    let quantities = added.map(|(value, std)| Quantity::new(value, std));
    joined::state_main_field(&mut document, unit == Unit::Volt, scale, &quantities);
    let mut scalar = ScalarCalibration {
        recordings: ids,
        rows: readings.b.len() as u64,
        missing: series.iter().map(|one| one.missing as u64).sum(),
        reference: Source::Scalar.words().into(),
        rms_nt: stats::rms(&of.explained.residual[0]),
        rms_before_nt: Some(of_levels(&readings)),
        noise: Noise { white_rms_nt: Some(stats::rms(&of.explained.residual[0])), ..Noise::default() },
        parameters: parameters(&level, level_std, slope_std, added),
        rank: if level.alone { 1 } else { 4 },
        includes_body: true,
        ..ScalarCalibration::default()
    };
    scalar.findings.push(Code::NotDetermined.said(OPEN));
    if level.alone {
        let words =
            "the readings show no slopes but those of the stated calibration: only the level is fitted";
        scalar.findings.push(Code::LevelOnly.said(words));
    }
    scalar.findings.extend(explained(&of, &covariates));
    document.calibration.get_or_insert_default().scalar = Some(Box::new(scalar));
    Ok(Some(document))
}

/// The corrected readings of all recordings on the campaign's clock.
fn readings(document: &Document, series: &[Series], unit: Unit) -> Readings {
    let mut all = Readings::default();
    let unmix = unmixed(&Basic::found(document, unit).mu);
    for one in series {
        let start = document.recordings[one.index].start().zip(References::of(document).beginning_s);
        let clock = start.map_or(0.0, |(start, first)| start.unix_s - first);
        let [x, y, z] = along(document, unit, one);
        for (row, time_s) in one.time_s.iter().flatten().enumerate() {
            all.time_s.push(time_s + clock);
            all.b.push((unmix * nalgebra::Vector3::new(x[row], y[row], z[row])).into());
            all.scalar.push(one.magnitude_nt[row]);
        }
    }
    all
}

/// Rms of |b| − F about its mean, with the calibration as it was stated.
fn of_levels(readings: &Readings) -> f64 {
    let size = |b: &[f64; 3]| b[0].hypot(b[1]).hypot(b[2]);
    let left: Vec<f64> =
        readings.b.iter().zip(&readings.scalar).map(|(b, scalar)| size(b) - scalar).collect();
    let mean = stats::mean(&left);
    stats::rms(&left.iter().map(|value| value - mean).collect::<Vec<f64>>())
}

fn parameters(
    level: &Level,
    level_std: f64,
    slope_std: [f64; 3],
    added: [(f64, f64); 3],
) -> Vec<ScalarParameter> {
    let one = |name: String, unit: &str, (value, std): (f64, f64)| ScalarParameter {
        name,
        unit: unit.into(),
        value,
        std,
        std_alone: Some(std),
        std_with_known: None,
    };
    let mut all = vec![one("level of the magnitude".into(), "nT", (level.level_nt, level_std))];
    for (axis, slope) in Axis::ALL.into_iter().zip(level.slopes.into_iter().zip(slope_std)) {
        all.push(one(format!("slope of the magnitude with {axis}"), "nT/nT", slope));
    }
    for (axis, added) in Axis::ALL.into_iter().zip(added) {
        all.push(one(format!("main field beside the readings of {axis}"), "nT", added));
    }
    all
}

/// What explains the rest, in words.
fn explained(of: &paired::Explanation, covariates: &[Covariate]) -> Vec<Finding> {
    let mut said = Vec::new();
    let sized = |size: &Quantity| uncertain(size.value(), size.std().unwrap_or(0.0));
    for one in &of.explained.causes {
        match one.cause {
            Cause::Covariate(number) => {
                let (name, size) = (&covariates[number].name, sized(&one.channels[0][0]));
                let unit = common::unit::in_words(name);
                let words = format!("the rest follows `{name}` by {size} nT/{unit}");
                said.push(Code::Contribution.about(name).said(words));
            }
            Cause::Time => said.push(Code::Contribution.about("drift").said("the rest drifts with time")),
            Cause::Clock | Cause::Course(_) => {}
        }
    }
    if let Some(clock) = &of.clock {
        let words = format!("the scalar magnetometer's times are late by {} s", clock.difference.offset_s);
        said.push(Code::Contribution.about("clock").said(words));
    }
    let step = |one: &Amplitude| {
        let Cause::Course(number) = one.cause else { return None };
        let Acting::Step(at_s) = of.acting[number] else { return None };
        Some((at_s, one.channels[0][0].clone()))
    };
    let mut steps: Vec<(f64, Quantity)> = of.explained.causes.iter().filter_map(step).collect();
    steps.sort_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((at_s, size)) = steps.first() {
        let (count, size, at) = (counted(steps.len(), "step"), sized(size), significant(*at_s, 6));
        let words = format!("{count} in the rest, the first by {size} nT at {at} s");
        said.push(Code::Contribution.about("steps").said(words));
    }
    said
}
