//! Sensors whose field hardly turns beside a scalar magnetometer: see `paired::magnitude`.

use common::{Document, Quantity};
use nalgebra::Vector3;
use paired::magnitude::Readings;
use physics::{Setting, Unit};

use super::{Compared, readings, rms};
use crate::Error;
use crate::channel::{Channel, Reader};
use crate::observed::Observed;

/// Explains what the magnitude leaves where the sensors are not determined one by one; None for other documents.
pub fn compared(document: &Document, told: &dyn Fn(&str)) -> Result<Option<Compared>, Error> {
    let (frozen, document) = &readings::without_frozen(document);
    let Ok(gathered) = joined::gathered(document) else { return Ok(None) };
    let (mut notes, document) = match &gathered {
        Some(gathered) => {
            (gathered.told.iter().map(|told| told.words.clone()).collect::<Vec<_>>(), &gathered.document)
        }
        None => (Vec::new(), document),
    };
    let Ok(observed) = Observed::of(document) else { return Ok(None) };
    let timed = |channel: &Channel| channel.reader == Reader::Magnitude && observed.times(channel).is_some();
    if !observed.channels.iter().all(timed) {
        return Ok(None);
    }
    let still = |rows: &Readings| !rows.b.is_empty() && !rows.turn();
    let Some(rows) = corrected(document, &observed)?.filter(still) else { return Ok(None) };
    let as_it_came: Vec<f64> =
        rows.b.iter().zip(&rows.scalar).map(|(b, scalar)| scalar - b[0].hypot(b[1]).hypot(b[2])).collect();
    let level = estimate::stats::mean(&as_it_came);
    let as_it_came: Vec<f64> = as_it_came.iter().map(|left| left - level).collect();
    let recordings: Vec<String> = observed.runs.iter().map(|run| run.recording.id.clone()).collect();
    let found = rows.level()?;
    let asked = super::asked(document, &recordings);
    let of = paired::find(&rows.pair(&found), asked, told)?.explained(told)?;
    let found = found.fitted(&of.explained.base[0], of.problem.base.len());
    let (scale, added) = found.main_field(std::array::from_fn(|axis| of.explained.base[0][axis].1));
    let volts = observed.runs.iter().any(|run| run.setting.context.unit == Unit::Volt);
    notes.push(
        "the field hardly turns: a level and three slopes are determined, not the offset, scale factor and angles of each sensor; rotations or absolute measurements would"
            .into(),
    );
    Ok(Some(Compared {
        recordings,
        channels: vec![("reference_nt".into(), None)],
        what: "the scalar magnetometer beside the sensors",
        as_it_came: vec![rms(&as_it_came)],
        notes,
        coarse: readings::coarse(document),
        declared: None,
        frozen: frozen.clone(),
        main_field: Some((volts, scale, added.map(|(value, std)| Quantity::new(value, std)))),
        of,
    }))
}

/// All readings on one clock, corrected by calibration and model; None where the effects have no inverse.
fn corrected(document: &Document, observed: &Observed<'_>) -> Result<Option<Readings>, Error> {
    let effects = physics::adopt(document).map_err(|error| error.at("model"))?;
    let mut all = Readings::default();
    for channel in &observed.channels {
        let run = &observed.runs[channel.run];
        let Setting { basic, context } = &run.setting;
        let own: Vec<_> = effects.iter().filter(|effect| effect.acts(run.recording)).cloned().collect();
        let mut vectors = vec![Vector3::repeat(f64::NAN); run.recording.rows()];
        channel.rows.iter().zip(&channel.vectors).for_each(|(row, vector)| vectors[*row] = *vector);
        let Ok(field) = physics::field_in_sen(basic, &own, context, &vectors) else { return Ok(None) };
        let times = observed.times(channel).into_iter().flatten();
        for ((row, time_s), scalar) in channel.rows.iter().zip(times).zip(&channel.readings) {
            // Beyond the ends of a shifted clock nothing is known.
            if field[*row].iter().all(|value| value.is_finite()) {
                all.time_s.push(time_s + context.clock_s);
                all.b.push(field[*row].into());
                all.scalar.push(*scalar);
            }
        }
    }
    Ok(Some(all.sorted()))
}
