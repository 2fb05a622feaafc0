//! What to record next, in words: what can be done where the recordings were made.

use crate::channel::Reader;
use crate::covariates::{self, ALONG, SUN};
use crate::observed::Observed;

/// Where recordings were made, by what can be done there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Site {
    /// In coils that are driven.
    Coils,
    /// In orbit: the Sun is recorded.
    Orbit,
    /// Beside a scalar magnetometer, no coils around.
    Scalar,
    /// By itself in the natural field.
    Alone,
}

impl Site {
    /// The site of recordings; of several kinds, the one at which most can be done.
    pub fn of(observed: &Observed<'_>) -> Self {
        let runs = observed.runs.iter();
        if runs.clone().any(|run| run.setting.context.in_coils) {
            return Site::Coils;
        }
        let sun = |name: &str| runs.clone().any(|run| run.setting.context.optional(name).is_some());
        if SUN.iter().any(|name| sun(name)) {
            Site::Orbit
        } else if observed.channels.iter().any(|channel| channel.reader == Reader::Magnitude) {
            Site::Scalar
        } else {
            Site::Alone
        }
    }

    /// What to record where no variation of a recording decides; `local`: all names are of single moments.
    pub fn ambiguous(self, local: bool) -> String {
        match (self, local) {
            (Site::Scalar, true) => "take an absolute measurement, or set another vector magnetometer beside it: the magnitude of the field does not show in which axis a step or a spike was"
                .into(),
            (Site::Alone, true) => "set a second magnetometer beside it, or take a neighbouring observatory's data of the same hours: one instrument alone cannot separate changes of the field from its own"
                .into(),
            _ => "vary the quantities that the alternatives follow independently, so that they are no longer collinear".into(),
        }
    }

    /// What to record where structure that follows a covariate has no name.
    pub fn unexplained(self, covariate: &str) -> String {
        let [of_time, of_temperature, of_field] = self.advice();
        let across = covariates::is_across(covariate);
        if covariate == "time_s" {
            of_time.into()
        } else if covariate.contains("temperature") {
            of_temperature.into()
        } else if across && self == Site::Coils {
            ACROSS.into()
        } else if across || covariate.contains(ALONG) {
            of_field.into()
        } else if self == Site::Coils {
            format!("change {covariate} alone, with the drive held")
        } else {
            format!("change {covariate} alone, everything else constant")
        }
    }

    /// What to record where structure follows time, a temperature, the field.
    fn advice(self) -> [&'static str; 3] {
        match self {
            Site::Coils => [
                "repeat the recording at another hour with all temperatures recorded and the drive held: an effect of time alone recurs at the same time after switching on",
                "ramp that temperature up and down at two rates with everything else held",
                "drive the coil along the sensor up and down at two rates with the others at zero, and with the sensor reversed",
            ],
            Site::Orbit => [
                "record another day of orbits with all temperatures and currents in the telemetry: an effect of the orbit recurs with it, a drift does not",
                "record orbits of another season, with other shadows and loads: that temperature then no longer follows the field",
                "record orbits in which the satellite has another attitude (a roll, a yaw), so that the field lies along each axis in turn",
            ],
            Site::Scalar => [
                "record another day with a temperature log at the sensor, and take an absolute measurement at its beginning and its end: the magnitude of the field alone does not show what drifts",
                "warm that sensor by some kelvin and let it cool, at two rates, beside the scalar magnetometer; at night, when the field is quiet",
                "turn the sensor slowly through all directions beside the scalar magnetometer; where it cannot be turned, record through a disturbed day, when the field varies most",
            ],
            Site::Alone => [
                "set a scalar magnetometer beside it, or take a neighbouring observatory's data of the same hours: one instrument alone cannot separate its drift from that of the field",
                "warm that sensor by some kelvin and let it cool, at two rates, at night, with a scalar magnetometer beside it: the field has a daily variation as well",
                "set a scalar magnetometer beside it and turn the sensor slowly through all directions: the field's own changes then cancel",
            ],
        }
    }
}

/// The same in coils, where structure follows the field across the sensor.
const ACROSS: &str = "drive the coil transverse to the sensor up and down with the others at zero, in two orientations of the block";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_follows_a_field_asks_for_other_directions() {
        let across = covariates::across(common::Axis::Y);
        for site in [Site::Coils, Site::Orbit, Site::Scalar, Site::Alone] {
            let [now, past] = [&across, &format!("the past of {across}")].map(|name| site.unexplained(name));
            let along = [ALONG, &format!("the past of {ALONG}")].map(|name| site.unexplained(name));
            assert!(now == past && along[0] == along[1]);
            assert_eq!(now != along[0], site == Site::Coils);
        }
    }

    #[test]
    fn no_coil_is_asked_for_where_there_is_none() {
        let across = covariates::across(common::Axis::Y);
        for covariate in ["time_s", "sensor_temperature_c", &across, ALONG, "load_a"] {
            let words = |site: Site| site.unexplained(covariate);
            for site in [Site::Orbit, Site::Scalar, Site::Alone] {
                let words = words(site);
                assert!(
                    !["coil", "drive", "block"].iter().any(|word| words.contains(word)),
                    "{site:?}: {words}"
                );
            }
            assert!(words(Site::Coils) != words(Site::Alone));
        }
    }
}
