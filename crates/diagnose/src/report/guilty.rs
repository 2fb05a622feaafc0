//! Which sensors and recordings show the difference, and what it follows.

use common::Share;

use crate::channel::Channel;
use crate::model::Model;

pub(super) struct Guilty {
    /// Channels that show it.
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
    let channels =
        model.observed.channels.iter().enumerate().filter(|(_, c)| shows(c)).map(|(number, _)| number);
    let mut covariates: Vec<String> = places
        .iter()
        .flat_map(|share| share.covariates.iter().filter(|name| *name != "time_s").cloned())
        .collect();
    covariates.sort();
    covariates.dedup();
    Guilty { channels: channels.collect(), covariates }
}
