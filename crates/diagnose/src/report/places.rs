//! Where the difference lies.

use common::number::{bare, p_value};
use common::{DoubtfulValue, Quantity, Share};
use physics::{ParameterInfo, Place};
use std::collections::BTreeSet;

use super::effects::{followers, places_of};
use crate::Outcome;
use crate::algebra::square;
use crate::channel::Channel;
use crate::covariates::{self, on_coil};
use crate::model::{Model, Single};

pub(super) fn share(model: &Model<'_>, outcome: &Outcome, number: usize) -> Share {
    let found = &outcome.found[number];
    // Where the size of the noise is not known, squares in units of it say nothing of the whole.
    let (gain, excess) = if outcome.now.look.rest.omnibus().is_some() {
        let noise = outcome.now.look.rest.freedom * outcome.now.look.rest.scale();
        (found.gain, outcome.base.look.rest.sum_of_squares - noise)
    } else {
        (found.gain_nt2, square(&outcome.base.fit.residual) - square(&outcome.now.fit.residual))
    };
    let energy_share = Some((gain / excess.max(gain)).clamp(0.0, 1.0)).filter(|share| share.is_finite());
    let (effects, singles) = places_of(outcome, number);
    let Some(effect) = effects.clone().next().map(|at| &outcome.now.fit.state.effects[at]) else {
        let singles = outcome.now.fit.state.singles[singles].iter();
        let readings: Vec<DoubtfulValue> = singles.flat_map(|single| doubtful(model, single)).collect();
        let mut recordings: Vec<String> = readings.iter().map(|reading| reading.recording.clone()).collect();
        recordings.dedup();
        let description = found.name.clone();
        return Share { energy_share, readings, recordings, description, ..Share::default() };
    };
    let about = effect.kind.about();
    let acts = |run: usize| effects.clone().any(|at| outcome.now.fit.state.acts[at][run]);
    let runs = model.observed.runs.iter().enumerate().filter(|(run, _)| acts(*run));
    let frame = match effect.kind.place() {
        Place::Sensor | Place::Electronics | Place::Logger | Place::Spacecraft => "SEN",
        Place::Facility | Place::Environment | Place::Sites => "GEO",
    };
    let sensors = match effect.axis {
        Some(axis) => Some(axis).filter(|_| !on_coil(effect)).into_iter().collect(),
        None => effects.clone().next().map_or(Vec::new(), |at| followers(&outcome.parameters[at])),
    };
    let frequency = about.parameters.iter().position(|info| info.name == "frequency_hz");
    let moment = about.parameters.iter().position(ParameterInfo::is_moment);
    Share {
        place: Some(effect.kind.place().word().into()),
        sensors,
        frame: Some(frame.into()),
        covariates: covariates::recorded(model, effect),
        energy_share,
        recordings: runs.map(|(_, run)| run.recording.id.clone()).collect(),
        time_s: moment.map(|of| {
            let times = effects.map(|at| outcome.now.fit.state.effects[at].parameters[of]);
            times.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], t| [low.min(t), high.max(t)])
        }),
        band_hz: frequency.map(|at| [effect.parameters[at]; 2]),
        description: about.title.into(),
        ..Share::default()
    }
}

/// Which sensors and recordings show the difference, and what it follows.
pub(super) struct Guilty {
    pub channels: Vec<usize>,
    /// What it follows beside time.
    pub covariates: Vec<String>,
}

pub(super) fn guilty(model: &Model<'_>, places: &[Share]) -> Guilty {
    let shows = |channel: &Channel| {
        let id = &model.observed.runs[channel.run].recording.id;
        places.iter().any(|share| {
            let sensor =
                channel.axis().is_none_or(|axis| share.sensors.is_empty() || share.sensors.contains(&axis));
            sensor && (share.recordings.is_empty() || share.recordings.contains(id))
        })
    };
    let channels = &model.observed.channels;
    let covariates = places.iter().flat_map(|share| &share.covariates).filter(|name| *name != "time_s");
    Guilty {
        channels: (0..channels.len()).filter(|number| shows(&channels[*number])).collect(),
        covariates: covariates.cloned().collect::<BTreeSet<_>>().into_iter().collect(),
    }
}

/// A single reading where it stands in the document.
fn doubtful(model: &Model<'_>, single: &Single) -> Option<DoubtfulValue> {
    let channel = model.observed.channels.iter().find(|channel| channel.range().contains(&single.row))?;
    Some(DoubtfulValue {
        recording: model.observed.runs[channel.run].recording.id.clone(),
        column: channel.column.clone(),
        row: channel.rows[single.row - channel.at],
        departure_nt: Quantity::Bare(single.height_nt),
    })
}

pub(super) fn nameless_share(outcome: &Outcome, level: f64) -> Option<Share> {
    let line = outcome.now.look.line.as_ref().filter(|line| line.p < level / 3.0);
    let Some(structure) = outcome.now.look.structures.first() else {
        return line.map(|line| Share {
            recordings: vec![line.recording.clone()],
            band_hz: Some([line.frequency_hz; 2]),
            description: format!("a line at {} Hz", bare(line.frequency_hz)),
            ..Share::default()
        });
    };
    let rest = &outcome.now.look.rest;
    Some(Share {
        sensors: vec![structure.axis],
        covariates: vec![structure.covariate.clone()],
        energy_share: Some((structure.gain / rest.sum_of_squares).clamp(0.0, 1.0)),
        description: structure.name(),
        ..Share::default()
    })
}

pub(super) fn structure(outcome: &Outcome, level: f64) -> String {
    let mut words = Vec::new();
    if let Some(structure) = outcome.now.look.structures.first() {
        words.push(format!("{} ({})", structure.name(), p_value(structure.p_adjusted)));
    }
    if let Some(line) = outcome.now.look.line.as_ref().filter(|line| line.p < level / 3.0) {
        words.push(format!(
            "a line at {} Hz in \"{}\" ({})",
            bare(line.frequency_hz),
            line.recording,
            p_value(line.p)
        ));
    }
    words.extend(
        outcome.now.look.names.iter().take(3).map(|p| format!("looks like {} ({})", p.name, p_value(p.p))),
    );
    words.join("; ")
}
