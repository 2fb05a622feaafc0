//! Sensors whose field hardly turns beside a scalar magnetometer: see `explain::magnitude`.

use common::{Document, Quantity};
use explain::Covariate;
use explain::magnitude::Readings;
use physics::Unit;

use super::{Compared, rms};
use crate::Error;
use crate::channel::{Channel, Reader};
use crate::magnitude;
use crate::observed::Observed;

/// Explains what the magnitude leaves, where the recordings do not determine the sensors one by one; None for
/// other documents.
pub fn compared(document: &Document, told: &dyn Fn(&str)) -> Result<Option<Compared>, Error> {
    let Ok(gathered) = joined::gathered(document) else { return Ok(None) };
    let (notes, document) = match &gathered {
        Some(gathered) => (gathered.told.clone(), &gathered.document),
        None => (Vec::new(), document),
    };
    let Ok(observed) = Observed::of(document) else { return Ok(None) };
    let timed = |channel: &Channel| channel.reader == Reader::Magnitude && observed.times(channel).is_some();
    if document.model.as_ref().is_some_and(|model| !model.effects.is_empty())
        || !observed.channels.iter().all(timed)
    {
        return Ok(None);
    }
    let rows = readings(&observed);
    if rows.turn() {
        return Ok(None);
    }
    let as_it_came: Vec<f64> =
        rows.b.iter().zip(&rows.scalar).map(|(b, scalar)| scalar - b[0].hypot(b[1]).hypot(b[2])).collect();
    let level = estimate::stats::mean(&as_it_came);
    let as_it_came: Vec<f64> = as_it_came.iter().map(|left| left - level).collect();
    let covariates = covariates(&observed);
    let found = rows.level();
    let pair = rows.pair(&found, covariates);
    let of = explain::pair::pair(&pair, told)?;
    let found = found.fitted(&of.explained.base[0], of.problem.base.len());
    let (scale, added) = found.main_field(std::array::from_fn(|axis| of.explained.base[0][axis].1));
    let volts = observed.runs.iter().any(|run| run.setting.context.unit == Unit::Volt);
    let mut notes = notes;
    notes.push(
        "the field hardly turns: a level and three slopes are determined, not the offset, scale factor and angles of each sensor; rotations or absolute measurements would"
            .into(),
    );
    Ok(Some(Compared {
        recordings: observed.runs.iter().map(|run| run.recording.id.clone()).collect(),
        channels: vec![("reference_nt".into(), None)],
        what: "the scalar magnetometer beside the sensors",
        as_it_came: vec![rms(&as_it_came)],
        notes,
        main_field: Some((volts, scale, added.map(|(value, std)| Quantity::new(value, std)))),
        ..Compared::of(&pair.covariates, of)
    }))
}

/// The readings of all recordings on one clock.
fn readings(observed: &Observed<'_>) -> Readings {
    let mut all = Readings::default();
    for channel in &observed.channels {
        let run = &observed.runs[channel.run];
        let clock = run.setting.context.clock_s;
        all.time_s.extend(observed.times(channel).into_iter().flatten().map(|t| t + clock));
        all.b.extend(channel.vectors.iter().map(|reading| {
            let field = magnitude::field(&run.setting.basic, reading);
            [field.x, field.y, field.z]
        }));
        all.scalar.extend(&channel.readings);
    }
    all.sorted()
}

/// What was recorded beside on the campaign's clock.
fn covariates(observed: &Observed<'_>) -> Vec<Covariate> {
    let mut all: Vec<Covariate> = Vec::new();
    for run in &observed.runs {
        let Some(time) = run.time_s else { continue };
        let clock = run.setting.context.clock_s;
        let beside = |name: &&String| {
            !name.starts_with("time_") && !name.ends_with("_nt") && !name.starts_with("sensor_x_v")
        };
        for name in run.recording.columns.keys().filter(beside) {
            let Some(values) = run.recording.column(name) else { continue };
            if ["sensor_x_v", "sensor_y_v", "sensor_z_v"].contains(&name.as_str()) {
                continue;
            }
            let known = time.iter().zip(values).filter(|(_, value)| value.is_finite());
            let (time_s, values): (Vec<f64>, Vec<f64>) = known.map(|(t, value)| (t + clock, *value)).unzip();
            match all.iter_mut().find(|have| have.name == *name && have.time_s.last() < time_s.first()) {
                Some(have) => {
                    have.time_s.extend(time_s);
                    have.values.extend(values);
                }
                None => all.push(Covariate { name: name.clone(), time_s, values }),
            }
        }
    }
    all.retain(|one| one.values.windows(2).any(|pair| pair[0] != pair[1]));
    all
}
